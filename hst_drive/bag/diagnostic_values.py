# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Numbers that travel as text in the key-value pairs of diagnostic_msgs/DiagnosticArray.

The path of such a number is ``status[NAME].values[KEY]``, both as they are written in the
messages; a message may or may not hold that status.
"""
from __future__ import annotations

from collections.abc import Sequence
import re
import struct

from hst_drive.bag.cdr import MalformedError
from hst_drive.errors import InputError
import numpy as np

_PATH = re.compile(r'^status\[(.+?)\]\.values\[(.+?)\](?:\.value)?$')
_SHOWN = 12


def parse_path(path: str) -> tuple[str, str]:
    """
    Return name and key.

    Raises
    ------
    InputError
        If the path has another form.

    """
    match = _PATH.match(path)
    if not match:
        raise InputError(f'path {path!r} of a DiagnosticArray: expected status[NAME].values[KEY]')
    return match[1], match[2]


def read_values(messages: Sequence[bytes], paths: Sequence[str]) -> dict[str, np.ndarray]:
    """
    Return the numbers by path, shape (messages,); NaN where a message holds none.

    Raises
    ------
    MalformedError
        If a message does not fit its definition.

    """
    wanted = {parse_path(path): path for path in paths}
    out = {path: np.full(len(messages), np.nan) for path in paths}
    for row, data in enumerate(messages):
        for key, text in _pairs(data):
            if key in wanted:
                try:
                    out[wanted[key]][row] = float(text)
                except ValueError:
                    pass    # 'n/a' and its kind
    return out


def known(messages: Sequence[bytes]) -> str:
    """Return what the first messages hold, as paths."""
    found = dict.fromkeys(key for data in messages[:200] for key, _ in _pairs(data))
    shown = ', '.join(f'status[{name}].values[{key}]' for name, key in list(found)[:_SHOWN])
    return (shown + (' and more' if len(found) > _SHOWN else '')) or 'no values'


class _Reader:
    """Reads plain CDR from the front."""

    def __init__(self, data: bytes):
        if len(data) < 4 or data[1] > 1:
            raise MalformedError('not plain CDR')
        self.data, self.at = data, 4
        self._number = struct.Struct('<I' if data[1] else '>I')

    def number(self) -> int:
        self.at += -(self.at - 4) % 4
        if self.at + 4 > len(self.data):
            raise MalformedError('message too short')
        value = self._number.unpack_from(self.data, self.at)[0]
        self.at += 4
        return value

    def string(self) -> str:
        count = self.number()
        self.at += count
        if self.at > len(self.data):
            raise MalformedError('message too short')
        return self.data[self.at - count:self.at].rstrip(b'\0').decode('utf-8', 'replace')


def _pairs(data: bytes) -> list[tuple[tuple[str, str], str]]:
    """Return ((status, key), text) of each pair of a message."""
    reader = _Reader(data)
    reader.number(), reader.number(), reader.string()     # the header
    found = []
    for _ in range(reader.number()):
        reader.at += 1                                    # the level
        name, _, _ = reader.string(), reader.string(), reader.string()
        for _ in range(reader.number()):
            key = reader.string()
            found.append(((name, key), reader.string()))
    return found
