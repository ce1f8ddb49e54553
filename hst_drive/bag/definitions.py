# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Message definitions: finding their text and hash, and what their text says.

The text that a bag holds is the ``.msg`` file followed by those of all the types that it uses,
depth first and sorted, each after a line of 80 '=' and 'MSG: package/Type': the layout of
rosbag2_storage_mcap.
"""
from __future__ import annotations

from functools import lru_cache
import json
import os
from pathlib import Path
import re
import sys
from typing import NamedTuple

from hst_drive.bag.standard_types import STANDARD_TYPES
from hst_drive.errors import InputError

PRIMITIVES = {
    'bool': '?', 'byte': 'B', 'char': 'B', 'int8': 'b', 'uint8': 'B', 'int16': 'h', 'uint16': 'H',
    'int32': 'i', 'uint32': 'I', 'int64': 'q', 'uint64': 'Q', 'float32': 'f', 'float64': 'd',
}
"""Letter of the ``struct`` module by primitive type; strings apart."""

_SEPARATOR = re.compile(r'\r?\n={80}\r?\nMSG: *(\S+)\r?\n')
_FIELD = re.compile(r'^(?P<type>[A-Za-z][\w/]*)(?P<bound><=\d+)?(?P<array>\[[^\]]*\])?'
                    r'\s+(?P<name>[A-Za-z]\w*)\s*(?P<rest>.*)$')


class Member(NamedTuple):
    """
    One member of a message.

    ``count`` is None for a single value, -1 for a sequence, else the length of the array.
    """

    name: str
    type: str
    count: int | None


def full_type(name: str, package: str = '') -> str:
    """Return ``package/msg/Type`` for 'package/Type', 'package/msg/Type' or a bare 'Type'."""
    parts = name.split('/')
    if len(parts) == 1:
        parts = [package, *parts]
    return f'{parts[0]}/msg/{parts[-1]}'


def parse_members(text: str, package: str) -> tuple[Member, ...]:
    """Return the members that one ``.msg`` text declares, constants left out."""
    members = []
    for line in text.splitlines():
        match = _FIELD.match(line.split('#', 1)[0].strip())
        if not match or match['rest'].startswith('='):
            continue
        kind = match['type']
        if kind not in PRIMITIVES and kind not in ('string', 'wstring'):
            kind = full_type(kind, package)
        size = match['array']
        count = None if size is None else int(size[1:-1]) if size[1:-1].isdigit() else -1
        members.append(Member(match['name'], kind, count))
    return tuple(members) or (Member('structure_needs_at_least_one_member', 'uint8', None),)


@lru_cache(maxsize=64)
def parse_definition(type_name: str, text: str) -> dict[str, tuple[Member, ...]]:
    """
    Return the members of a type and of all that it uses from the text in a bag.

    Parameters
    ----------
    type_name : str
        Type at the top of the text, e.g. ``'sensor_msgs/msg/JointState'``.
    text : str
        Definition with its dependencies.

    """
    parts = _SEPARATOR.split(text)
    names = [full_type(type_name), *(full_type(name) for name in parts[1::2])]
    return {name: parse_members(body, name.split('/')[0])
            for name, body in zip(names, parts[0::2])}


def _share_folders() -> list[Path]:
    prefixes = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    return [Path(prefix) / 'share' for prefix in (*prefixes, sys.prefix) if prefix]


def _own_text(type_name: str) -> str | None:
    package, _, name = type_name.split('/')
    for share in _share_folders():
        path = share / package / 'msg' / f'{name}.msg'
        if path.is_file():
            return path.read_text(encoding='utf-8')
    return STANDARD_TYPES[type_name][0] if type_name in STANDARD_TYPES else None


@lru_cache(maxsize=64)
def find_definition(type_name: str) -> str:
    """
    Return the definition of a type with its dependencies as a bag holds it.

    The ``.msg`` files are looked for in share/ of AMENT_PREFIX_PATH and of this Python.

    Raises
    ------
    InputError
        If a file is not found.

    """
    seen: set[str] = set()
    parts: list[str] = []

    def add(name: str, written: str) -> None:
        if name in seen:
            return
        seen.add(name)
        text = _own_text(name)
        if text is None:
            raise InputError(f'message type {name}: no {name.split("/")[-1]}.msg found in share/ '
                             'of AMENT_PREFIX_PATH; install the package or source its workspace')
        parts.append(text if not parts else f'\n{"=" * 80}\nMSG: {written}\n{text}')
        package = name.split('/')[0]
        wanted = {full_type(member.type) for member in parse_members(text, package)
                  if '/' in member.type}
        for other in sorted(wanted):
            add(other, '/'.join(other.split('/')[::2]))

    add(full_type(type_name), '')
    return ''.join(parts)


@lru_cache(maxsize=64)
def find_hash(type_name: str) -> str:
    """Return the type's hash (RIHS01) from share/, or '' if it is not known."""
    type_name = full_type(type_name)
    package, _, name = type_name.split('/')
    for share in _share_folders():
        path = share / package / 'msg' / f'{name}.json'
        if path.is_file():
            for entry in json.loads(path.read_text(encoding='utf-8')).get('type_hashes', ()):
                if entry.get('type_name') == type_name:
                    return entry['hash_string']
    return STANDARD_TYPES[type_name][1] if type_name in STANDARD_TYPES else ''
