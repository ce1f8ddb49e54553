# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Sizes of an effect over a machine's life, and where they jump."""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

_JUMP = 3.0             # standard deviations


class History(NamedTuple):
    """
    Sizes of an effect, SI, with one standard deviation, on days in rising order.

    ``temperatures`` are those of the oil, degC; empty if they are not known. ``thinner``: by how
    much all sizes may be off together, date by date, one standard deviation; it comes instead.
    ``offset``: by how much all may be off by the same, one standard deviation.
    """

    days: np.ndarray
    values: np.ndarray
    sigmas: np.ndarray
    temperatures: np.ndarray = np.empty(0)
    thinner: np.ndarray = np.empty(0)
    offset: float = 0.0

    @property
    def together(self) -> np.ndarray:
        """It is ``thinner``, or none."""
        return self.thinner if len(self.thinner) else np.zeros(len(self.days))


class Jump(NamedTuple):
    """A sudden change between two days: sizes before and after, and how sure a cut is there."""

    after: float
    before: float
    first: float
    last: float
    chance: float


def jumps(history: History, cuts: np.ndarray) -> tuple[Jump, ...]:
    """Return where a cut is likelier than not, and the size jumps beyond chance and growth."""
    found, left = [], cuts.copy()
    while len(left) and left.max() > 0.0:
        place = int(left.argmax())
        first, last = place, place
        # Which of two dates began the new stretch may be open.
        for near in (place - 1, place + 1):
            if 0 <= near < len(left) and left[first:last + 1].sum() < 0.9 and left[near] > 0.1:
                first, last = min(first, near), max(last, near)
        chance = float(left[first:last + 1].sum())
        if chance < 0.5:
            break
        left[first:last + 1] = 0.0
        one, other = history.values[first], history.values[last + 1]
        sigma = np.hypot(history.sigmas[first], history.sigmas[last + 1])
        if abs(_beyond(history, first, last + 1)) > _JUMP * sigma:
            found.append(Jump(float(history.days[first]), float(history.days[last + 1]),
                              float(one), float(other), min(chance, 1.0)))
    return tuple(sorted(found))


def _beyond(history: History, first: int, last: int) -> float:
    """Return by how much a size changes between two dates beyond its growth before and after."""
    days, values = history.days, history.values
    slopes = np.diff(values) / np.diff(days)
    near = [0.0, *slopes[max(first - 1, 0):first], *slopes[last:last + 1]]
    change, gap = values[last] - values[first], days[last] - days[first]
    return float(change - np.clip(change, min(near) * gap, max(near) * gap))
