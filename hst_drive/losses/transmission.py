# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Many transmissions (pump and motor) tested at one speed: what a loss-free model misses.

A loss-free transmission turns at ``w_p D_p / D_m``. What is missing in the motor's speed is flow:
leakage of pump and motor together, ``D_p w_p - D_m w_m``.
"""
from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from hst_drive.errors import InputError
from hst_drive.units import from_si
import numpy as np

OUTLIER = 6.0           # robust standard deviations
_LEAST_UNITS = 5        # for a spread


class Spread(NamedTuple):
    """Median over units with its 95 % interval, robust standard deviation, and range."""

    median: float
    low: float
    high: float
    sd: float
    least: float
    most: float


class Outlier(NamedTuple):
    """A value that is not of the others' kind: line, column, value (SI), deviations, a guess."""

    line: int
    column: str
    value: float
    sigma: float
    guess: str


class Transmissions(NamedTuple):
    """
    What a table of transmissions says, SI.

    Two medians say how much faster a loss-free one turns: ``speed_error_over_loss_free`` as a
    share of its own speed, which is the median of ``leakage_share`` (of the loss-free flow), and
    ``speed_error_over_measured`` as a share of the median measured speed.
    ``leakage`` and ``conductance`` (None without displacement or pressure) are of pump and motor
    together; ``unit_scatter`` is the relative scatter of the leakage between units, the
    repeatability (forward against reverse) taken out where both are there.
    """

    units: int
    loss_free_speed: float
    speed: Spread
    speed_error_over_loss_free: float
    speed_error_over_measured: float
    leakage_share: Spread
    leakage: Spread | None
    conductance: Spread | None
    unit_scatter: float | None
    repeatability: float | None
    outliers: tuple[Outlier, ...]
    not_determinable: dict[str, str]


def transmissions(columns: Mapping[str, np.ndarray], headers: Mapping[str, str],
                  lines: np.ndarray, constants: Mapping[str, float],
                  source: str) -> Transmissions:
    """
    Compare a loss-free transmission with measured ones.

    Parameters
    ----------
    columns : mapping
        pump_speed and motor_speed, optionally motor_speed_reverse, rad/s, one row per unit.
    headers, lines, source
        As in the file, for messages.
    constants : mapping
        pump_displacement, motor_displacement (m^3/rad; one that is missing is as large as the
        other) and supply_pressure (Pa, across the transmission) that hold for all rows.

    Raises
    ------
    InputError
        If the table cannot be used.

    """
    known = {**{name: np.full(len(lines), value) for name, value in constants.items()}, **columns}
    _check(known, headers, lines, source)
    pump, motor = known.get('pump_displacement'), known.get('motor_displacement')
    pump, motor = motor if pump is None else pump, pump if motor is None else motor
    ideal = known['pump_speed'] * (1.0 if motor is None else pump / motor)
    names = [name for name in ('motor_speed', 'motor_speed_reverse') if name in known]
    shares = {name: 1.0 - known[name] / ideal for name in names}
    outliers, good = [], {}
    for name, share in shares.items():
        found, rows = _outliers(name, share, known[name], ideal, headers, lines)
        outliers += found
        good[name] = rows
    share = np.where(good['motor_speed'], shares['motor_speed'], np.nan)
    reverse = np.full(len(lines), np.nan)
    if 'motor_speed_reverse' in good:
        reverse[good['motor_speed_reverse']] = shares['motor_speed_reverse'][
            good['motor_speed_reverse']]
    usable = np.isfinite(share)
    if not usable.any():
        raise InputError(f'{source}: no row has pump and motor speed; found {len(lines)} rows; '
                         'fill the cells')
    flow = None if motor is None else ideal * motor
    pressure = known.get('supply_pressure')
    leakage = None if flow is None else _spread((share * flow)[usable])
    conductance = None
    if flow is not None and pressure is not None:
        conductance = _spread((share * flow / pressure)[usable])
    scatter, repeat = _scatter(share, reverse)
    speed = _spread(known['motor_speed'][usable])
    loss_free = float(np.median(ideal[usable]))
    leaking = _spread(share[usable])
    return Transmissions(
        int(usable.sum()), loss_free, speed, leaking.median, loss_free / speed.median - 1.0,
        leaking, leakage, conductance, scatter, repeat, tuple(outliers),
        _not_determinable(known, flow is None))


