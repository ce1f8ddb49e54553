# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which joint of a sensor_msgs/JointState is read: the rule of the nodes and of the bags."""
from __future__ import annotations

from collections.abc import Mapping, Sequence

_NUMBERS = ('position', 'velocity', 'effort')


class JointChoice:
    """
    Finds one joint in message after message, or says why it cannot tell which one is meant.

    Parameters
    ----------
    joint : str
        Its name; '' for the only joint there is, which must stay the same one.

    """

    def __init__(self, joint: str = ''):
        self.joint = joint
        self._only: str | None = None

    def place(self, arrays: Mapping[str, tuple[int, Sequence[str]]]) -> tuple[int, str]:
        """
        Return the place of the joint in a message, and '' or the reason to refuse the message.

        Parameters
        ----------
        arrays : mapping
            Length of each array of the message, names of its elements (``Codec.arrays``).

        """
        names = list(arrays['velocity'][1])
        lengths = {name: arrays[name][0] for name in _NUMBERS if arrays[name][0]}
        if names and any(length != len(names) for length in lengths.values()):
            sizes = ', '.join(f'{length} of {name}' for name, length in lengths.items())
            return 0, f'{_listed(names)}, but {sizes}'
        if self.joint:
            if names.count(self.joint) == 1:
                return names.index(self.joint), ''
            return 0, (f"{_listed(names)}; expected one named '{self.joint}'"
                       if names else f"its joints have no names; expected '{self.joint}'")
        count = len(names) or max(lengths.values(), default=0)
        if count > 1:
            return 0, f'{_listed(names) if names else f"{count} joints without names"}'
        only = names[0] if names else ''
        if count and self._only is None:
            self._only = only
        if count and only != self._only:
            return 0, f"2 joints in turn ('{self._only}', then '{only}')"
        return 0, ''


def _listed(names: Sequence[str]) -> str:
    return f'{len(names)} joint{"s" * (len(names) > 1)} ({", ".join(names)})'
