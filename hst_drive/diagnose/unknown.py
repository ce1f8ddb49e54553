# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
When no listed effect explains the data: where the error enters, on what it depends, a formula.

A wrong equation moves the replayed signals in a direction of its own: oil that the pump side
loses lowers flow and speed together, oil lost in the hydromotor the speed alone, a missing
torque shows as pressure, a wrong load as torque alone, and a wrong torque reading as torque and
pressure together. The direction that holds most of the remaining error is the place; its size
over time is then regressed, by blocks, on few named variables.
"""
from __future__ import annotations

from itertools import combinations_with_replacement
from typing import NamedTuple

from hst_drive.diagnose.campaign import BLOCK, Campaign
from hst_drive.diagnose.fit import Fit
from hst_drive.diagnose.judge import CLEAN_RATIO, PRACTICAL
from hst_drive.diagnose.result import Unknown
from hst_drive.measure.run import CHANNELS
import numpy as np
from scipy.ndimage import gaussian_filter1d

WINDOW = 0.10       # s, standard deviation of the smoothing
MOST_TERMS = 3


class Place(NamedTuple):
    """
    A place where an unknown may enter.

    ``moves`` maps signals to how far they move per unit of the unknown, in SI.
    """

    name: str
    enters: str
    signal: str
    unit: str
    moves: dict[str, float]


def places(campaign: Campaign) -> list[Place]:
    """Return the places that the channels can tell apart."""
    rig = campaign.rig
    per_torque = 1.0 / (0.88 * rig.motor.displacement)
    flow, speed, pressure = 'motor_inlet_flow', 'motor_speed', 'pump_outlet_pressure'
    torque = 'load_torque'
    found = [
        Place('oil delivered by the pump', 'flow', flow, 'm^3/s',
              {flow: 1.0, speed: 1.0 / rig.motor.displacement}),
        Place('oil that turns the hydromotor', 'flow', speed, 'm^3/s',
              {speed: 1.0 / rig.motor.displacement}),
        Place('flow reading', 'sensor', flow, 'm^3/s', {flow: 1.0}),
        Place('torque of the hydromotor', 'torque', pressure, 'N.m', {pressure: -per_torque}),
        Place('load torque', 'load', torque, 'N.m', {torque: 1.0}),
        Place('torque reading', 'sensor', torque, 'N.m', {torque: -1.0, pressure: per_torque}),
    ]
    have = set(campaign.signals)
    kept = []
    for place in found:
        moves = {name: move for name, move in place.moves.items() if name in have}
        # Without its partner signal a sensor's place is the same as the physical one.
        if moves and not (place.enters == 'sensor' and len(moves) < len(place.moves)):
            if not any(set(other.moves) == set(moves) and len(moves) == 1 and
                       other.enters == place.enters for other in kept):
                kept.append(place._replace(moves=moves, signal=next(iter(moves))))
    return kept


def describe(campaign: Campaign, model: Fit) -> Unknown | None:
    """
    Say where the remaining error enters and on what it depends.

    Returns
    -------
    Unknown or None
        None if no structured error is left.

    """
    best, share, sizes = None, 0.0, None
    power = _power(campaign, model)
    for place in places(campaign):
        amplitude = _amplitude(campaign, model, place)
        held = _held(campaign, model, place, amplitude)
        if held > share:
            best, share, sizes = place, held, amplitude
    if best is None or power <= 0:
        return None
    terms, explained = _regress(campaign, sizes)
    depends = tuple(dict.fromkeys(name for term in terms for name in term['variables']))
    enters = best.enters
    if best.name == 'oil delivered by the pump' and any(
            name in ('pump_command', 'pump_command_rate', 'pump_command_history')
            for name in depends[:1]):
        enters = 'pump_actuator'
    return Unknown(enters, best.signal, depends, _expression(best, terms), tuple(terms),
                   explained)


def _smooth_errors(campaign: Campaign, model: Fit) -> list[dict[str, np.ndarray]]:
    """Return model minus measurement over the floor of the smoothed signal, log by log."""
    logs: list[dict[str, np.ndarray]] = [{} for _ in campaign.replays]
    for error, column in zip(model.errors, campaign.columns):
        replay = campaign.replays[column.log]
        width = max(WINDOW / replay.run.sample_time, 0.5)
        time = replay.run.time - replay.run.time[0]
        used = np.zeros(len(time), dtype=bool)
        used[column.fit] = used[column.judge] = True
        clean = np.where(used, np.clip(error * column.trust, -50, 50), 0.0)
        logs[column.log][column.signal] = gaussian_filter1d(clean, width)
    return logs


def _power(campaign: Campaign, model: Fit) -> float:
    ratios = campaign.ratios(model.errors, True)
    return sum(max(value**2 - CLEAN_RATIO**2, 0.0) for value in ratios.values())


def _amplitude(campaign: Campaign, model: Fit, place: Place) -> list[np.ndarray]:
    """Return the size of the unknown over time, log by log, in the unit of the place."""
    sizes = []
    for index, errors in enumerate(_smooth_errors(campaign, model)):
        top, bottom = 0.0, 1e-30
        for name, move in place.moves.items():
            if name in errors:
                scaled = move / campaign.floors[index][name]
                top = top - scaled * errors[name]
                bottom = bottom + scaled**2
        sizes.append(top / bottom * np.ones(len(campaign.replays[index].run)))
    return sizes


def _held(campaign: Campaign, model: Fit, place: Place, sizes: list[np.ndarray]) -> float:
    """Return how much of the smoothed squared error lies in the place's direction."""
    total = 0.0
    for index, size in enumerate(sizes):
        weight = sum((move / campaign.floors[index][name])**2
                     for name, move in place.moves.items() if name in campaign.floors[index])
        total += float(size @ size) * weight
    # One more signal always holds more noise: a place must earn it.
    return total * (1.0 if len(place.moves) == 1 else 0.98)


