# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What real sensors and loggers also do and EFFECTS.md does not list."""
from bench.frozen.kind import Kind
from bench.frozen.listed import Rng
from bench.frozen.plant import Plant
import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter


def late(values: np.ndarray, seconds: float | np.ndarray) -> np.ndarray:
    """Return values of each millisecond as they were so many seconds ago."""
    t = np.arange(len(values)) * 1e-3
    return np.interp(t - seconds, t, values)


def pressure_saturates(rng: Rng, base: Plant) -> Kind:
    knee = rng.uniform(0.2, 0.4) * base.p_top / 1e5

    def sensor(s: float) -> dict:
        return {'pump_outlet_pressure': lambda t, x, rows: np.where(
            x > knee, knee + (x - knee) * (1 - s), x)}
    return Kind('pressure_saturates', 'sensor', 3e-3, 0.95, sensor=sensor, heavy=True,
                parameters=lambda s: {'knee': knee * 1e5, 'lost_share': s},
                note='pressure reading bends before the end of its range')


def pressure_drops_bits(rng: Rng, base: Plant) -> Kind:
    def word(s: float) -> dict:
        bit, step = int(s), base.p_top / 1e5 / 4096

        def stuck(t: np.ndarray, x: np.ndarray, rows: np.ndarray) -> np.ndarray:
            code = np.rint(x / step).astype(int)
            return (code & ~(1 << bit)) * step
        return {'pump_outlet_pressure': stuck}
    return Kind('pressure_drops_bits', 'sensor', 3, 7, word=word, sizes=(4, 5, 6), neutral=20,
                parameters=lambda s: {'bit': int(s)},
                note='one bit of the converter is always 0')


def flow_reads_late(rng: Rng, base: Plant) -> Kind:
    mean = rng.uniform(0.5, 1.5)

    def sensor(s: float) -> dict:
        return {'motor_inlet_flow': lambda t, x, rows: late(uniform_filter1d(
            x, max(int(mean * s * 1e3), 1), mode='nearest'), s * (1 + 0.5 * mean))}
    return Kind('flow_reads_late', 'sensor', 5e-3, 2.0, sensor=sensor,
                needs=('motor_inlet_flow',),
                parameters=lambda s: {'dead_time': s, 'mean_over': mean * s},
                note='flow reading has a dead time and is a moving mean')


def pressure_drifts(rng: Rng, base: Plant) -> Kind:
    time, sign = rng.uniform(10, 60), rng.choice([-1.0, 1.0]) * base.p_top / 1e5
    return Kind('pressure_drifts', 'sensor', 3e-4, 0.05, sensor=lambda s: {
        'pump_outlet_pressure': lambda t, x, rows: x + s * sign * (1 - np.exp(-t / time))},
        parameters=lambda s: {'end': s * sign * 1e5, 'time': time},
        effects=('pressure_sensor_bias',), note='zero of the pressure reading drifts')


def thermometer_late(rng: Rng, base: Plant) -> Kind:
    time = rng.uniform(15, 60)

    def slow(t: np.ndarray, x: np.ndarray, rows: np.ndarray) -> np.ndarray:
        # It lags already as the log begins.
        keep = np.exp(-1e-3 / time)
        before = x[0] - 0.5 * (x[-1] - x[0])
        return lfilter([1 - keep], [1, -keep], x, zi=[keep * before])[0]
    return Kind('thermometer_late', 'sensor', 0.02, 1.3, lambda s: {'visc_share': s},
                sensor=lambda s: {'oil_temperature': slow}, wide=True,
                needs=('oil_temperature',), parameters=lambda s: {'lag': time},
                effects=('leakage_temperature',),
                note='leakage goes with the oil, whose thermometer sits in the tank')


def speed_misses_tooth(rng: Rng, base: Plant) -> Kind:
    width = rng.uniform(0.3, 1.0)
    return Kind('speed_misses_tooth', 'sensor', 3e-3, 0.9,
                lambda s: {'tooth': s, 'tooth_width': width}, slowest_ms=25,
                note='a tooth of the speed wheel is broken: a dip once per turn')


def flow_meter_slips(rng: Rng, base: Plant) -> Kind:
    q = rng.uniform(0.15, 0.5) * base.q_nominal * 6e4
    return Kind('flow_meter_slips', 'sensor', 5e-3, 1.0, needs=('motor_inlet_flow',),
                sensor=lambda s: {'motor_inlet_flow': lambda t, x, rows:
                                  x * (1 - s * np.exp(-np.maximum(x, 0) / q))},
                parameters=lambda s: {'share_at_0': s, 'flow': q / 6e4},
                effects=('flow_sensor_scale',), note='flow meter reads too little at low flow')


def torque_feels_angle(rng: Rng, base: Plant) -> Kind:
    share = rng.uniform(0.0, 0.6)

    def sensor(s: float) -> dict:
        from_pressure = s * share * base.t_nominal / base.p_top
        return {'load_torque': lambda t, x, rows: x + s * base.t_nominal * np.sin(rows[:, 10])
                + from_pressure * rows[:, 3]}
    return Kind('torque_feels_angle', 'sensor', 1e-3, 0.3, sensor=sensor, slowest_ms=40,
                needs=('load_torque',), parameters=lambda s: {
                    'amplitude': s * base.t_nominal, 'share_of_pressure': share},
                note='torque reading goes with the angle and with the pressure')


def stamps_part(rng: Rng, base: Plant) -> Kind:
    name = str(rng.choice(['motor_inlet_flow', 'load_torque', 'pump_outlet_pressure']))
    time = rng.uniform(30, 90)
    return Kind('stamps_part', 'sensor', 2e-3, 3.0, needs=(name,), sensor=lambda s: {
        name: lambda t, x, rows: late(x, s * t / time)},
        parameters=lambda s: {'late_per_s': s / time},
        note=f'clock of {name} is slow: its rows come later and later')


def torque_sample_held(rng: Rng, base: Plant) -> Kind:
    def sensor(s: float) -> dict:
        each = max(int(s * 1e3), 1)
        return {'load_torque': lambda t, x, rows: x[np.arange(len(x)) // each * each]}
    return Kind('torque_sample_held', 'sensor', 5e-3, 3.0, sensor=sensor, needs=('load_torque',),
                parameters=lambda s: {'hold': s},
                note='telemetry of the torque sensor repeats old readings')


KINDS = {f.__name__: f for f in (
    pressure_saturates, pressure_drops_bits, flow_reads_late, pressure_drifts, thermometer_late,
    speed_misses_tooth, flow_meter_slips, torque_feels_angle, stamps_part, torque_sample_held)}
