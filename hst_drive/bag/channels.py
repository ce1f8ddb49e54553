# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Channel maps: foreign column or topic names, fields and units to ours, of logs and live topics.

A map is a YAML file (``config/channels_example.yaml``)::

    channels:
      pump_outlet_pressure: {from: P_pump, unit: psi}
      motor_inlet_pressure: {from: /rig/p2.fluid_pressure}
      motor_speed: {from: '/rig/motor/state.velocity[0]', unit: rad/s}
      load_torque: {from: '/joint_states.effort[drill]', scale: -1}
      pump_command: {from: AI3, unit: V, scale: 2.0, offset: -0.05}
      oil_temperature: T_oil[degF]
      case_drain_flow: {from: '/plc.data[7]', unit: L/min}
      motor_inlet_pressure: {minus: ['p_A[bar]', 'p_B[bar]']}
      motor_torque: {from: '/diagnostics.status[drill: torque].values[shaft]', unit: N.m}
    time: {from: t, unit: ms}
    namespace: /rig1/drive

* The keys of ``channels`` are our names; ``from`` is a column of a CSV file (with or without its
  unit in brackets), or a topic, a dot and the path of a field. An element of an array is
  written ``[0]``, or ``[name]`` where the message has an array ``name``, as JointState has. A
  number in a DiagnosticArray is ``status[NAME].values[KEY]``.
* ``unit``: of the number as recorded, after scale and offset. It may be left out where the
  column's header or the message's definition (FluidPressure, Temperature, JointState) says it.
* ``scale``, ``offset``: value = scale * recorded + offset, before the unit counts.
* ``minus``: the difference of two, the first minus the second; each is written as any entry.
* ``absolute: true``: the pressure is absolute; 101325 Pa are taken off. FluidPressure is
  absolute unless the map says ``absolute: false``.
* ``time`` names the time column of a CSV file; ``namespace`` picks one of several drives in a
  bag. What the map does not name is looked for under our own names.
