# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Sensor plausibility by analytical redundancy: a wrong unit, a wrong sign, a reading that drifts.

Three channels tell the flow (pump command, flow meter, speed) and three the load (PPRV command,
torque, pressure), each within what a drive's losses can be. Where two agree and one is off by a
factor, or parts from both as time passes, it is that one's sensor, unit or clock, and no physics.
"""
from __future__ import annotations

from itertools import combinations
from typing import Mapping, NamedTuple, Sequence

from hst_drive.channels import CHANNELS, COMMANDS, PRESSURES, TORQUES
from hst_drive.errors import InputError
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.measure.balances import is_part
from hst_drive.measure.run import BLOCK, FEWEST, Run, usual_size
from hst_drive.measure.signs import swapped
from hst_drive.measure.where import WARMS
from hst_drive.rig import Rig
import numpy as np
from scipy import ndimage

_LOW = 0.15             # of it: below, losses outweigh what they are losses of
_AGREE = 1.4            # ratio of two sensors that agree
_FLOW, _LOAD = 1.7, 2.5     # ratio that no tolerance makes
_LOST = 8.0             # ratio that no loss, no worn valve and no dead band makes
_LEAST = 0.05           # of what the rig can do: less is idling or standstill and tells nothing
_KNOWN = 0.06           # how near a ratio lies to that of a unit
_COMMANDED = 1.1        # of where a command's curve ends: no controller asks for more
_HOTTEST = 115.0 + 273.15   # K: no hydraulic oil is, in the median
_COLDEST = -60.0 + 273.15   # K: nor below what the oils of the Arctic pour at
_DRIFT = 0.03           # of the size, from start to end
_SURE = 8.0             # standard deviations
_APART = 0.15           # of the time that load and oil must leave unexplained
_ALONE = 0.3            # of its drift: what the others may part from each other
_LOSSY = ('motor_speed', *PRESSURES)    # losses lie between them and their other sensors

# What one unit reads when it is taken for the usual one of its quantity.
_UNITS: dict[str, dict[str, float]] = {
    'bar': {'psi as bar': 14.5038, 'bar as psi': 1 / 14.5038, 'kPa as bar': 100.0,
            'bar as kPa': 0.01, 'MPa as bar': 0.1, 'a factor of 10': 10.0},
    'rpm': {'rad/s as rpm': 0.1047198, 'rpm as rad/s': 9.549297, '1/s as rpm': 1 / 60,
            'deg/s as rpm': 6.0},
    'L/min': {'L/s as L/min': 1 / 60, 'm^3/h as L/min': 0.06, 'gal/min as L/min': 1 / 3.785412,
              'L/min as gal/min': 3.785412, 'L/min as L/s': 60.0},
    'N.m': {'lbf.ft as N.m': 1 / 1.3558179, 'N.m as lbf.ft': 1.3558179, 'kN.m as N.m': 0.001,
            'lbf.in as N.m': 8.850746, 'daN.m as N.m': 0.1},
}


class Group(NamedTuple):
    """
    Sensors of one quantity by channel, SI, one value a block.

    ``beyond`` is the ratio that no tolerance makes, ``least`` the size that tells something,
    ``conditions`` is what losses depend on.
    """

    values: Mapping[str, np.ndarray]
    beyond: float
    least: float
    conditions: Sequence[np.ndarray]


class Drift(NamedTuple):
    """A channel that parts from the others as time passes, and that in words."""

    channel: str
    told: str


def refuse_wrong_units(rig: Rig, runs: Sequence[Run]) -> None:
    """
    Raise InputError if a sensor of the recordings is off by a factor against the others.

    It names log, channel, how far it is off and as what.
    """
    for run in runs:
        told = unit_doubts(rig, run, sure=True)
        if told:
            raise InputError(f'{run.source}: {"; ".join(told)}; no missing physics does that: '
                             'mend the unit (column header or --channels), the sign (scale: -1 '
                             'in --channels) or the number in the rig file, or leave the column '
                             'out')


def unit_doubts(rig: Rig, run: Run, sure: bool = False) -> list[str]:
    """
    Return a line for each channel that is off by a factor or a sign.

    ``sure``: only by one that no loss and no badly calibrated sensor makes.
    """
    found = []
    oil = run.channels.get('oil_temperature', np.empty(0))
    usual = float(np.median(oil[np.isfinite(oil)])) if np.isfinite(oil).any() else np.nan
    if usual > _HOTTEST or usual < _COLDEST:
        found.append(f'oil_temperature is {usual - 273.15:.0f} degC in the median, '
                     'which no oil is (degC, K or degF taken for each other?)')
    found += _commands(rig, run)
    found += [line for group in _groups(rig, run) for line in _factor(group, sure)]
    if not found and is_part(run, rig) and (line := swapped(rig, run)):
        found.append(line)
    return found


def _commands(rig: Rig, run: Run) -> list[str]:
    """Return a line for each command that goes on where its curve in the rig file ends."""
    found = []
    for name, curve in (('pump_command', rig.pump and rig.pump.displacement),
                        ('pprv_command', rig.loading and rig.loading.pprv_pressure),
                        ('valve_command', rig.valve and rig.valve.opening)):
        if curve is None or not np.isfinite(run.channels.get(name, np.nan)).any():
            continue
        high, end = usual_size(run[name]), np.abs(curve.x).max()
        if high > _COMMANDED * end:
            found.append(f'{name} is {high:.3g} V and more for a twentieth of the time, where the '
                         f"rig's curve ends at {end:.3g} V (percent or mA taken for V?)")
    return found


def drifts(rig: Rig, runs: Sequence[Run]) -> list[Drift]:
    """
    Return the channels that drift in any of the recordings, without those in a wrong unit.

    Where no oil temperature was recorded, losses that change as the drive warms look like a drift
    of what lies behind them: speed and pressures are then not judged.
    """
    return [drift._replace(told=f'{run.name}: {drift.told}') for run in runs
            for group in _groups(rig, run) if not _factor(group) for drift in _drift(group)
            if 'oil_temperature' in run or drift.channel not in _LOSSY]


def _groups(rig: Rig, run: Run) -> list[Group]:
    """Return the sensors that rig and recording give."""
    number = np.unique((run.time - run.time[0]) // BLOCK, return_inverse=True)[1]
    every = np.arange(number[-1] + 1)
    if len(every) < FEWEST:
        return []

    def blocks(values: np.ndarray) -> np.ndarray:
        good = np.isfinite(values)
        found = ndimage.median(values, np.where(good, number, -1), every)
        return np.where(np.bincount(number[good], minlength=len(every)) > 0, found, np.nan)

    pump, motor = rig.pump, rig.motor
    size = motor.displacement if motor else 0.0
    flow, load = {}, {}
    if pump and pump.displacement is not None and 'pump_command' in run:
        speed = run.channels.get('pump_speed', np.full(len(run), pump.shaft_speed))
        flow['pump_command'] = blocks(pump.displacement(run['pump_command']) * speed)
    if 'motor_inlet_flow' in run:
        flow['motor_inlet_flow'] = blocks(run['motor_inlet_flow'])
    if 'motor_speed' in run and size:
        flow['motor_speed'] = blocks(run['motor_speed']) * size
    turning = flow.get('pump_command', flow.get('motor_inlet_flow', flow.get('motor_speed')))
    unit = _loading_unit(rig)
    if unit and size and 'pprv_command' in run and turning is not None:
        load['pprv_command'] = np.array([
            unit.torque_of_command(command, speed) if np.isfinite(command + speed) else np.nan
            for command, speed in zip(blocks(run['pprv_command']).tolist(),
                                      (turning / size).tolist())])
    for name in TORQUES[::-1]:
        if name in run:
            load[name] = blocks(run[name])
    # Losses as they are at the load that the others tell: the pressure itself may be off.
    torque = next(iter(load.values()), None)
    for name in PRESSURES:
        if name in run and size and turning is not None:
            pressure = blocks(run[name])
            usual = np.abs(pressure if torque is None else torque / size)
            load[name] = pressure * size * motor.mechanical_efficiency(
                usual, np.abs(turning) / size)
    conditions = [blocks(run[name]) for name in COMMANDS if name in run]
    if 'oil_temperature' in run:
        oil = blocks(run['oil_temperature'])
        if np.nanmax(oil) - np.nanmin(oil) > WARMS:
            conditions += [oil, (oil - np.nanmean(oil))**2]
    most_flow = pump.max_displacement * pump.shaft_speed if pump else 0.0
    most_load = rig.relief_valve.set_pressure * size if rig.relief_valve else 0.0
    return [Group(flow, _FLOW, _LEAST * most_flow, conditions),
            Group(load, _LOAD, _LEAST * most_load, conditions)]


def _loading_unit(rig: Rig) -> LoadingUnit | None:
    try:
        return LoadingUnit.of(rig.loading) if rig.loading else None
    except ValueError:      # a table that gives no command for a torque: no sensor
        return None


def _ratio(a: np.ndarray, b: np.ndarray) -> float:
    """Return the median ratio of two sensors where the second is not small; NaN if nowhere."""
    good = np.isfinite(a) & np.isfinite(b)
    if good.sum() < FEWEST:
        return np.nan
    a, b = a[good], b[good]
    large = np.abs(b) > _LOW * usual_size(b)
    return float(np.median(a[large] / b[large])) if large.sum() >= FEWEST else np.nan


def _alike(ratio: float) -> bool:
    return 1 / _AGREE < ratio < _AGREE


def _factor(group: Group, sure: bool = False) -> list[str]:
    """Tell which sensor is off by a factor from two that agree."""
    names = list(group.values)
    for name in names:
        others = [other for other in names if other != name]
        pairs = [_ratio(group.values[a], group.values[b]) for a, b in combinations(others, 2)]
        against = [_ratio(group.values[name], group.values[other]) for other in others]
        if not pairs or not all(map(_alike, pairs)) or any(map(np.isnan, against)):
            continue
        if min(usual_size(group.values[other]) for other in others) < group.least:
            continue
        ratio = float(np.median(against))
        unit = _unit_of(name, ratio)
        low, high = _made_by_losses(name, group.beyond)
        clear = not low < ratio < high
        if not clear and (sure or not unit or any(abs(pair - 1) >= 0.15 for pair in pairs)):
            continue
        times = '' if _alike(-ratio) else f'{abs(ratio):.3g} times '
        said = f'{name} reads {times}what {" and ".join(others)} say'
        if ratio < 0:
            said += ', with the other sign'
        return [said + (f' ({unit}?)' if unit else '')]
    return []


def _made_by_losses(name: str, beyond: float) -> tuple[float, float]:
    """Return the ratios to the other sensors between which a drive, not a sensor, may be off."""
    low = _LOST if name in (*COMMANDS, 'motor_speed') else beyond
    high = _LOST if name in (*COMMANDS, *PRESSURES) else beyond
    return 1 / low, high


def _unit_of(name: str, ratio: float) -> str:
    """Return the slip of a unit that makes a ratio; empty if none is known."""
    # A pressure holds the losses, too.
    near = 0.2 if name in PRESSURES else _KNOWN
    for title, factor in _UNITS.get(CHANNELS[name].display, {}).items():
        if abs(abs(ratio) / factor - 1) < near:
            return title
    return ''


def _drift(group: Group) -> list[Drift]:
    """Tell which sensor parts from two others as time passes, whatever load and oil do."""
    names = list(group.values)
    if len(names) < 3:
        return []
    best, told = 0.0, []
    for name in names:
        others = [other for other in names if other != name]
        size = usual_size(group.values[others[0]])
        own = [_trend(group, name, other) for other in others]
        sure = min(entry[1] for entry in own)
        change = float(np.median([entry[0] for entry in own]))
        apart = max(abs(_trend(group, a, b)[0]) for a, b in combinations(others, 2))
        if sure > max(best, _SURE) and abs(change) > _DRIFT * size \
                and size > group.least and apart < _ALONE * abs(change):
            best = sure
            told = [] if name in COMMANDS else [Drift(
                name, f'{name} drifts: from start to end of the log it moves by '
                f'{100 * change / size:+.0f} % of its size against {" and ".join(others)}')]
    return told


def _trend(group: Group, name: str, other: str) -> tuple[float, float]:
    """
    Return how far two sensors part within the log, and by how many standard deviations.

    What goes with load, speed and oil temperature is taken away first: what time alone explains
    counts.
    """
    a, b = group.values[name], group.values[other]
    count, terms = len(a), [b, b**2, *group.conditions]
    time = np.linspace(-0.5, 0.5, count)
    columns = [np.ones(count), *((term - np.nanmean(term)) / np.nanstd(term) for term in terms
                                 if np.nanstd(term) > 1e-3 * np.nanmax(np.abs(term)))]
    columns.append(time)
    matrix = np.column_stack(columns)
    good = np.isfinite(matrix).all(axis=1) & np.isfinite(a)
    good &= np.abs(b) > _LOW * usual_size(b)
    if good.sum() < len(columns) + FEWEST:
        return 0.0, 0.0
    others, time = matrix[good, :-1], time[good]
    # What the others leave of both has the slope that it has beside them (Frisch and Waugh).
    alone, left = (values - others @ np.linalg.lstsq(others, values, rcond=None)[0]
                   for values in (time, (a - b)[good]))
    if np.std(alone) < _APART * np.std(time):
        return 0.0, 0.0     # load or oil went with the time: which of them it is cannot be told
    slope = alone @ left / (alone @ alone)
    variance = np.sum((left - slope * alone)**2) / (len(left) - matrix.shape[1])
    error = np.sqrt(variance / (alone @ alone))
    return float(slope), float(abs(slope) / max(error, 1e-300))
