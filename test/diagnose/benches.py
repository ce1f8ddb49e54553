# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Benches of parts of a drive, with formulas of their own: hydromotor, pump, mass on a torque.

Nothing of the package is used but the recording and the loader of rig files. The forms differ
from those of the catalogue: a sharper sign of friction, an exponential Stribeck curve, a churning
loss that sets in with speed, leakage with a small part of the other kind.
"""
import math

from hst_drive.measure.run import Run
from hst_drive.rig import parse_rig
import numpy as np

RPM = 2 * math.pi / 60
DISPLACEMENT = 195e-6 / (2 * math.pi)
INERTIA = 0.35
SENSORS = {'motor_inlet_pressure': {'noise_std_bar': 0.12}, 'motor_speed': {'noise_std_rpm': 0.15},
           'motor_torque': {'noise_std_N_m': 0.5}, 'motor_inlet_flow': {'noise_std_L_min': 0.05},
           'pump_outlet_pressure': {'noise_std_bar': 0.12}, 'pump_speed': {'noise_std_rpm': 0.5}}
NOISE = {'motor_inlet_pressure': 0.12e5, 'pump_outlet_pressure': 0.12e5,
         'motor_speed': 0.15 * RPM, 'pump_speed': 0.5 * RPM, 'motor_torque': 0.5,
         'load_torque': 0.5, 'motor_inlet_flow': 0.05e-3 / 60, 'case_drain_flow': 0.005e-3 / 60}


def friction(kind, size, speed):
    """Return a friction torque that opposes rotation, N.m; ``size`` is that at 15 rad/s."""
    fast = np.abs(speed)
    sign = np.tanh(speed / 0.05)
    return sign * {
        'none': lambda: 0.0 * fast,
        'coulomb': lambda: size + 0.0 * fast,
        'viscous': lambda: size * (fast / 15.0)**0.95,
        'quadratic': lambda: size * np.maximum(fast - 0.5, 0.0)**2 / 14.5**2,
        'stribeck': lambda: size * np.exp(-fast / 2.5),
    }[kind]()


def noisy(name, time, exact, random):
    """Return a recording of exact channels (SI)."""
    return Run(name, time, {
        key: values + NOISE.get(key, 0.0) * random.standard_normal(len(time))
        for key, values in exact.items()}, f'{name}.csv')


def motor_rig(tables=True, **changes):
    """Return the rig file of a hydromotor alone."""
    motor = {'displacement_cc_rev': 195, 'inertia_total_kg_m2': INERTIA}
    if tables:
        motor['mechanical_efficiency'] = {
            'pressure_bar': [0, 10, 20, 40, 80, 200], 'speed_rpm': [0, 200],
            'table': [[value, value] for value in (0.5, 0.72, 0.82, 0.87, 0.89, 0.9)]}
        motor['leakage_L_min'] = {'pressure_bar': [0, 200], 'speed_rpm': [0, 200],
                                  'table': [[0, 0], [1.2, 1.3]]}
    motor.update(changes)
    return parse_rig({'motor': motor, 'sensors': SENSORS, 'tolerances_1_sigma_relative': {
        'motor.displacement': 0.004, 'motor.inertia': 0.08, 'motor.leakage': 0.08,
        'motor.mechanical_efficiency': 0.006}}, 'motor.yaml')


def efficiency(pressure):
    """Return the efficiency that the rig file's table holds."""
    return np.interp(pressure / 1e5, [0, 10, 20, 40, 80, 200], [0.5, 0.72, 0.82, 0.87, 0.89, 0.9])


def motor_bench(kind='none', size=12.0, seed=0, *, table=False, duration=60.0, rate=100,
                efficiency=efficiency, channels=()):
    """Return a log of a hydromotor on a bench: pressure, speed, shaft torque and flow."""
    random = np.random.default_rng(seed)
    if table:
        speed, pressure = (grid.ravel() for grid in np.meshgrid(
            np.linspace(5, 190, 9) * RPM, np.linspace(15, 150, 9) * 1e5))
        time, acceleration = np.arange(len(speed)), 0.0
    else:
        time = np.arange(int(duration * rate)) / rate
        speed, acceleration = np.zeros(len(time)), np.zeros(len(time))
        for level, period in ((6.0, 23.0), (2.5, 7.1), (1.0, 2.3)):
            angle = 2 * math.pi * time / period + random.uniform(0, 6)
            speed += level * np.sin(angle)
            acceleration += level * 2 * math.pi / period * np.cos(angle)
        speed += 9.7
        pressure = 1e5 * (70 + 35 * np.sin(2 * math.pi * time / 11.0)
                          + 15 * np.sign(np.sin(2 * math.pi * time / 5.3)))
    shaft = (efficiency(pressure) * pressure * DISPLACEMENT - friction(kind, size, speed)
             - 1.05 * INERTIA * acceleration)
    leak = (1.2 + 0.1 * speed / (200 * RPM)) * pressure / 200e5 * 1e-3 / 60
    exact = {'motor_inlet_pressure': pressure, 'motor_speed': speed, 'motor_torque': shaft,
             'motor_inlet_flow': 1.002 * DISPLACEMENT * speed + leak, 'case_drain_flow': leak}
    return noisy(f'motor {kind}', time, {key: exact[key] for key in (
        'motor_inlet_pressure', 'motor_speed', 'motor_torque', *channels)}, random)


