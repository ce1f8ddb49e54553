# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The steps of the controller between the rows of a record that is slower than it."""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.rig import Rig
import numpy as np

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

    def at_rows(self, values: np.ndarray) -> np.ndarray:
        """Return what belongs to the rows of values at all steps."""
        return values[::self.steps]
