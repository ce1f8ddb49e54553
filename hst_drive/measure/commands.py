# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Commands of a record whose rows come now before, now after the controller's step.

A controller that steps as often as the record has rows, and a recorder whose rows come a little
early or late: an early row still shows the last command, and what a late row after an early one
skips is never seen. Held from row to row such commands reach a replay up to a whole step late.
"""
from __future__ import annotations

from typing import Mapping, NamedTuple

import numpy as np

_EVEN = 1e-5            # s: steadier time stamps than this are even
_FEWEST = 8             # changes of the command below which nothing can be told
_CONTRARY = 0.05        # share of the changes that may contradict; by chance it is a quarter


class Steps(NamedTuple):
    """
    Commands as the controller stepped, from each row to the next.

    ``low`` and ``high`` bound a command that no row shows and ``values`` holds their mean; where
    a row shows it the three are the same.
    """

    values: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @property
    def guessed(self) -> bool:
        """Whether there are commands that no row shows."""
        return bool(np.any(self.low != self.high))

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
    row = np.arange(len(time))
    late = time - np.polynomial.Polynomial.fit(row, time, 1)(row) if len(row) > 2 else 0.0 * row
    early = late < 0
    straddled = _EVEN < np.std(late) < 0.2 * np.ptp(time) / len(time)
    if straddled:
        changes = [np.diff(command) != 0 for command in commands.values()]
        count = sum(int(changed.sum()) for changed in changes)
        contrary = sum(int((changed & ~early[:-1] & early[1:]).sum()) for changed in changes)
        straddled = count >= _FEWEST and contrary <= _CONTRARY * count
    if not straddled:
        return {name: Steps(command, command, command) for name, command in commands.items()}
    next_early = np.append(early[1:], False)
    unseen = early & ~np.append(early[1:], True)
    steps = {}
    for name, command in commands.items():
        after = np.append(command[1:], command[-1])
        low = np.where(early & next_early, after, command)
        high = np.where(unseen, after, low)
        steps[name] = Steps(0.5 * (low + high), low, high)
    return steps