"""
from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
import os
from typing import Any, NamedTuple

from hst_drive.bag.topics import ATMOSPHERE
from hst_drive.channels import Channel, CHANNELS
from hst_drive.errors import InputError
from hst_drive.rig.yaml_file import read_yaml
from hst_drive.units import canonical, si_unit, to_si, UnitError
import numpy as np

_KEYS = ('from', 'unit', 'scale', 'offset', 'absolute')
_TOP = ('channels', 'time', 'namespace')
_MINUS = ' minus'       # behind a channel's name: what is taken off it


class Entry(NamedTuple):
    """
    Where one channel comes from; ``unit`` and ``absolute`` are None where not given.

    What is taken off a channel is an entry, too (``minus`` of the map).
    """

    channel: str
    source: str
    unit: str | None = None
    scale: float = 1.0
    offset: float = 0.0
    absolute: bool | None = None

    def topic_and_path(self) -> tuple[str, str]:
        """Split ``/topic.path`` at the first dot; the path is '' if there is none."""
        topic, _, path = self.source.partition('.')
        return topic, path

    def to_si(self, raw, unit: str, absolute: bool = False):
        """
        Convert recorded numbers to the channel's SI values.

        ``unit`` and ``absolute`` count where the map leaves them open.
        """
        value = to_si(self.scale * raw + self.offset, self.unit or unit)
        taken = absolute if self.absolute is None else self.absolute
        return value - ATMOSPHERE if taken else value


@dataclass(frozen=True)
class ChannelMap:
    """Entries by channel, that of the time column, and the file that they come from."""

    entries: Mapping[str, Entry] = field(default_factory=dict)
    time: Entry | None = None
    namespace: str | None = None
    source: str = ''


def load_channel_map(path: str | os.PathLike[str]) -> ChannelMap:
    """
    Read a channel map.

    Raises
    ------
    InputError
        If the file is missing or anything in it is not understood; names file and key.

    """
    return parse_channel_map(read_yaml(path), str(path))


def parse_channel_map(data: Any, source: str = 'channel map') -> ChannelMap:
    """Return the channel map that a parsed YAML document means; errors as in the loader."""
    if not isinstance(data, dict) or not data:
        raise InputError(f'{source}: expected a mapping with the key "channels"')
    for key in data:
        if key not in _TOP:
            raise InputError(f'{source}: unknown key {key!r}{_near(str(key), _TOP)}')
    channels = data.get('channels') or {}
    if not isinstance(channels, dict):
        raise InputError(f'{source}: channels must map our names to columns or topics')
    entries = {}
    for name, value in channels.items():
        if name not in CHANNELS:
            raise InputError(f'{source}: channels.{name}: no such channel'
                             f'{_near(str(name), CHANNELS)} Known: {", ".join(CHANNELS)}')
        where = f'{source}: channels.{name}'
        if not isinstance(value, dict) or 'minus' not in value:
            entries[name] = entry_of(name, value, where, CHANNELS[name].unit)
            continue
        if set(value) != {'minus'} or not isinstance(value['minus'], list) or (
                len(value['minus']) != 2):
            raise InputError(f'{where}: expected {{minus: [FIRST, SECOND]}} and nothing beside, '
                             f'found {value!r}')
        if any(isinstance(part, dict) and 'minus' in part for part in value['minus']):
            raise InputError(f'{where}.minus: one difference cannot stand in another; expected '
                             'columns or topics')
        for key, part in zip((name, name + _MINUS), value['minus']):
            entries[key] = entry_of(key, part, f'{where}.minus', CHANNELS[name].unit)
    time = data.get('time')
    namespace = data.get('namespace')
    if namespace is not None and not (isinstance(namespace, str) and namespace.startswith('/')):
        raise InputError(f'{source}: namespace must be a name that begins with /, '
                         f'found {namespace!r}')
    return ChannelMap(entries, None if time is None else entry_of(
        'time', time, f'{source}: time', 's'), namespace, source)


def channel_of(name: str) -> Channel:
    """Return the channel of an entry, also of what is taken off one."""
    return CHANNELS[name.removesuffix(_MINUS)]


def parts_of(channel_map: ChannelMap, channel: str) -> list[Entry]:
    """Return the entry of a channel, and that of what is taken off it if there is one."""
    return [channel_map.entries[name] for name in (channel, channel + _MINUS)
            if name in channel_map.entries]


def lone(channel_map: ChannelMap, there: Container[str]) -> list[str]:
    """Return the channels that are there without what the map takes off them."""
    return [name.removesuffix(_MINUS) for name in channel_map.entries if name.endswith(_MINUS)
            and name not in there and name.removesuffix(_MINUS) in there]


def differences(channels: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return channels without what is taken off them."""
    return {name: values - channels[name + _MINUS] if name + _MINUS in channels else values
            for name, values in channels.items() if not name.endswith(_MINUS)}


def entry_of(name: str, value: Any, where: str, si: str) -> Entry:
    """Return the entry that a value of a channel map means; ``si`` is the quantity's unit."""
    if isinstance(value, str):
        value = {'from': value}
    if not isinstance(value, dict) or not isinstance(value.get('from'), str) \
            or not value['from'].strip():
        raise InputError(f'{where}: expected {{from: COLUMN or /topic.field, unit: ...}}, '
                         f'found {value!r}')
    for key in value:
        if key not in _KEYS:
            raise InputError(f'{where}: unknown key {key!r}{_near(str(key), _KEYS)}')
    numbers = []
    for key, default in (('scale', 1.0), ('offset', 0.0)):
        number = value.get(key, default)
        if isinstance(number, bool) or not isinstance(number, (int, float)) \
                or not abs(number) < 1e300:     # nor nan, nor an integer beyond floats
            raise InputError(f'{where}.{key}: expected a number, found {number!r}')
        numbers.append(float(number))
    if numbers[0] == 0.0:
        raise InputError(f'{where}.scale: 0 would wipe the signal out')
    absolute = value.get('absolute')
    if absolute is not None and (not isinstance(absolute, bool) or si != 'Pa'):
        raise InputError(f'{where}.absolute: only for pressures, true or false')
    unit = value.get('unit')
    return Entry(name, value['from'].strip(), None if unit is None else check_unit(
        str(unit), si, f'{where}.unit'), *numbers, absolute)


