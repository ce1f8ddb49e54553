# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""One pump through its life: tables of operating points by a formula of its own, no model."""
import math

from hst_drive.effects.oil import viscosity
from hst_drive.measure.run import Run
import numpy as np

RPM, CC, L_MIN = 2 * math.pi / 60, 1e-6 / (2 * math.pi), 1e-3 / 60
FLOW_NOISE = 0.03 * L_MIN
TOLERANCES = {'pump.displacement_vs_command': 0.006, 'pump.leakage': 0.08}
UNIT = (1.004, 0.95)    # factors of this pump on its datasheet
MAKE = {
    'name': 'pump', 'pump': {
        'max_displacement_cc_rev': 28, 'leakage_L_min': {
            'pressure_bar': [0, 200], 'command_V': [0, 10], 'table': [[0, 0], [2.0, 2.0]]}},
    'line': {'oil_grade': 'ISO VG 46'},
    'sensors': {'motor_inlet_flow': {'noise_std_L_min': 0.03},
                'pump_outlet_pressure': {'noise_std_bar': 0.01},
                'pump_speed': {'noise_std_rpm': 0.01}},
    'tolerances_1_sigma_relative': TOLERANCES,
    'characterised_at_oil_temperature_degC': 50}


def columns(pressure, speed):
    """Return what the factors on displacement and leakage move: flow, m^3/s, per unit."""
    return np.column_stack([28 * CC * speed, -2.0 * L_MIN * pressure / 200e5])


def day(seed, leak=0.0, *, factors=UNIT, celsius=40.0, still=False, rows=240):
    """
    Return a day's log; ``leak`` is what the pump leaks beyond its table, L/min at 100 bar.

    ``still``: at one speed and pressure.
    """
    random = np.random.default_rng(seed)
    pressure = random.uniform(10, 190, rows) * 1e5
    speed = random.uniform(1000, 2000, rows) * RPM
    if still:
        pressure, speed = 150e5 + 1e-2 * pressure, 1500 * RPM + 1e-2 * speed
    flow = columns(pressure, speed) @ np.array(factors) - leak * L_MIN * pressure / 100e5
    return Run(f'day {seed}', np.arange(rows, dtype=float), {
        'pump_outlet_pressure': pressure, 'pump_speed': speed,
        'motor_inlet_flow': flow + FLOW_NOISE * random.standard_normal(rows),
        'oil_temperature': np.full(rows, 273.15 + celsius)}, f'day_{seed}.csv')


def plateaus(seed, leak=0.0, power=1.0):
    """
    Return a day at four loads near each other, of a pump that is off its sheet at each of them.

    ``leak``, L/min at 150 bar, goes with a ``power`` of the pressure beyond what leaked before.
    """
    random = np.random.default_rng(seed)
    rows = 200
    level = np.arange(rows) // 5 % 4
    pressure = np.array([146e5, 151e5, 156e5, 166e5])[level] + 1e4 * random.standard_normal(rows)
    speed = 1500 * RPM + 0.1 * random.standard_normal(rows)
    flow = columns(pressure, speed) @ np.array(UNIT) + L_MIN * (
        np.array([0.03, -0.015, 0.0, 0.02])[level] - leak * (pressure / 150e5)**power)
    return Run(f'day {seed}', np.arange(rows, dtype=float), {
        'pump_outlet_pressure': pressure, 'pump_speed': speed,
        'motor_inlet_flow': flow + FLOW_NOISE * random.standard_normal(rows)}, f'day_{seed}.csv')


BENCH = {
    'name': 'motor', 'motor': {
        'displacement_cc_rev': 160, 'mechanical_efficiency': 0.9,
        'leakage_L_min': {'laminar_L_min_per_bar': 0.005}},
    'sensors': {'motor_inlet_pressure': {'noise_std_bar': 0.05},
                'motor_torque': {'noise_std_N_m': 0.3}, 'motor_speed': {'noise_std_rpm': 0.1}},
    'tolerances_1_sigma_relative': {'motor.mechanical_efficiency': 0.01}}


DRAGGED = {**BENCH, 'motor': {**BENCH['motor'], 'mechanical_efficiency': {
    'coulomb_N_m': 5, 'viscous_N_m_s_per_rad': 0.25, 'pressure_share': 0.03}}}


def braked(seed, celsius, *, drag=False, friction=0.0, scale=1.0, rows=240):
    """
    Return a day of a hydromotor on the bench.

    What it loses of its torque follows the viscosity: all of it hardly, or of a ``drag`` the part
    that goes with the speed. There may be more ``friction``, N.m; the torque reads ``scale``.
    """
    random = np.random.default_rng(seed)
    pressure = random.uniform(20, 180, rows) * 1e5
    thick = viscosity(273.15 + celsius, 'ISO VG 46') / viscosity(323.15, 'ISO VG 46')
    speed, ideal = random.uniform(20, 100, rows), 160 * CC * pressure
    torque = 0.97 * ideal - 5.0 - 0.25 * thick**0.3 * speed if drag else (
        1.0 - 0.1 * thick**0.06) * ideal
    torque -= friction
    return Run(f'day {seed}', np.arange(rows, dtype=float), {
        'motor_inlet_pressure': pressure, 'motor_speed': speed,
        'motor_torque': scale * torque + 0.3 * random.standard_normal(rows),
        'oil_temperature': np.full(rows, 273.15 + celsius)}, f'day_{seed}.csv')


def warming(seed, first, last, power, leak=0.0):
    """Return a day on which the oil warms up, degC, and all leakages with it by a power."""
    run = day(seed, leak)
    kelvin = 273.15 + np.linspace(first, last, len(run))
    thin = viscosity(313.15, 'ISO VG 46') / viscosity(kelvin, 'ISO VG 46')
    table = columns(run['pump_outlet_pressure'], run['pump_speed'])[:, 1]
    lost = UNIT[1] * table - leak * L_MIN * run['pump_outlet_pressure'] / 100e5
    run.channels['motor_inlet_flow'] += lost * (thin**power - 1.0)
    run.channels['oil_temperature'] = kelvin
    return run
