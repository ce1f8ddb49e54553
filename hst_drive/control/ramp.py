# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The straight way of a command to zero stroke."""
from __future__ import annotations

import math


class Ramp:
    """
    A ramp to 0 V, from either side.

    Parameters
    ----------
    time : float
        When it begins, s.
    command : float
        From where, V.

    """

    def __init__(self, time: float, command: float):
        self.time, self.command = time, command

    def follow(self, now: float, rate: float) -> float:
        """Return the command (V) at ``now`` (s), which falls by ``rate`` (V/s)."""
        left = abs(self.command) - rate * max(0.0, now - self.time)
        self.time = max(now, self.time)
        self.command = math.copysign(left, self.command) if left > 0.0 else 0.0
        return self.command