def _library(campaign: Campaign) -> list[dict[str, np.ndarray]]:
    """Return the variables of a formula, log by log, scaled to about one."""
    logs = []
    for replay in campaign.replays:
        run, width = replay.run, max(WINDOW / replay.run.sample_time, 0.5)
        found = {}
        for name, scale, shift in _SCALES:
            values = replay.inputs.get(name)
            if values is None and name in run:
                values = np.interp(np.arange(len(run)), np.flatnonzero(np.isfinite(run[name])),
                                   run[name][np.isfinite(run[name])])
                values = gaussian_filter1d(values, width)
            if values is not None:
                found[name] = (values - shift) / scale
        for name in ('pump_command', 'pprv_command'):
            values = gaussian_filter1d(replay.inputs[name], width)
            rate = np.gradient(values, run.time)
            found[f'{name}_rate'] = rate
            found[f'{name}_history'] = _last_direction(rate)
        if 'motor_speed' in run:
            angle = np.concatenate([[0.0], np.cumsum(
                np.nan_to_num(run['motor_speed'])[:-1] * np.diff(run.time))])
            found['motor_angle_cos'], found['motor_angle_sin'] = np.cos(angle), np.sin(angle)
        logs.append(found)
    return logs


_SCALES = (('pump_outlet_pressure', 1e7, 0.0), ('motor_speed', 10.0, 0.0),
           ('oil_temperature', 10.0, 323.15), ('pump_command', 1.0, 0.0),
           ('pprv_command', 1.0, 0.0))


def _last_direction(rate: np.ndarray) -> np.ndarray:
    """Return +1 after a rise and -1 after a fall: what a part with play or stiction remembers."""
    moving = np.sign(np.where(np.abs(rate) > 0.02, rate, 0.0))
    index = np.maximum.accumulate(np.where(moving != 0, np.arange(len(rate)), 0))
    return moving[index]


def _regress(campaign: Campaign, sizes: list[np.ndarray]) -> tuple[list[dict], float]:
    """Choose at most three terms by their error on held-out blocks."""
    library = _library(campaign)
    names = sorted(set.intersection(*(set(entry) for entry in library)))
    plain = [name for name in names if name in {entry[0] for entry in _SCALES}]
    products = [(), *((name,) for name in names), *combinations_with_replacement(plain, 2)]
    values = np.concatenate(sizes)
    columns = {product: np.concatenate([np.prod([entry[name] for name in product], axis=0)
                                        * np.ones(len(size))
                                        for entry, size in zip(library, sizes)])
               for product in products}
    block = np.concatenate([
        ((replay.run.time - replay.run.time[0]) / BLOCK).astype(int) + 100000 * index
        for index, replay in enumerate(campaign.replays)])
    fold = block % 3 == 1
    step = max(int(0.05 / campaign.replays[0].run.sample_time), 1)
    keep = slice(None, None, step)
    values, fold = values[keep], fold[keep]
    columns = {name: column[keep] for name, column in columns.items()}
    chosen: list[tuple[str, ...]] = []
    whole = error = float(np.mean(values[fold]**2))
    for _ in range(MOST_TERMS):
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
    spread = _spread(matrix, values, fitted, block[keep])
    terms = [{'variables': list(product), 'coefficient': float(value),
              'low': float(value - 1.96 * deviation), 'high': float(value + 1.96 * deviation)}
             for product, value, deviation in zip(chosen, fitted, spread)]
    return terms, 1 - error / whole


def _spread(matrix: np.ndarray, values: np.ndarray, fitted: np.ndarray,
            block: np.ndarray) -> np.ndarray:
    """Return standard deviations of the coefficients, blocks as clusters."""
    left = values - matrix @ fitted
    inverse = np.linalg.pinv(matrix.T @ matrix)
    meat = np.zeros_like(inverse)
    for number in np.unique(block):
        push = matrix[block == number].T @ left[block == number]
        meat += np.outer(push, push)
    return np.sqrt(np.maximum(np.diag(inverse @ meat @ inverse), 0.0))


def _expression(place: Place, terms: list[dict]) -> str:
    if not terms:
        return f'{place.name} [{place.unit}]: no formula of few terms holds on held-out data'
    scale = {name: (size, shift) for name, size, shift in _SCALES}
    texts = []
    for term in terms:
        factors = []
        for name in term['variables']:
            if name in scale:
                size, shift = scale[name]
                unit = CHANNELS[name].unit
                inner = f'{name} - {shift:g} {unit}' if shift else name
                factors.append(f'(({inner}) / {size:g} {unit})' if shift
                               else f'({inner} / {size:g} {unit})')
            else:
                factors.append(name)
        texts.append(' * '.join([f'{term["coefficient"]:.3g}', *factors]))
    return f'{place.name} [{place.unit}] += ' + ' + '.join(texts)
