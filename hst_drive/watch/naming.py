# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which effects of the catalogue would move the balances as they have moved.

Every effect says where it enters and on what it depends; over the blocks that fail that gives
a signature: how each balance would move per size of the effect as pressure, speed, temperature
and command went. All balances count, those that did not move as well. This is a first guess
for a person who watches the drive; ``diagnose`` refits, holds data out, and decides.
"""
from __future__ import annotations

import math
from typing import Mapping, NamedTuple

from hst_drive.effects import catalogue
from hst_drive.effects.base import Effect, Parameter
from hst_drive.effects.slots import READABLE
from hst_drive.model.arrays import evaluate
from hst_drive.model.part import PartModel
from hst_drive.rig.rig import OPEN
from hst_drive.watch.calibration import Calibration
from hst_drive.watch.residuals import Block
import numpy as np

_EQUAL = 0.06       # of the error: less does not tell one effect from another
_CHANCE = 12.0      # of squared error in deviations: less may be chance
_LEAST = 0.5        # of the error that an effect must explain to be named
_MOST = 6
_FEWEST = 10        # balances of blocks, for a trend
_SURE = 1.96        # standard deviations: half of a 95 % interval
_FAST = ('compliance', 'pump_lag', 'pump_series_lag', 'pump_stroke_time',
         'pump_stroke_asymmetry', 'pump_play', 'pump_play_softness', 'pump_play_spread',
         'line_upstream_share', 'shaft_compliance', 'shaft_load_share', 'shaft_damping_time',
         'line_inertance', 'line_far_share', 'line_damping', 'speed_reading_lag',
         'speed_reading_series_lag', 'gear_twist', 'gear_angle')
"""Slots of terms whose means over a block are next to nothing."""


class Likely(NamedTuple):
    """
    An effect that explains what fails: its share of the squared error and its size.

    ``parameter`` is the one that was fitted, ``size`` its value in SI: of an adopted effect as
    it is now, not by how much it differs from what was adopted. ``rate`` is by how much it grows
    in a second over the blocks, with its 95 % interval; None where they tell nothing of that.
    """

    effect: str
    explains: float
    parameter: str
    size: float
    rate: tuple[float, float, float] | None = None


class Signatures:
    """
    Signatures of the effects that can be seen in means over blocks.

    Parameters
    ----------
    model : PartModel
        Of the drive. Effects that its rig has adopted are in it already: they may have grown or
        shrunk.

    Attributes
    ----------
    unseen : tuple of str
        Effects that act within a block and leave its means alone: ``diagnose`` looks for them.

    """

    def __init__(self, model: PartModel):
        tried = {name: effect.sized(*model.rig.sizes) for name, effect in catalogue().items()
                 if effect.searched == 'always' and model.enters(name)
                 and not (effect.both_ways and model.rig.circuit == OPEN)}
        self._adopted = model.rig.effects
        self.unseen = tuple(name for name, effect in tried.items()
                            if effect.swings or all(slot in _FAST for slot, _ in effect.terms))
        self._effects = {name: effect for name, effect in tried.items()
                         if name not in self.unseen}

    def of(self, name: str, block: Block, size: Mapping[str, float], fitted: str
           ) -> dict[str, float]:
        """Return how an effect that is, or grows, by a size moves each balance in a block, SI."""
        return block.samples.by_effect(name, {
            **size, fitted: size[fitted] + self.adopted(name, fitted)})

    def sizes(self, both_ways: bool = False) -> list[tuple[str, dict[str, float], str]]:
        """
        Return what to try: effect, its parameters at typical size, the one that is fitted.

        Effects that only turning ``both_ways`` tells from others are tried if the drive has done
        so. What gives an adopted effect its shape stays as adopted. An effect that is a sum of
        parts, each with a parameter of its own, is tried part by part.
        """
        found = []
        for name, effect in self._effects.items():
            if effect.both_ways and not both_ways:
                continue
            first, *others = effect.parameters
            had = self._adopted.get(name, {})
            parts = [first] + [entry for entry in others if _alone(effect, entry)]
            for entry in parts:
                rest = {other.name: other.neutral if other in parts
                        else had.get(other.name, other.typical)
                        for other in effect.parameters if other is not entry}
                found.append((name, {entry.name: entry.typical, **rest}, entry.name))
        return found

    def adopted(self, name: str, parameter: str) -> float:
        """Return the value that the rig has adopted, SI."""
        return self._adopted.get(name, {}).get(parameter, 0.0)

    def bounds(self, name: str, parameter: str) -> tuple[float, float]:
        """Return what is plausible for a parameter, SI."""
        return next((entry.low, entry.high) for entry in self._effects[name].parameters
                    if entry.name == parameter)


def _alone(effect: Effect, parameter: Parameter) -> bool:
    """Say whether an effect acts with this parameter alone, all others neutral."""
    known = dict.fromkeys(READABLE, 1.0)
    size = effect.neutral
    size[parameter.name] = parameter.typical
    return any(evaluate(function, {**known, **size}) != 0.0 for _, function in effect.terms)


def likely(signatures: Signatures, blocks: list[Block], known: Calibration,
           scatter: Mapping[str, float]) -> tuple[Likely, ...]:
    """
    Return the effects that explain the blocks alike well, the likeliest first.

    Parameters
    ----------
    signatures : Signatures
        Of the effects.
    blocks : list of Block
        Since the failure began.
    known : Calibration
        From before it; may still move within what it does not know.
    scatter : mapping of str to float
        Variance from block to block by balance, beyond that of the sensors, SI.

    """
    rows, values, deviations, keys, times = [], [], [], [], []
    for place, block in enumerate(blocks):
        for balance, residual in block.residuals.items():
            deviation = math.sqrt(residual.noise**2 + residual.floor**2
                                  + scatter.get(balance, 0.0)) or 1e-30
            row = known.row(residual)
            rows.append(row / deviation)
            values.append((residual.value - float(row @ known.unit)) / deviation)
            deviations.append(deviation)
            keys.append((place, balance))
            times.append(1e-9 * (0.5 * (block.start + block.end) - blocks[0].start))
    if not rows:
        return ()
    design, error = np.array(rows), np.array(values)
    # The calibration as it was known is a prior: take out what it may still explain.
    sigmas = np.outer(known.spread, known.spread)
    inner = design.T @ design + np.linalg.inv(
        known.covariance / sigmas + 1e-9 * np.eye(len(known.spread))) / sigmas
    absorb = np.linalg.solve(inner, design.T)
    total = float(error @ error - (error @ design) @ (absorb @ error))
    best: dict[str, Likely] = {}
    columns: dict[str, np.ndarray] = {}
    ways = {block.samples.backwards for block in blocks}
    for name, size, fitted in signatures.sizes(len(ways) > 1):
        moved = [signatures.of(name, block, size, fitted) for block in blocks]
        column = np.array([moved[place].get(balance, 0.0) / deviation
                           for (place, balance), deviation in zip(keys, deviations)])
        left = column - design @ (absorb @ column)
        square, along = float(column @ left), float(left @ error)
        if square <= 1e-12 * float(column @ column) or not square:
            continue
        amount = signatures.adopted(name, fitted) + along / square * size[fitted]
        share = along**2 / square / max(total, 1e-30)
        low, high = signatures.bounds(name, fitted)
        if low <= amount <= high and (name not in best or share > best[name].explains):
            best[name] = Likely(name, share, fitted, amount)
            columns[name] = column / size[fitted]
    ranked = sorted(best.values(), key=lambda entry: -entry.explains)
    if not ranked or ranked[0].explains < _LEAST:
        return ()
    near = max(_EQUAL, _CHANCE / max(total, 1e-30))
    return tuple(
        entry._replace(rate=_rate(columns[entry.effect], np.array(times), error, design, absorb))
        for entry in ranked if ranked[0].explains - entry.explains <= near)[:_MOST]


def _rate(column: np.ndarray, times: np.ndarray, error: np.ndarray, design: np.ndarray,
          absorb: np.ndarray) -> tuple[float, float, float] | None:
    """
    Return by how much a size grows in a second, and its 95 % interval.

    ``column`` is what one unit of the size does. A straight line in time, fitted by least squares
    with what the calibration may still explain as correlated errors; errors that are larger than
    thought widen the interval.
    """
    middle = times - times.mean()
    if len(times) < _FEWEST or not np.ptp(middle):
        return None
    both = np.column_stack([column, column * middle])
    left = both - design @ (absorb @ both)
    normal = both.T @ left
    if np.linalg.cond(normal / np.sqrt(np.outer(np.diag(normal), np.diag(normal)))) > 1e8:
        return None
    pull = left.T @ error
    found = np.linalg.solve(normal, pull)
    square = float(error @ error - (error @ design) @ (absorb @ error) - pull @ found)
    wider = max(square / (len(error) - 2), 1.0)
    half = _SURE * math.sqrt(wider * float(np.linalg.inv(normal)[1, 1]))
    return float(found[1]), float(found[1] - half), float(found[1] + half)
