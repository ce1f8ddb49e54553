# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""On what an unknown depends, and a formula of few terms for it, both proved on other blocks."""
from __future__ import annotations

from itertools import combinations_with_replacement
from typing import Callable, NamedTuple, Sequence

from hst_drive.channels import CHANNELS, COMMANDS
from hst_drive.diagnose.isolate import Location, smooth
from hst_drive.effects.formula import (
    FLOW, PRESSURE, REFERENCE, SPEED, TERMS, TEXTS, TORQUE, WARMTH, written)
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit
from hst_drive.identify.judge import PRACTICAL
from hst_drive.identify.linearised import squared_slopes
from hst_drive.measure.readings import filled
from hst_drive.measure.where import WARMS
from hst_drive.model.drive import Drive
from hst_drive.model.lags import follow
import numpy as np

_BINS, _BINS_OF_TWO = 12, 6
_MEMORY = 4.0           # s, creep of a valve
_STEP = 0.05            # s between the samples that are regressed
# Channel: scale, shift, and its name in a formula that can be adopted.
SCALES: dict[str, tuple[float, float, str]] = {
    'pump_outlet_pressure': (PRESSURE, 0.0, 'pressure'),
    'motor_inlet_pressure': (PRESSURE, 0.0, 'pressure'), 'motor_speed': (SPEED, 0.0, 'speed'),
    'oil_temperature': (WARMTH, REFERENCE, 'warmth'), 'pump_command': (1.0, 0.0, 'pump'),
    'pprv_command': (1.0, 0.0, 'pprv'), 'load_torque': (TORQUE, 0.0, 'torque'),
    'motor_inlet_flow': (FLOW, 0.0, 'flow'), 'pump_speed': (100.0, 0.0, ''),
    'line_a_pressure': (PRESSURE, 0.0, ''), 'line_b_pressure': (PRESSURE, 0.0, ''),
    'valve_command': (1.0, 0.0, ''),
}
STATIC = {**{name: entry[2] for name, entry in SCALES.items() if entry[2]},
          'motor_angle_cos': 'cosine', 'motor_angle_sin': 'sine'}


class Samples(NamedTuple):
    """What is regressed: size of the unknown, variables, fold and block of each sample."""

    values: np.ndarray
    variables: dict[str, np.ndarray]
    held_out: np.ndarray
    block: np.ndarray


def samples(campaign: Campaign, model: Fit, location: Location, sizes: Sequence[np.ndarray],
            used: Sequence[np.ndarray]) -> Samples:
    """Gather the samples of all logs, thinned."""
    logs = [_variables(campaign, model, index) for index in range(len(campaign.replays))]
    names = [name for name in location.reads if all(name in entry for entry in logs)
             and not (name == 'oil_temperature' and np.ptp(np.concatenate(
                 [entry[name] for entry in logs])) < WARMS / WARMTH)]
    values, columns, blocks = [], {name: [] for name in names}, []
    for index, replay in enumerate(campaign.replays):
        step = max(int(_STEP / replay.run.sample_time), 1)
        rows = np.flatnonzero(used[index])[::step]
        values.append(sizes[index][rows])
        for name in names:
            columns[name].append(logs[index][name][rows])
        time = replay.run.time[rows] - replay.run.time[0]
        blocks.append((time / campaign.block).astype(int) + 100000 * index)
    block = np.concatenate(blocks)
    return Samples(np.concatenate(values),
                   {name: np.concatenate(parts) for name, parts in columns.items()},
                   block % 3 == 1, block)


def _variables(campaign: Campaign, model: Fit, index: int) -> dict[str, np.ndarray]:
    """Return the variables of one log, scaled to about one."""
    replay = campaign.replays[index]
    run, found = replay.run, {}
    for name, (scale, shift, _) in SCALES.items():
        values = replay.inputs.get(name)
        if values is None and name in run and np.isfinite(run[name]).any():
            values = smooth(campaign, index, filled(run[name]))
        if values is not None:
            found[name] = (values - shift) / scale
    if 'motor_speed' in found and isinstance(campaign.drive, Drive):
        # The load that the model sees: the measured one holds the unknown itself.
        found['load_torque'] = campaign.driver(model.model).load_torque(
            run.time, replay.inputs['pprv_command'], SPEED * found['motor_speed'],
            replay.inputs['oil_temperature'], replay.inputs.get('motor_angle')) / TORQUE
    if replay.static:
        return found
    for name in COMMANDS:
        if name in replay.inputs:
            raw = replay.inputs[name]
            rate = np.gradient(smooth(campaign, index, raw), run.time)
            found[f'{name}_rate'] = rate
            found[f'{name}_history'] = _last_direction(rate)
            found[f'{name}_creep'] = raw - follow(run.time, raw, _MEMORY)
    if 'motor_speed' in run:
        angle = replay.inputs['motor_angle']
        found['motor_angle_cos'], found['motor_angle_sin'] = np.cos(angle), np.sin(angle)
    return found


