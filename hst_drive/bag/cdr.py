# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
CDR, the wire format of ROS 2 messages, from and to arrays of numbers.

Messages of one topic mostly share one layout (strings and sequences of equal lengths). So the
first one is walked by its definition, all that agree with it in every length are read as one
array, and the same is done with the rest. Plain CDR in either byte order, as rmw_fastrtps and
rmw_cyclonedds write it (OMG DDS-XTypes 1.3, 7.4.1, encoding version 1).
"""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
import re
import struct
from typing import Any

from hst_drive.bag.definitions import Member, parse_definition, PRIMITIVES
from hst_drive.errors import InputError
import numpy as np

_HEADER = 4
_STEP = re.compile(r'^(\w+)(?:\[([^\[\]]+)\])?$')
_MAX_GROUPS = 32
_NAMES = ('name', 'joint_names', 'interface_names', 'interface_groups')
"""Arrays that name the elements of those behind them: JointState, those of control_msgs."""


class MalformedError(ValueError):
    """The bytes of a message do not fit its definition."""


class _Walk:
    """One walk through one message: where the wanted numbers are, and what fixes that."""

    def __init__(self, types: dict[str, tuple[Member, ...]], data: bytes, wanted: set[str]):
        if len(data) < _HEADER or data[1] > 1:
            raise MalformedError('not plain CDR')
        self.types = types
        self.data = data
        self.order = '<' if data[1] else '>'
        self.wanted = wanted
        self.arrays = {path.rpartition('[')[0] for path in wanted if path.endswith(']')}
        self.at = _HEADER
        self.offsets: dict[str, tuple[int, str]] = {}
        self.fixed: list[tuple[int, int]] = [(0, _HEADER)]
        self.found: dict[str, tuple[int, list[str]]] = {}   # arrays: length, names of elements

    def align(self, size: int) -> None:
        self.at += -(self.at - _HEADER) % size

    def skip(self, size: int) -> None:
        self.at += size
        if self.at > len(self.data):
            raise MalformedError('message too short')

    def length(self) -> int:
        self.align(4)
        start = self.at
        self.skip(4)
        self.fixed.append((start, 4))
        count = struct.unpack_from(self.order + 'I', self.data, start)[0]
        if count > len(self.data):
            raise MalformedError('length beyond the end of the message')
        return count

    def string(self) -> str:
        count = self.length()
        self.skip(count)
        return self.data[self.at - count:self.at].rstrip(b'\0').decode('utf-8', 'replace')

    def number(self, kind: str, path: str) -> None:
        letter = PRIMITIVES[kind]
        self.align(struct.calcsize(letter))
        if path in self.wanted:
            self.offsets[path] = (self.at, letter)
        self.skip(struct.calcsize(letter))

    def numbers(self, kind: str, path: str, count: int, names: Sequence[str]) -> None:
        letter = PRIMITIVES[kind]
        size = struct.calcsize(letter)
        if not count:
            return
        self.align(size)
        if path in self.arrays:
            for index in range(count):
                for key in (str(index), *names[index:index + 1]):
                    if f'{path}[{key}]' in self.wanted:
                        self.offsets[f'{path}[{key}]'] = (self.at + index * size, letter)
        self.skip(count * size)

    def message(self, kind: str, prefix: str = '') -> None:
        names: list[str] = []
        if kind not in self.types:
            raise MalformedError(f'no definition of {kind}')
        for member in self.types[kind]:
            path = prefix + member.name
            count = self.length() if member.count == -1 else member.count
            if count is not None:
                self.found[path] = (count, names)
            if member.type == 'wstring':
                raise MalformedError('wstring')
            if member.type == 'string':
                start = self.at
                found = [self.string() for _ in range(1 if count is None else count)]
                if count is not None and member.name in _NAMES:
                    names = found
                    self.fixed.append((start, self.at - start))
            elif member.type in PRIMITIVES:
                if count is None:
                    self.number(member.type, path)
                else:
                    self.numbers(member.type, path, count, names)
            elif count is None:
                self.message(member.type, path + '.')
            else:
                for index in range(count):
                    start = self.at
                    for key in (*names[index:index + 1], str(index)):
                        if key.isdecimal() or any(
                                one.startswith(f'{path}[{key}].') for one in self.wanted):
                            self.at = start
                            self.message(member.type, f'{path}[{key}].')


class Codec:
    """
    Reader and writer of the messages of one type.

    Parameters
    ----------
    type_name : str
        E.g. ``'sensor_msgs/msg/JointState'``.
    definition : str
        Its text with dependencies, as a bag holds it.

    """

    def __init__(self, type_name: str, definition: str):
        self.type_name = type_name
        self.types = parse_definition(type_name, definition)

    @property
    def has_stamp(self) -> bool:
        """Whether the message begins with a std_msgs/Header."""
        return self.types[self.type_name][0].type == 'std_msgs/msg/Header'

    def check_path(self, path: str) -> None:
        """
        Check that a path such as ``'velocity[0]'`` leads to a number.

        Raises
        ------
        InputError
            If it does not; the text says what there is.

        """
        kind = self.type_name
        for step in path.split('.'):
            match = _STEP.match(step)
            members = {member.name: member for member in self.types.get(kind, ())}
            if not match or match[1] not in members:
                near = get_close_matches(step, members, n=1)
                hint = f'; did you mean {near[0]!r}?' if near else ''
                raise InputError(f'{kind} has no field {step!r} (path {path!r}){hint} '
                                 f'It has: {", ".join(members) or "none"}')
            member = members[match[1]]
            if (member.count is None) != (match[2] is None):
                raise InputError(f'{kind}.{member.name} is {_describe(member)} (path {path!r})')
            kind = member.type
        if kind not in PRIMITIVES:
            raise InputError(f'path {path!r} of {self.type_name} leads to {kind}, not to a number')

    def extract(self, messages: Sequence[bytes], paths: Sequence[str],
                arrays: list[dict] | None = None) -> dict[str, np.ndarray]:
        """
        Read numbers out of many messages.

        Parameters
        ----------
        messages : sequence of bytes
            As a bag holds them.
        paths : sequence of str
            Where the numbers are.
        arrays : list, optional
            Gets what ``arrays`` returns of each layout that is met.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            float64 by path; NaN where a message has no such element.

        Raises
        ------
        MalformedError
            If a message does not fit the definition.

        """
        out = {path: np.full(len(messages), np.nan) for path in paths}
        by_length: dict[int, list[int]] = {}
        for index, data in enumerate(messages):
            by_length.setdefault(len(data), []).append(index)
        for length, group in by_length.items():
            rows = np.array(group)
            raw = np.frombuffer(b''.join(messages[i] for i in group), np.uint8)
            raw = raw.reshape(len(group), length)
            for _ in range(_MAX_GROUPS):
                rows, raw = self._extract_alike(rows, raw, messages, out, arrays)
                if not len(rows):
                    break
            for index in rows:
                self._extract_alike(np.array([index]), np.frombuffer(
                    messages[index], np.uint8)[None, :], messages, out, arrays)
        return out

    def layout(self, data: bytes, paths: Sequence[str]
               ) -> tuple[dict[str, tuple[int, str]], list[tuple[int, int]]]:
        """
        Return where numbers lie in a message.

        Returns
        -------
        offsets : dict of str to (int, str)
            Place of the first byte, and struct format, by path; a path that the message does
            not have is left out.
        fixed : list of (int, int)
            Place and size of what must be the same in another message for this to hold there.

        Raises
        ------
        MalformedError
            If the message does not fit the definition.

        """
        walk = self._walk(data, paths)
        return ({path: (at, walk.order + letter) for path, (at, letter) in walk.offsets.items()},
                walk.fixed)

    def arrays(self, data: bytes, paths: Sequence[str] = ()
               ) -> dict[str, tuple[int, list[str]]]:
        """
        Return the length of each array of a message, and the names of its elements if any.

        An array within an element that ``paths`` call by its name is there under it, too.
        """
        return self._walk(data, paths).found

    def _walk(self, data: bytes, paths: Sequence[str]) -> _Walk:
        walk = _Walk(self.types, data, set(paths))
        walk.message(self.type_name)
        return walk

    def _extract_alike(self, rows, raw, messages, out, arrays):
        """Read the messages laid out as the first one; return the others."""
        walk = self._walk(messages[rows[0]], tuple(out))
        if arrays is not None:
            arrays.append(walk.found)
        alike = np.ones(len(rows), bool)
        for start, size in walk.fixed:
            alike &= (raw[:, start:start + size] == raw[0, start:start + size]).all(axis=1)
        chosen = raw[alike]
        for path, (start, letter) in walk.offsets.items():
            part = np.ascontiguousarray(chosen[:, start:start + struct.calcsize(letter)])
            out[path][rows[alike]] = part.view(walk.order + letter)[:, 0]
        return rows[~alike], raw[~alike]

    def encode(self, value: Mapping[str, Any]) -> bytes:
        """Return the CDR bytes (little endian) of a message; what is left out is 0 or empty."""
        out = bytearray(b'\0\1\0\0')
        self._encode(self.type_name, value, out)
        return bytes(out)

    def encode_columns(self, template: Mapping[str, Any],
                       columns: Mapping[str, np.ndarray]) -> list[bytes]:
        """
        Return one message per row.

        Parameters
        ----------
        template : mapping
            The message without the numbers.
        columns : mapping of path to ndarray, shape (n,)
            The numbers that change from message to message.

        """
        pattern = self.encode(template)
        walk = self._walk(pattern, tuple(columns))
        count = len(next(iter(columns.values())))
        raw = np.tile(np.frombuffer(pattern, np.uint8), (count, 1))
        for path, (start, letter) in walk.offsets.items():
            values = np.asarray(columns[path]).astype('<' + letter).view(np.uint8)
            raw[:, start:start + struct.calcsize(letter)] = values.reshape(count, -1)
        return [row.tobytes() for row in raw]

    def _encode(self, kind: str, value: Mapping[str, Any], out: bytearray) -> None:
        for member in self.types[kind]:
            item = value.get(member.name)
            if member.count is None:
                self._encode_item(member.type, item, out)
                continue
            items = list(item) if item is not None else [None] * max(member.count, 0)
            if member.count == -1:
                self._encode_item('uint32', len(items), out)
            for one in items:
                self._encode_item(member.type, one, out)

    def _encode_item(self, kind: str, item: Any, out: bytearray) -> None:
        if kind == 'string':
            data = (item or '').encode() + b'\0'
            self._encode_item('uint32', len(data), out)
            out += data
        elif kind in PRIMITIVES:
            letter = PRIMITIVES[kind]
            out += b'\0' * (-(len(out) - _HEADER) % struct.calcsize(letter))
            out += struct.pack('<' + letter, item or 0)
        else:
            self._encode(kind, item or {}, out)


def _describe(member: Member) -> str:
    if member.count is None:
        return 'a single value; leave the [...] out'
    return f'an array; write an element as {member.name}[0]'