def check_unit(unit: str, si: str, where: str) -> str:
    """
    Return a unit in the table's spelling if it has the dimension of ``si``.

    Raises
    ------
    InputError
        Otherwise; ``where`` begins the text.

    """
    try:
        if si_unit(unit) == si:
            return canonical(unit)
    except UnitError as error:
        raise InputError(f'{where}: {error}; expected one like [{si}]') from None
    raise InputError(f'{where}: [{unit}] is a unit of another quantity; expected one like [{si}]')


def split_header(text: str) -> tuple[str, str | None]:
    """Return name and unit, as written, of a column header; None where it names no unit."""
    text = text.strip()
    name, bracket, unit = text.partition('[')
    if not bracket and text.endswith(')'):
        name, _, unit = text.partition('(')
        # What stands in round brackets may as well be a remark, or the number of a copy.
        return (name.strip(), unit[:-1].strip()) if is_unit(unit[:-1]) else (text, None)
    return name.strip(), unit.rstrip(' ]') if bracket and unit.endswith(']') else None


def is_unit(text: str) -> bool:
    """Say whether a text is a unit, other than that of a bare number."""
    try:
        return canonical(text) not in ('1', '')
    except UnitError:
        return False


def column_of(entry: Entry, header: Sequence[str], path: str, mapped: str) -> int:
    """Return the column of an entry of the map ``mapped``; raise InputError without just one."""
    names = [split_header(cell)[0] for cell in header]
    for known in (header, names):
        if known.count(entry.source) > 1:
            raise InputError(f'{path}: column {entry.source!r} comes twice; keep one')
        if entry.source in known:
            return known.index(entry.source)
    near = get_close_matches(entry.source, [*header, *names], n=1)
    raise InputError(f'{mapped}: {entry.channel}: {path} has no column {entry.source!r}'
                     + (f'; did you mean {near[0]!r}?' if near else ''))


def picked(entries: Iterable[Entry], header: Sequence[str], path: str, mapped: str,
           written: Callable[[str], str]) -> list[tuple[int, Entry, str]]:
    """Return column, entry and unit of each; ``written`` is the unit that people give one in."""
    picks: list[tuple[int, Entry, str]] = []
    bare: dict[str, str] = {}
    for entry in entries:
        column = column_of(entry, header, path, mapped)
        cell, usual = header[column], written(entry.channel)
        name, unit = split_header(cell)
        unit = entry.unit or unit
        if unit is None:
            bare[cell] = f'{name}[{usual}]'
        else:
            picks.append((column, entry, check_unit(
                unit, si_unit(usual), f'{path}: column {cell!r}')))
    if bare:
        one = len(bare) == 1
        raise InputError(f"{path}: {'column' if one else 'columns'} "
                         f"{', '.join(map(repr, bare))} {'has' if one else 'have'} no unit; write "
                         f"{'it' if one else 'them'} as {', '.join(bare.values())}")
    return picks


def left_out(name: str, known, cutoff: float) -> str:
    """Return the note for a column that is not known, with the known name that is near it."""
    near = get_close_matches(name.lower(), known, n=1, cutoff=cutoff)
    return (f'column {name!r} is not known; left out'
            + (f' (did you mean {near[0]!r}?)' if near else ''))


def _near(word: str, known) -> str:
    near = get_close_matches(word.lower(), list(known), n=1)
    return f'; did you mean {near[0]!r}?' if near else '.'