def _last_direction(rate: np.ndarray) -> np.ndarray:
    """Return +1 after a rise and -1 after a fall: what a part with play or stiction remembers."""
    moving = np.sign(np.where(np.abs(rate) > 0.02, rate, 0.0))
    index = np.maximum.accumulate(np.where(moving != 0, np.arange(len(rate)), 0))
    return moving[index]


def channel_of(variable: str) -> str:
    """Return the channel behind a variable: 'pprv_command' for its history."""
    if variable.startswith('motor_angle'):
        return 'motor_angle'
    for end in ('_rate', '_history', '_creep'):
        variable = variable.removesuffix(end)
    return variable


def depends_on(data: Samples) -> tuple[str, ...]:
    """
    Return at most two channels that tell the unknown best, whatever the form.

    Means over bins of one or two variables are learned on two thirds of the blocks and judged
    on the others.
    """
    total = float(np.var(data.values[data.held_out]))
    if total <= 0:
        return ()
    bins = {name: _binned(values, _BINS) for name, values in data.variables.items()
            if np.ptp(values) > 1e-6}
    alone = {name: _share(data, number, total) for name, number in bins.items()}
    if not alone:
        return ()
    first = max(alone, key=alone.get)
    coarse = {name: _binned(data.variables[name], _BINS_OF_TWO) for name in bins}
    pairs = {name: _share(data, bins[first] * _BINS_OF_TWO + number, total)
             for name, number in coarse.items() if name != first}
    second = max(pairs, key=pairs.get, default=None)
    chosen = [first] if alone[first] >= PRACTICAL else []
    if second and pairs[second] >= max(alone[first], 0.0) + PRACTICAL:
        chosen = [first, second]
    return tuple(dict.fromkeys(channel_of(name) for name in chosen))


def _binned(values: np.ndarray, count: int) -> np.ndarray:
    edges = np.unique(np.quantile(values, np.linspace(0, 1, count + 1)))[1:-1]
    return np.searchsorted(edges, values, side='right')


def _share(data: Samples, number: np.ndarray, total: float) -> float:
    """Return the share of the held-out variance that means over bins explain."""
    train, size = ~data.held_out, int(number.max()) + 1
    count = np.bincount(number[train], minlength=size)
    overall = float(data.values[train].mean())
    # Empty and nearly empty bins fall back on the mean.
    mean = (np.bincount(number[train], data.values[train], size) + 3 * overall) / (count + 3)
    left = data.values[data.held_out] - mean[number[data.held_out]]
    return 1 - float(np.mean(left**2)) / total


def regress(data: Samples, wanted: Callable[[str], bool]) -> tuple[list[dict], float]:
    """
    Choose at most three terms by their error on held-out blocks.

    Returns
    -------
    terms : list of dict
        'variables', 'coefficient', 'low' and 'high' (95 %, blocks as clusters).
    explained : float
        Share of the held-out squared error that they take.

    """
    names = sorted(name for name in data.variables if wanted(name))
    plain = [name for name in names if name in STATIC or name in SCALES]
    products = [(), *((name,) for name in names), *combinations_with_replacement(plain, 2)]
    columns = {product: np.prod([data.variables[name] for name in product], axis=0)
               * np.ones(len(data.values)) for product in products}
    values, fold = data.values, data.held_out
    chosen: list[tuple[str, ...]] = []
    whole = error = float(np.mean(values[fold]**2))
    for _ in range(TERMS):
        best, best_error = None, error
        for product, column in columns.items():
            if product in chosen:
                continue
            trial = np.column_stack([columns[name] for name in chosen] + [column])
            fitted = np.linalg.lstsq(trial[~fold], values[~fold], rcond=None)[0]
            left = float(np.mean((values[fold] - trial[fold] @ fitted)**2))
            if left < best_error:
                best, best_error = product, left
        if best is None or best_error > (1 - PRACTICAL) * error:
            break
        chosen.append(best)
        error = best_error
    if not chosen:
        return [], 0.0
    matrix = np.column_stack([columns[name] for name in chosen])
    fitted = np.linalg.lstsq(matrix, values, rcond=None)[0]
    # Standard deviations, blocks as clusters.
    inverse = np.linalg.pinv(matrix.T @ matrix)
    middle = squared_slopes(matrix, values - matrix @ fitted, data.block)
    spread = np.sqrt(np.maximum(np.diag(inverse @ middle @ inverse), 0.0))
    terms = [{'variables': list(product), 'coefficient': float(value),
              'low': float(value - 1.96 * deviation), 'high': float(value + 1.96 * deviation)}
             for product, value, deviation in zip(chosen, fitted, spread)]
    return terms, 1 - error / whole


def expression(location: Location, terms: Sequence[dict]) -> str:
    """Return the formula as text."""
    if not terms:
        return f'{location.name} [{location.unit}]: no short formula holds on held-out data'
    return written(f'{location.name} [{location.unit}]', [
        (term['coefficient'], [_text(name) for name in term['variables']]) for term in terms])


def _text(name: str) -> str:
    """Return a variable, scaled to about one, for people."""
    if name not in SCALES:
        return name
    size, _, known = SCALES[name]
    if not known:
        return f'({name} / {size:g} {CHANNELS[name].unit})'
    return TEXTS[known].replace('(pressure', f'({name}')
