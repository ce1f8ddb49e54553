# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Commands of a record whose rows come now before, now after the controller's step.

A controller that steps as often as the record has rows, and a recorder whose rows come a little
early or late: an early row still shows the last command, and what a late row after an early one
skips is never seen, nor what lost rows would have shown. Held from row to row such commands reach
a replay up to a whole step late.
"""
from __future__ import annotations

from typing import Mapping, NamedTuple

from hst_drive.measure.run import FEWEST
from hst_drive.rig import Rig
import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

_EVEN = 1e-5            # s: steadier time stamps than this are even
_FIRST = 500            # rows for a first guess of the time between them
_SLOWER = 0.1           # share by which that may be off the median of their distances
_OF_LATE = 0.5          # s, for which a step of a command moves the drive
_UNEVEN = 0.2           # of the time between rows: what varies more has no rows of its own
_CONTRARY = 0.05        # share of the changes that may contradict; by chance it is a quarter
HELD = 0.9      # of the misfit of moving commands: below, held ones are nearer to the truth
_USUAL = 0.01   # s between steps of a controller that the rig does not describe


class Between(NamedTuple):
    """How many steps lie from row to row, and whether a command is held over them or moves."""

    steps: int
    held: bool = True

    @classmethod
    def rows(cls, rig: Rig, sample_time: float) -> Between:
        """Return the steps between the rows of a record (s)."""
        period = rig.controller.sample_time if rig.controller else _USUAL
        return cls(max(int(round(sample_time / period)), 1))

    def finer(self, values: np.ndarray, command: bool = False) -> np.ndarray:
        """Return values, shape (n,), at the steps between the rows, too."""
        if self.steps == 1:
            return values
        n = len(values)
        places = np.arange((n - 1) * self.steps + 1) / self.steps
        if command and self.held:
            return values[places.astype(int)]
        return np.interp(places, np.arange(n), values)

    def mean_of_rows(self, command: np.ndarray) -> np.ndarray:
        """Return what a command is on average from each row to the next, if it moves."""
        return command + np.diff(command, append=command[-1]) * (self.steps - 1) / (2 * self.steps)


class Steps(NamedTuple):
    """
    Commands as the controller stepped, from each row to the next.

    ``low`` and ``high`` bound a command that no row shows and ``values`` holds their mean; where
    a row shows it the three are the same. ``jitter`` is how far stamps scatter about even ones, s;
    0 where there are none to tell.
    """

    values: np.ndarray
    low: np.ndarray
    high: np.ndarray
    jitter: float = 0.0

    @property
    def guessed(self) -> bool:
        """Whether there are commands that no row shows."""
        return bool(np.any(self.low != self.high))

    def time_std(self, period: float) -> np.ndarray:
        """
        Return how well it is known when what moves the drive at each row was commanded, s.

        Half a period (s) where one step that no row shows is all that changed of late, next to
        nothing where it is one of many.
        """
        size = max(int(_OF_LATE / period), 1)
        change = np.abs(np.diff(self.values, prepend=self.values[0]))
        # Windows that end at their row: the filters are shifted by half their size.
        hidden = maximum_filter1d(np.abs(self.high - self.low), size, origin=(size - 1) // 2)
        moved = uniform_filter1d(change, size, origin=(size - 1) // 2) * size
        return 0.5 * period * np.minimum(hidden / np.maximum(moved, 1e-12), 1.0)

    def starts(self, period: float) -> np.ndarray:
        """Return the rows, a period (s) apart, behind which it steps after a rest."""
        rows = np.flatnonzero(np.diff(self.values))
        return rows[np.diff(rows, prepend=-len(self.values)) * period > _OF_LATE]

    def draw(self, random: np.random.Generator) -> np.ndarray:
        """Return commands that are as likely."""
        return self.low + (self.high - self.low) * random.random(len(self.values))


def controller_steps(time: np.ndarray, commands: Mapping[str, np.ndarray]) -> dict[str, Steps]:
    """
    Return the commands that the controller gave, row by row.

    The record itself tells whether rows come before and after its steps: then no command changes
    from a late row to an early one.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Stamps, s.
    commands : mapping of str to ndarray, shape (n,)
        What the rows show; no NaN.

    """
    row, late = _grid(time)
    early = late < 0
    straddled = np.std(late) > _EVEN
    if straddled:
        beside = np.diff(row) == 1
        changes = [(np.diff(command) != 0) & beside for command in commands.values()]
        count = sum(int(changed.sum()) for changed in changes)
        contrary = sum(int((changed & ~early[:-1] & early[1:]).sum()) for changed in changes)
        straddled = count >= FEWEST and contrary <= _CONTRARY * count
    if not straddled:
        early = np.zeros(len(time), dtype=bool)
    # From each row to the next: how many steps there were, and which of them the two rows show.
    count = np.append(np.diff(row), 1)
    next_early = np.append(early[1:], False)
    seen_late = np.where(count == 1, early & next_early, next_early / count)
    unseen = np.where(count == 1, early & ~next_early, (count - ~early - next_early) / count)
    steps = {}
    for name, command in commands.items():
        after = np.append(command[1:], command[-1])
        low = command + (after - command) * seen_late
        high = low + (after - command) * unseen
        steps[name] = Steps(0.5 * (low + high), low, high, float(np.std(late)))
    return steps


def _grid(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the number of each row, those that are lost counted, and how late it is, s.

    As they come, and none late, where that is not clear.
    """
    plain = np.arange(len(time))
    if len(time) < FEWEST:
        return plain, np.zeros(len(time))
    known = min(_FIRST, len(time))
    origin, period = _beat(time[:known])
    while True:
        row = np.round((time[:known] - origin) / period)
        if known == len(time):
            break
        origin, period = np.polynomial.Polynomial.fit(row, time[:known], 1).convert().coef
        known = min(2 * known, len(time))
    # One that is late by half a step counts as the next: two have that number then, none its own.
    twice = np.flatnonzero(np.diff(row) == 0)
    room = np.append(np.inf, np.diff(row))[twice] > 1
    row[twice[room]] -= 1
    row[twice[~room] + 1] += 1
    late = time - np.polynomial.Polynomial.fit(row, time, 1)(row)
    if np.all(np.diff(row) > 0) and np.std(late) < _UNEVEN * period:
        return (row - row[0]).astype(int), late
    return plain, np.zeros(len(time))


def _beat(time: np.ndarray) -> tuple[float, float]:
    """Return a time (s) and a period (s) on whose multiples most of the stamps lie."""
    usual = float(np.median(np.diff(time)))
    periods = usual * np.arange(1 - _SLOWER, 1 + _SLOWER, 0.2 / len(time))
    since = time - time[0]
    waves = np.exp(2j * np.pi * since / periods[:, None]).mean(axis=1)
    best = int(np.argmax(np.abs(waves)))
    period = float(periods[best])
    return float(time[0] + period * np.angle(waves[best]) / (2 * np.pi)), period
