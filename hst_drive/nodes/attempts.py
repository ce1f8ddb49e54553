# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How often, and when, something that was refused is tried again. No ROS here."""
from __future__ import annotations

from typing import NamedTuple

LONGEST = 30.0      # s between two attempts


class _Refusal(NamedTuple):
    """How many attempts in a row were refused, why the last one was, when it is due again (s)."""

    count: int
    why: str
    again: float


class Attempts:
    """
    Attempts by name: so many in a row, each wait twice as long as the one before.

    Parameters
    ----------
    most : int
        Attempts in a row.
    wait : float
        s after the first.

    Attributes
    ----------
    refusals : int
        How many there were in all.

    """

    def __init__(self, most: int, wait: float):
        self._most, self._wait = most, wait
        self._refusals: dict[str, _Refusal] = {}
        self.refusals = 0

    def refused(self, name: str, why: str, now: float) -> str:
        """Take a refusal at ``now`` (s); return what becomes of it, in words."""
        count = self._refusals[name].count + 1 if name in self._refusals else 1
        self.refusals += 1
        wait = min(self._wait * 2.0**(count - 1), LONGEST)
        self._refusals[name] = _Refusal(count, why, now + wait)
        return self.told(name) + (f', again in {wait:g} s' if count < self._most else '')

    def is_due(self, name: str, now: float) -> bool:
        """Return whether it was refused and shall be tried again at ``now``, s."""
        found = self._refusals.get(name)
        return found is not None and found.count < self._most and now >= found.again

    def told(self, name: str) -> str:
        """Return what is to be told of its refusals; '' without one."""
        found = self._refusals.get(name)
        if found is None:
            return ''
        given_up = 'given up: ' if found.count >= self._most else ''
        return f'({given_up}attempt {found.count} of {self._most} refused: {found.why})'

    def given_up(self) -> bool:
        """Return whether there is one that is not tried any more."""
        return any(found.count >= self._most for found in self._refusals.values())

    def forget(self, name: str) -> None:
        """Begin anew: it went well, or is another process now."""
        self._refusals.pop(name, None)