def _check(known: Mapping[str, np.ndarray], headers: Mapping[str, str], lines: np.ndarray,
           source: str) -> None:
    """Raise InputError if a speed is missing or a number cannot be."""
    for name in ('pump_speed', 'motor_speed'):
        if name not in known:
            raise InputError(f'{source}: column {name}[rpm] is missing; a table of transmissions '
                             'needs pump_speed and motor_speed; name them in --channels MAP.yaml')
    for name, values in known.items():
        bad = np.flatnonzero(np.isinf(values) | (values <= 0))
        if len(bad):
            place, mend = ((f'row {lines[bad[0]]}, column {headers[name]!r}', 'empty the cell')
                           if name in headers else (f'constants.{name}', 'leave it out'))
            raise InputError(f'{source}: {place}: found {values[bad[0]]:.6g} (SI), expected a '
                             f'positive number; mend it or {mend}')


def _scatter(share: np.ndarray, reverse: np.ndarray) -> tuple[float | None, float | None]:
    """Return the relative scatter between units and within one; None where too few tell."""
    pair = np.isfinite(share) & np.isfinite(reverse)
    if pair.sum() >= _LEAST_UNITS:
        middle = abs(float(np.median(share[pair])))
        within = _robust_sd((share - reverse)[pair]) / np.sqrt(2.0) / middle
        # The mean of two readings still holds half of their variance.
        common = _robust_sd(0.5 * (share + reverse)[pair]) / middle
        return float(np.sqrt(max(common**2 - 0.5 * within**2, 0.0))), within
    usable = share[np.isfinite(share)]
    if len(usable) < _LEAST_UNITS:
        return None, None
    return _robust_sd(usable) / abs(float(np.median(usable))), None


def _not_determinable(known: Mapping[str, np.ndarray], no_size: bool) -> dict[str, str]:
    out = {'torque losses': 'no load torque in the table: Eqs. (14) and (15) of the motor-loss '
                            'paper need torque and pressure',
           'R_el, R_1, R_2': 'no flow, case drain flow or torque, Eqs. (2) to (4)',
           'split between pump and motor': 'no flow between them'}
    if 'supply_pressure' not in known:
        out['leakage conductance'] = 'no pressure; give supply_pressure as a constant'
    if no_size:
        out['leakage flow'] = 'no displacement; give motor_displacement as a constant'
    speeds = known['pump_speed'][np.isfinite(known['pump_speed'])]
    if len(speeds) and np.ptp(speeds) < 0.01 * speeds.mean():
        out['dependence on speed, load and temperature'] = 'one test point for all units'
    return out


def _outliers(name: str, share: np.ndarray, speed: np.ndarray, ideal: np.ndarray,
              headers: Mapping[str, str], lines: np.ndarray) -> tuple[list[Outlier], np.ndarray]:
    there = np.isfinite(share)
    sd = max(_robust_sd(share[there]), 1e-4) if there.any() else 1.0
    middle = float(np.median(share[there])) if there.any() else 0.0
    sigma = (share - middle) / sd
    out = []
    good = there & (np.abs(sigma) <= OUTLIER)
    for row in np.flatnonzero(there & ~good):
        out.append(Outlier(int(lines[row]), headers.get(name, name), float(speed[row]),
                           float(-sigma[row]), _guess(float(speed[row]), float(
                               ideal[row] * (1.0 - middle)), sd * float(ideal[row]))))
    return out, good


def _guess(found: float, usual: float, sd: float) -> str:
    """Return what a slip of a digit would make of a value, or ''."""
    rpm, usual, sd = (float(from_si(value, 'rpm')) for value in (found, usual, sd))
    for power in (1000.0, 100.0, 10000.0):
        for digit in range(1, 10):
            for sign in (1.0, -1.0):
                if abs(rpm + sign * digit * power - usual) < OUTLIER * sd:
                    return f'perhaps {rpm + sign * digit * power:.6g} rpm (a digit)'
    return ''


def _robust_sd(values: np.ndarray) -> float:
    """Return the standard deviation of the middle: half the width that holds 68 %."""
    low, high = np.percentile(values, [15.865, 84.135])
    return 0.5 * float(high - low)


def _spread(values: np.ndarray) -> Spread:
    middle, sd = float(np.median(values)), _robust_sd(values)
    # Standard error of a median of normal values.
    error = 1.96 * 1.2533 * sd / np.sqrt(len(values))
    return Spread(middle, middle - error, middle + error, sd, float(values.min()),
                  float(values.max()))