def pump_rig(**changes):
    """Return the rig file of a pump of fixed displacement alone."""
    return parse_rig({'pump': {'max_displacement_cc_rev': 28, **changes}, 'sensors': SENSORS,
                      'tolerances_1_sigma_relative': {'pump.displacement_vs_command': 0.002}},
                     'pump.yaml')


def pump_bench(kind='laminar', low=5.0, high=200.0, seed=0, *, rows=90):
    """Return a table of operating points of a pump: speed, pressure, flow."""
    random = np.random.default_rng(seed)
    pressure = 1e5 * np.tile(np.linspace(low, high, rows // 6), 6)
    speed = RPM * np.repeat(np.linspace(600, 2200, 6), rows // 6)
    share = pressure / 100e5
    lost = {'none': 0.0 * share, 'laminar': share + 0.03 * share**2,
            'orifice': share**0.52}[kind] * 1.0e-3 / 60
    flow = 1.001 * 28e-6 / (2 * math.pi) * speed - lost
    return noisy(f'pump {kind}', np.arange(len(speed), dtype=float), {
        'pump_outlet_pressure': pressure, 'pump_speed': speed, 'motor_inlet_flow': flow}, random)


def drive_rig():
    """Return the rig file of a pump that is set and a hydromotor, with a load that is not told."""
    return parse_rig({
        'pump': {'shaft_speed_rpm': 1500, 'max_displacement_cc_rev': 71,
                 'displacement_vs_command': {'command_V': [0, 10],
                                             'displacement_cc_rev': [0, 71]},
                 'displacement_lag_s': 0.1, 'leakage_L_min': {'laminar_L_min_per_bar': 0.01}},
        'motor': {'displacement_cc_rev': 560,
                  'leakage_L_min': {'laminar_L_min_per_bar': 0.008}},
        'sensors': SENSORS, 'tolerances_1_sigma_relative': {
            'pump.displacement_vs_command': 0.006, 'motor.displacement': 0.004,
            'pump.leakage': 0.1, 'motor.leakage': 0.1}}, 'drive.yaml')


def drive(off=0.0, seed=0, waves=0.8):
    """Return a log of such a drive, whose displacement curve is ``off`` in some waves."""
    time, lag = np.arange(6000) / 100, 0.1
    command = 6.2 + 3.0 * np.sin(2 * math.pi * time / 17.0 + seed) + 0.5 * np.sin(
        2 * math.pi * time / 5.1)
    pressure = 1e5 * (90 + 50 * np.sin(2 * math.pi * time / 7.3)
                      + 20 * np.sin(2 * math.pi * time / 3.1 + 1))
    aim = command / 10 * 71e-6 / (2 * math.pi) * (
        1 + off * np.cos(2 * math.pi * waves * command / 10))
    stroke, kept = np.empty_like(aim), math.exp(-0.01 / lag)
    stroke[0] = aim[0]
    for k in range(1, len(aim)):
        stroke[k] = aim[k - 1] + kept * (stroke[k - 1] - aim[k - 1])
    flow = 1500 * RPM * stroke - 0.018e-3 / 60 * pressure / 1e5
    return noisy(f'drive {seed}', time, {
        'pump_command': command, 'pump_outlet_pressure': pressure,
        'motor_speed': flow * 2 * math.pi / 560e-6}, np.random.default_rng(seed))


def mass_rig():
    """Return the rig file of a mass alone."""
    return parse_rig({'motor': {'inertia_total_kg_m2': INERTIA}, 'sensors': SENSORS,
                      'tolerances_1_sigma_relative': {'motor.inertia': 0.05}}, 'mass.yaml')


def mass(kind='none', size=6.0, seed=0, *, duration=60.0, rate=100):
    """Return a log of a mass: the torque that drives it, held for a while each, and its speed."""
    random = np.random.default_rng(seed)
    fine, inner = 1e-3, 0.97 * INERTIA
    n = int(duration / fine)
    speed, value, torque = np.empty(n), 1.0, np.empty(n)
    goal = 0.0
    for k in range(n):
        if k % 2500 == 0:
            goal = random.uniform(1.0, 16.0)
        speed[k] = value
        # Whoever drives it holds a speed, roughly; the torque that this takes is known.
        torque[k] = np.clip(2.0 * (goal - value), -15, 15) + friction(kind, size, value)
        value += fine * (torque[k] - friction(kind, size, value)) / inner
    every = round(1 / rate / fine)
    return noisy(f'mass {kind}', np.arange(n)[::every] * fine, {
        'motor_torque': torque[::every], 'motor_speed': speed[::every]}, random)
