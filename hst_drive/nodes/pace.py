# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""When the next command is due, and how much time it has to account for."""
from __future__ import annotations

BILLION = 1_000_000_000


class Pace:
    """
    The pace at which commands are formed.

    Parameters
    ----------
    sample_time : int
        Time between two commands, ns.
    on_grid : bool
        The times are steps of a simulation: commands stay on a grid of sample times, so that the
        rate of the steps moves none. Else they are those of a clock, and each time counts as
        it is.

    """

    def __init__(self, sample_time: int, on_grid: bool):
        self.sample_time = sample_time
        self._on_grid = on_grid
        self._last: int | None = None

    def restart(self) -> None:
        """Let the next command be the first one."""
        self._last = None

    def due(self, now: int) -> float:
        """
        Return for how long (s) a new command has to account, 0.0 if none is due yet.

        Readings of a real clock are never quite on time: three fifths of a sample time will do,
        which is more than the wait between readings of twice the rate.
        """
        step = self.sample_time
        if self._last is None or now < self._last - step:    # or a simulation begins anew
            self._last = now - step
        passed = now - self._last
        if 5 * passed < 3 * step:
            return 0.0
        if self._on_grid:
            passed = (2 * passed + step - 1) // (2 * step) * step    # the nearest; a half: less
        self._last += passed
        return passed / BILLION


class Rates:
    """How often messages come, once that is known for a whole time; ``period`` in s."""

    def __init__(self, period: float):
        self._period = period
        self._since, self._before = 0.0, {}
        self.found: dict[str, float] = {}

    def count(self, now: float, counts: dict[str, int]) -> bool:
        """Take how many have come by now, s; return whether it is time for that."""
        passed = now - self._since
        if passed < 0.5 * self._period:
            return False    # rclpy's timer may come twice where another one is set anew
        self.found = {name: (count - self._before[name]) / passed
                      for name, count in counts.items() if self._before.get(name)}
        self._since, self._before = now, counts
        return True
