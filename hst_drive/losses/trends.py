# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The trends that the motor-loss paper states, tried on a bench table.

A trend is counted where all other variables stay at their level: the slope of the quantity over
the variable in each such group of rows, with its error from the noise of the rows.
"""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.losses.efficiency import performance
from hst_drive.losses.resistances import Resistances
from hst_drive.losses.table import Bench, VARIABLES
import numpy as np

# Quantity -> (name of people, sections of the paper, sign over speed, load, size, temperature).
STATED: dict[str, tuple[str, str, tuple[int, int, int, int]]] = {
    'R_el': ('external leakage resistance R_el', '5.1, Eq. (2)', (1, -1, 1, -1)),
    'R_1': ('inlet port resistance R_1', '5.2, Eq. (3)', (-1, 1, 1, -1)),
    'R_2': ('internal leakage resistance R_2', '5.3, Eq. (4)', (1, -1, 1, -1)),
    'slip': ('slip', '5.4, Eq. (12)', (-1, 1, -1, 1)),
    'torque_loss': ('torque loss in percent', '5.5, Eq. (14)', (1, -1, -1, -1)),
    'efficiency': ('overall efficiency', '5.6, Eq. (11)', (1, 1, 1, 1)),
}
ORDER = ('speed', 'load', 'size', 'temperature')
CONTRADICTION = (
    'R_1 rising with size and torque loss in percent falling with size cannot hold together: by '
    'Eq. (7) the torque loss is (Q - P/R_el) R_1 D, and Q is nearly D w, so that at equal load '
    'torque and speed the loss goes as R_1 D^2; it falls with size only where R_1 falls faster '
    'than 1/D^2.')
_LEAST_GROUPS_AGREE = 0.95
_SIGNIFICANT = 3.0


class Trend(NamedTuple):
    """
    A stated trend and what the table says.

    ``verdict``: holds, fails, mixed, not visible (no change beyond the noise) or not decidable.
    ``change`` is the median relative change from the lowest to the highest level.
    """

    quantity: str
    variable: str
    stated: str
    verdict: str
    groups: int
    agree: int
    against: int
    change: float | None
    reason: str


def quantities_of(bench: Bench, found: Resistances) -> dict[str, np.ndarray]:
    """Return the quantities of the stated trends for each row; NaN where not determined."""
    shown = performance(bench.pressure, bench.flow, bench.speed, bench.load_torque,
                        bench.displacement)
    return {'R_el': found.external, 'R_1': found.inlet, 'R_2': found.internal,
            'slip': shown.slip, 'torque_loss': shown.torque_loss_ratio,
            'efficiency': shown.overall}


def trends(bench: Bench, found: Resistances, noise: dict[str, np.ndarray],
           weights: np.ndarray) -> list[Trend]:
    """
    Return a verdict on each stated trend.

    Parameters
    ----------
    bench, found : Bench, Resistances
        The table and the resistances of its rows.
    noise : dict of str to ndarray
        Standard deviation of each quantity of ``STATED`` by row.
    weights : ndarray
        0 for rows that do not count (outliers).

    """
    labels = {name: bench.levels(name)[0] for name in VARIABLES}
    out = []
    for quantity, values in quantities_of(bench, found).items():
        for variable, sign in zip(ORDER, STATED[quantity][2]):
            out.append(_verdict(bench, labels, quantity, values, variable, sign, weights,
                                noise[quantity]))
    return out


def _verdict(bench: Bench, labels: dict[str, np.ndarray], quantity: str, values: np.ndarray,
             variable: str, sign: int, weights: np.ndarray, noise: np.ndarray) -> Trend:
    stated = 'rises' if sign > 0 else 'falls'

    def undecided(reason: str) -> Trend:
        return Trend(quantity, variable, stated, 'not decidable', 0, 0, 0, None, reason)

    if quantity in ('R_el', 'R_1', 'R_2') and bench.drain is None:
        return undecided('needs the case drain flow, Eq. (2)')
    if labels[variable].max() == 0:
        return undecided(f'one {variable} only')
    x = getattr(bench, VARIABLES[variable][0])
    rows = np.isfinite(values) & (weights > 0) & np.isfinite(noise) & (noise > 0)
    others = np.column_stack([labels[name] for name in VARIABLES if name != variable])
    _, cell = np.unique(others, axis=0, return_inverse=True)
    cell = cell.ravel()
    z, changes = [], []
    for number in np.unique(cell[rows]):
        group = rows & (cell == number)
        ranks = labels[variable][group]
        if ranks.min() == ranks.max():
            continue
        share = noise[group]**-2.0 / np.sum(noise[group]**-2.0)
        u = x[group] - share @ x[group]
        slope_over_sd = float(np.sum(u * values[group] / noise[group]**2)
                              / np.sqrt(np.sum((u / noise[group])**2)))
        z.append(sign * slope_over_sd)
        first, last = (float(np.mean(values[group][ranks == end]))
                       for end in (ranks.min(), ranks.max()))
        if first > 0:
            changes.append(last / first - 1.0)
    if not z:
        return undecided(f'no rows that differ in {variable} alone')
    z = np.array(z)
    agree, against = int((z > _SIGNIFICANT).sum()), int((z < -_SIGNIFICANT).sum())
    together = float(np.sum(z) / np.sqrt(len(z)))
    if agree + against == 0 and abs(together) < 4.0:
        verdict = 'not visible'
    elif agree >= _LEAST_GROUPS_AGREE * (agree + against) and together > 0:
        verdict = 'holds'
    elif against >= _LEAST_GROUPS_AGREE * (agree + against) and together < 0:
        verdict = 'fails'
    else:
        verdict = 'mixed'
    change = float(np.median(changes)) if changes else None
    shown = '' if change is None else f'; median change {100.0 * change:+.3g} %'
    verb = stated[:-1]
    return Trend(quantity, variable, stated, verdict, len(z), agree, against, change,
                 f'{agree} of {len(z)} groups {verb} beyond the noise, {against} the other way'
                 + shown)


def contradiction(bench: Bench, found: list[Trend], resistances: Resistances) -> dict:
    """Return what the table says on the two trends of the paper that exclude each other."""
    pair = {trend.quantity: trend for trend in found
            if trend.variable == 'size' and trend.quantity in ('R_1', 'torque_loss')}
    exponent = None
    _, sizes = bench.levels('size')
    if len(sizes) > 1:
        inlet = np.where(np.isfinite(resistances.inlet), resistances.inlet,
                         np.sqrt(np.abs(resistances.inlet_low * resistances.inlet_high)))
        good = np.isfinite(inlet) & (inlet > 0)
        design = np.column_stack([np.ones(good.sum())] + [np.log(entry[good]) for entry in (
            bench.displacement, bench.load_torque + 1e-9, bench.speed, bench.viscosity)])
        exponent = float(np.linalg.lstsq(design, np.log(inlet[good]), rcond=None)[0][1])
    return {'verdict': 'cannot hold together', 'equation': '(7)', 'text': CONTRADICTION,
            'R_1_with_size': pair['R_1'].verdict, 'torque_loss_with_size':
            pair['torque_loss'].verdict, 'size_exponent_of_R_1': exponent}
