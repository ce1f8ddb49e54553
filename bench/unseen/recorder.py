# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Sensors and logger: what the drive does becomes readings, and readings become a file."""
from math import exp
from pathlib import Path

from bench.unseen.machine import BAR, L_MIN, RPM
from bench.unseen.profiles import Commands, CONVERTER
from bench.unseen.stepper import SEEN_P, SEEN_Q, SEEN_T, SEEN_W, TICK, U
import numpy as np
from scipy.signal import lfilter

# Name, unit of the log and of the datasheet's sensor, and what one of it is in SI.
SENSORS = {
    'pump_outlet_pressure': ('bar', 'bar', BAR),
    'motor_inlet_flow': ('L/min', 'L_min', L_MIN),
    'motor_speed': ('rpm', 'rpm', RPM),
    'load_torque': ('N.m', 'N_m', 1.0),
}


def _lagged(values: np.ndarray, seconds: float) -> np.ndarray:
    """Return values behind a lag of first order that is settled at the start."""
    if seconds <= 0:
        return values
    keeps = exp(-TICK / seconds)
    return lfilter([1 - keeps], [1, -keeps], values, zi=[keeps * values[0]])[0]


def _behind_play(values: np.ndarray, width: float) -> np.ndarray:
    """Return what hangs behind the values by half a width."""
    out, now, half = np.empty(len(values)), values[0], 0.5 * width
    for i, value in enumerate(values.tolist()):
        now = min(max(now, value - half), value + half)
        out[i] = now
    return out


def _holding(values: np.ndarray, longest: float, seed: int) -> np.ndarray:
    """Return values that keep their last reading for random times."""
    rng, out, at = np.random.default_rng(seed), values.copy(), 0
    while longest > 0:
        at += int(rng.exponential(2.5) / TICK) + 1
        if at >= len(values):
            break
        until = at + int(rng.uniform(0.2, 1) * longest / TICK)
        out[at:until] = values[at]
        at = until
    return out


def seen(out: np.ndarray, extra: dict, event: np.ndarray, since: float, total: float,
         seed: int) -> dict[str, np.ndarray]:
    """Return what the sensors make of a run, in SI, before noise and resolution."""
    def own(name: str, neutral: float = 0.0) -> float:
        return extra.get('sensor.' + name, neutral)

    pressure, flow = out[:, SEEN_P], out[:, SEEN_Q]
    speed, torque = out[:, SEEN_W], out[:, SEEN_T]
    ticks = len(out)
    pressure = _lagged(pressure, own('pressure_lag')) + own('pressure_bias')
    if own('pressure_spikes'):
        wild = np.random.default_rng(seed).standard_normal(ticks)
        pressure = pressure + own('pressure_spikes') * wild * event
    pressure = np.minimum(pressure, own('pressure_limit', np.inf))
    late = round(own('flow_delay') / TICK)
    if late:
        flow = np.concatenate([np.full(late, flow[0]), flow[:-late]])
    flow = _lagged(flow * own('flow_scale', 1.0), own('flow_lag'))
    flow = np.where(np.abs(flow) < own('flow_floor'), 0.0, flow)
    width = round(own('speed_mean') / TICK)
    if width > 1:
        padded = np.concatenate([np.full(width - 1, speed[0]), speed])
        sums = np.cumsum(np.insert(padded, 0, 0.0))
        held = (sums[width:] - sums[:-width]) / width
    else:
        held = speed
    if own('torque_play'):
        torque = _behind_play(torque, own('torque_play'))
    torque = torque * (own('torque_scale', 1.0) + own('torque_bend') * torque)
    torque = torque + own('torque_zero') + own('torque_speed') * (speed / 10) ** 2
    torque = torque + own('torque_drift') * (since + np.arange(ticks) * TICK) / total
    return {'pump_outlet_pressure': pressure, 'motor_inlet_flow': flow,
            'motor_speed': _holding(held, own('speed_hold'), seed), 'load_torque': torque}


def noise_of(sheet: dict) -> dict[str, float]:
    """Return the standard deviation of each sensor's noise, in SI."""
    return {name: sheet['sensors'][name]['noise_std_' + unit] * si
            for name, (_, unit, si) in SENSORS.items()}


def _measured(values: np.ndarray, sensor: dict, unit: str, rng) -> np.ndarray:
    """Return values in the unit of the datasheet with noise and resolution."""
    noisy = values + sensor['noise_std_' + unit] * rng.standard_normal(len(values))
    noisy = np.clip(noisy, *sensor['range_' + unit]) if 'range_' + unit in sensor else noisy
    step = sensor['resolution_' + unit]
    return np.round(noisy / step) * step


def rows(ticks: int, before: int, every: int, jitter: float, lost: float,
         rng: np.random.Generator) -> np.ndarray:
    """Return the ticks at which the logger wrote a row that was not lost."""
    at = np.arange(before, ticks, every)
    if jitter > 0:
        at = at + np.round(every * np.clip(jitter * rng.standard_normal(len(at)), -0.45, 0.45)
                           ).astype(int)
        at = np.clip(at, before, ticks - 1)
        at[0] = before
    if lost > 0:
        kept = rng.random(len(at)) >= lost
        # And one longer gap, as when a disk is busy.
        gap = rng.integers(len(at) // 4, len(at))
        kept[gap:gap + round(rng.uniform(0.1, 0.4) / TICK / every)] = False
        kept[0] = True
        at = at[kept]
    return np.unique(at)


def table(given: Commands, out: np.ndarray, readings: dict, celsius: np.ndarray, sheet: dict,
          at: np.ndarray, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return the columns of a log, by name with unit."""
    columns = {
        'time[s]': (at - at[0]) * TICK,
        'pump_command[V]': np.round(out[at, U] / CONVERTER) * CONVERTER,
        'pprv_command[V]': given.pprv[at],
        'speed_setpoint[rpm]': given.setpoint[at] / RPM,
        'oil_temperature[degC]': _measured(celsius[at], sheet['sensors']['oil_temperature'], 'K',
                                           rng),
    }
    for name, (unit, key, si) in SENSORS.items():
        columns[f'{name}[{unit}]'] = _measured(readings[name][at] / si, sheet['sensors'][name],
                                               key, rng)
    return columns


def write(path: Path, columns: dict[str, np.ndarray], missing: tuple[str, ...]) -> None:
    """Write a log without the missing channels."""
    kept = [name for name in columns if name.partition('[')[0] not in missing]
    np.savetxt(path, np.column_stack([columns[name] for name in kept]), fmt='%.7g',
               delimiter=',', header=','.join(kept), comments='')
