# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The sensor chain: sampling, delay, filter, effects that sit in a sensor, noise, resolution."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from .unit import BAR, CC, L_MIN, RPM

STANDARD = ('pump_command', 'pprv_command', 'speed_setpoint', 'oil_temperature',
            'pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque')
EXTRA = ('pump_speed', 'motor_inlet_pressure', 'case_drain_flow', 'pump_displacement',
         'motor_outlet_pressure')
# channel: header unit, size of that unit in SI, key of the noise in the datasheet's `sensors`
UNITS = {
    'pump_command': ('V', 1.0, None), 'pprv_command': ('V', 1.0, None),
    'speed_setpoint': ('rpm', RPM, None), 'oil_temperature': ('degC', 1.0, 'K'),
    'pump_outlet_pressure': ('bar', BAR, 'bar'), 'motor_inlet_pressure': ('bar', BAR, 'bar'),
    'motor_outlet_pressure': ('bar', BAR, 'bar'),
    'motor_inlet_flow': ('L/min', L_MIN, 'L_min'), 'case_drain_flow': ('L/min', L_MIN, 'L_min'),
    'motor_speed': ('rpm', RPM, 'rpm'), 'pump_speed': ('rpm', RPM, 'rpm'),
    'load_torque': ('N.m', 1.0, 'N_m'), 'pump_displacement': ('cc/rev', CC, 'cc'),
}
ALIAS = {'motor_inlet_pressure': 'pump_outlet_pressure', 'pump_speed': 'motor_speed',
         'motor_outlet_pressure': 'pump_outlet_pressure'}
OWN = {'case_drain_flow': (0.01, 0.005), 'pump_displacement': (0.02, 0.01)}


def noise_of(sheet: dict, channel: str) -> tuple[float, float]:
    """Return noise (one sigma) and resolution of a channel in its header unit."""
    if channel in OWN:
        return OWN[channel]
    unit = UNITS[channel][2]
    if unit is None:
        return 0.0, 0.0
    numbers = sheet['sensors'][ALIAS.get(channel, channel)]
    return numbers[f'noise_std_{unit}'], numbers[f'resolution_{unit}']


def reading(signal: dict[str, np.ndarray], channel: str, e: dict) -> np.ndarray:
    """Return what an ideal sensor with the hidden sensor effects reads (SI, 1 ms grid)."""
    x = signal[channel]
    value = e['si_parameters']
    if channel == 'pump_outlet_pressure':
        if 'p_bias' in value:
            spread = 0.95 + 0.05 * x / 50e5 if e['form']['p_bias'] == 'with_span' else 1.0
            x = x + value['p_bias'] * spread
        x = x + value.get('p_drift', 0.0) * (signal['oil_temperature'] - 50.0)
    elif channel == 'load_torque' and 'torque_scale' in value:
        bend = np.tanh(np.abs(x) / 60.0) if e['form']['torque_scale'] == 'bent' else 1.0
        x = x * (1 + value['torque_scale'] * bend)
    elif channel == 'motor_inlet_flow':
        full = 20 * L_MIN
        if 'flow_scale' in value:
            bend = 0.8 + 0.2 * x / full if e['form']['flow_scale'] == 'bent' else 1.0
            x = x * (1 + value['flow_scale'] * bend)
        if 'flow_square' in value:
            x = x + value['flow_square'] * x * (x / full - 1.0)
    return x


def sample_times(duration: float, rate: float, jitter: float, rng) -> np.ndarray:
    """Return the times of the rows (s): even, or with `jitter` (s, one sigma, held in order)."""
    t = np.arange(int(round(duration * rate))) / rate
    if jitter > 0.0:
        t = t + np.clip(rng.standard_normal(t.size) * jitter, -0.4 / rate, 0.4 / rate)
        t = np.clip(t, 0.0, duration)
    return t


def sample(signal: dict[str, np.ndarray], times: np.ndarray, sheet: dict, e: dict, rng,
           options: dict) -> dict[str, np.ndarray]:
    """
    Return the columns of a log ('name[unit]' to values) at the given times.

    `signal` holds SI values per millisecond, and `speed_noise` per 10 ms in rpm: where a row
    falls on a tick of the controller, both see the same reading.
    """
    grid = np.arange(signal['pump_command'].size) / 1000
    stamp = times + rng.standard_normal(times.size) * options['stamp_noise']
    if options['stamp_noise'] > 0.0:
        stamp = np.maximum.accumulate(stamp) + 1e-7 * np.arange(times.size)
    out = {'time[s]': np.round(stamp, 6)}
    ms = np.clip(np.floor(times * 1000 + 1e-6).astype(int), 0, grid.size - 1)
    for channel in options['channels']:
        unit, size, key = UNITS[channel]
        if key is None:
            out[f'{channel}[{unit}]'] = np.round(signal[channel][ms] / size, 6)
            continue
        x = reading(signal, channel, e)
        lag = options['sensor_filter']
        if lag > 0.0 and channel != 'motor_speed':
            a = np.exp(-1e-3 / lag)
            x = lfilter([1 - a], [1, -a], x, zi=[a * x[0]])[0]
        x = np.interp(times - options['delay'].get(channel, 0.0), grid, x) / size
        sigma, step = noise_of(sheet, channel)
        noise = rng.standard_normal(times.size) * sigma * options['noise']
        if channel == 'motor_speed':
            tick = np.round(times * 100).astype(int)
            same = (np.abs(times * 100 - tick) < 1e-6) & (tick < signal['speed_noise'].size)
            noise[same] = signal['speed_noise'][tick[same]]
        x = np.round((x + noise) / step) * step
        gaps = rng.random(times.size) < options['drop_out']
        x[gaps] = np.nan
        out[f'{channel}[{unit}]'] = np.round(x, 6)
    return out
