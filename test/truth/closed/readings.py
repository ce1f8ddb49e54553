# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the sensors of a campaign show: rate, noise, resolution, and effects that sit in them."""

from __future__ import annotations

import numpy as np

from .rigs import BAR, CC, L_MIN, RPM

# channel: column of the states, unit in the header, its size in SI, unit in the key of the noise
CHANNELS = {
    'pump_command': ('u', 'V', 1.0, None), 'valve_command': ('u', 'V', 1.0, None),
    'motor_displacement_command': ('small', 'V', 1.0, None),
    'speed_setpoint': ('setpoint', 'rpm', RPM, None),
    'oil_temperature': ('temperature', 'degC', 1.0, 'K'),
    'line_a_pressure': ('pa', 'bar', BAR, 'bar'), 'line_b_pressure': ('pb', 'bar', BAR, 'bar'),
    'pump_outlet_pressure': ('ps', 'bar', BAR, 'bar'),
    'charge_pressure': ('pc', 'bar', BAR, 'bar'), 'motor_speed': ('w_seen', 'rpm', RPM, 'rpm'),
    'motor_torque': ('torque', 'N.m', 1.0, 'N_m'), 'pump_torque': ('t_pump', 'N.m', 1.0, 'N_m'),
    'pump_speed': ('w_pump', 'rpm', RPM, 'rpm'),
    'pump_displacement': ('d_pump', 'cc/rev', CC, 'cc_rev'),
    'case_drain_flow': ('q_drain', 'L/min', L_MIN, 'L_min'),
}


def ideal(channel: str, x: np.ndarray, value: dict, form: dict) -> np.ndarray:
    """Return what a sensor without noise shows, with the hidden effects that sit in it (SI)."""
    if channel == 'line_a_pressure' and 'p_bias' in value:
        span = 0.9 + 0.1 * x / 100e5 if form['p_bias'] == 'with_span' else 1.0
        return x + value['p_bias'] * span
    if channel == 'motor_torque':
        if 'torque_scale' in value:
            full = np.max(np.abs(x))
            bend = np.tanh(2 * np.abs(x) / full) if form['torque_scale'] == 'bent' else 1.0
            x = x * (1 + value['torque_scale'] * bend)
        if form.get('t_const') == 'sensor_zero':
            x = x - value['t_const']
    return x


def sample(states: dict[str, np.ndarray], channels: list[str], rate: float, sheet: dict,
           value: dict, form: dict, rng: np.random.Generator,
           noise: float, delay: dict[str, float]) -> dict[str, np.ndarray]:
    """Return the columns 'name[unit]' of a log from states per ms (SI); ``delay`` is in s."""
    n = states['u'].size
    times = np.arange(int(n / 1000 * rate)) / rate
    at = np.round(times * 1000).astype(int)
    out = {'time[s]': np.round(times, 6)}
    for channel in channels:
        key, unit, size, quantity = CHANNELS[channel]
        late = np.maximum(at - round(1000 * delay.get(channel, 0.0)), 0)
        x = ideal(channel, states[key][late], value, form) / size
        if quantity:
            numbers = sheet['sensors'][channel]
            sigma = numbers[f'noise_std_{quantity}'] * noise
            step = numbers[f'resolution_{quantity}']
            if channel == 'motor_speed':
                x = x + states['noise'][at // 10] / RPM * (at % 10 == 0)
                x = x + rng.standard_normal(at.size) * sigma * (at % 10 != 0)
            else:
                x = x + rng.standard_normal(at.size) * sigma
            x = np.round(x / step) * step
        out[f'{channel}[{unit}]'] = np.round(x, 6)
    return out
