# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which topic of a bag carries which channel, by our own table or by a channel map."""
from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
import re
from typing import NamedTuple

from hst_drive.bag.cdr import Codec
from hst_drive.bag.channels import channel_of, ChannelMap, Entry
from hst_drive.bag.diagnostic_values import known, parse_path
from hst_drive.bag.stream import Stream
from hst_drive.bag.topic_numbers import TopicNumbers
from hst_drive.bag.topics import DIAGNOSTIC_ARRAY, Field, STANDARD_UNITS, Topic, TOPICS, TRUTH
from hst_drive.errors import InputError
from hst_drive.units import si_unit

_SHOWN = 12
Key = tuple[str, str]
"""Topic and type."""


class Pick(NamedTuple):
    """A number to read from a topic: the entry, and the unit where the entry leaves it open."""

    entry: Entry
    path: str
    unit: str
    absolute: bool


def own_fields(topic: str, channel_map: ChannelMap) -> list[Field]:
    """Return what a topic carries by our table, whatever its namespace."""
    known = TOPICS.get(topic.rpartition('/')[2])
    if known is None or not _in_namespace(topic, channel_map.namespace):
        return []
    return _fields(known, channel_map)


def _fields(topic: Topic, channel_map: ChannelMap) -> list[Field]:
    return [field for field in topic.fields
            if field.channel and field.channel not in channel_map.entries]


def all_picks(streams: Sequence[Stream], channel_map: ChannelMap, source: str,
              notes: list[str]) -> dict[Key, tuple[Stream, list[Pick]]]:
    """
    Return what to read from which topic.

    Raises
    ------
    InputError
        If there is nothing, not what the channel map names, or more than one drive.

    """
    picks = _own_picks(streams, channel_map, source, notes)
    for entry in channel_map.entries.values():
        stream, pick = mapped_pick(entry, streams, channel_map.source)
        picks.setdefault((stream.topic, stream.type), (stream, []))[1].append(pick)
    if not any(stream.count for stream, _ in picks.values()):
        where = f' under namespace {channel_map.namespace}' if channel_map.namespace else ''
        raise InputError(f'{source}: none of our topics {"has messages" if picks else "is"} in '
                         f'this bag{where}. It holds: {_list(streams)}. Name the ones to use in a '
                         'channel map: --channels MAP.yaml')
    return picks


def _own_picks(streams: Sequence[Stream], channel_map: ChannelMap, source: str,
               notes: list[str]) -> dict[Key, tuple[Stream, list[Pick]]]:
    """Find the table's topics by the end of their names, whatever the namespace."""
    picks: dict[Key, tuple[Stream, list[Pick]]] = {}
    for topic in TOPICS.values():
        fields = _fields(topic, channel_map)
        found = [stream for stream in streams if fields
                 and stream.topic.rpartition('/')[2] == topic.name
                 and _in_namespace(stream.topic, channel_map.namespace)]
        fitting = [stream for stream in found if stream.type == topic.type]
        for stream in found:
            if stream not in fitting:
                notes.append(f'{stream.topic}: is {stream.type}, not {topic.type}; left out')
        fitting = [stream for stream in fitting if stream.count] or fitting[:1]
        if len(fitting) > 1:
            fitting = [stream for stream in fitting
                       if not stream.topic.endswith(f'/{TRUTH}{topic.name}')] or fitting
        if len(fitting) > 1:
            places = ', '.join(stream.topic.rpartition('/')[0] or '/' for stream in fitting)
            raise InputError(
                f'{source}: several drives in one bag (namespaces {places}); choose one with '
                '"namespace: /..." in a channel map: --channels MAP.yaml')
        for stream in fitting:
            picks[stream.topic, stream.type] = (stream, [
                Pick(Entry(field.channel, ''), field.path, field.unit, field.absolute)
                for field in fields])
    return picks


def _in_namespace(topic: str, namespace: str | None) -> bool:
    return namespace is None or topic.rpartition('/')[0] == namespace.rstrip('/')


def mapped_pick(entry: Entry, streams: Sequence[Stream], source: str) -> tuple[Stream, Pick]:
    topic, path = entry.topic_and_path()
    where = f'{source}: channels.{entry.channel}'
    by_name = {stream.topic: stream for stream in streams}
    if topic not in by_name:
        near = get_close_matches(topic, by_name, n=1)
        hint = f'did you mean {near[0]}?' if near else f'it holds: {_list(streams)}'
        raise InputError(f'{where}: the bag has no topic {topic}; {hint}')
    stream = by_name[topic]
    if stream.encoding != 'cdr' or stream.schema_encoding not in ('ros2msg', ''):
        raise InputError(f'{where}: {topic} is encoded as {stream.encoding}/'
                         f'{stream.schema_encoding}; only cdr with ros2msg can be read')
    if not path:
        raise InputError(f'{where}: add the field, e.g. {topic}.data or {topic}.velocity[0]')
    try:
        if stream.type == DIAGNOSTIC_ARRAY:
            parse_path(path)
        else:
            Codec(stream.type, stream.definition).check_path(path)
    except InputError as error:
        raise InputError(f'{where}: {error}') from None
    unit, absolute = STANDARD_UNITS.get((stream.type, path.partition('[')[0]), (None, False))
    if entry.unit is None and unit is None:
        raise InputError(f'{where}: needs its unit, as {stream.type} does not fix it')
    if entry.unit is None and si_unit(unit) != channel_of(entry.channel).unit:
        raise InputError(f'{where}: {topic}.{path} is in [{unit}] by its definition, which is '
                         f'no {entry.channel}')
    return stream, Pick(entry, path, unit or '', absolute)


def refuse_beyond(pick: Pick, topic: TopicNumbers, source: str) -> None:
    """Raise InputError if a map asks for an element that the messages do not have."""
    if topic.type == DIAGNOSTIC_ARRAY:
        raise InputError(f'{source}: channels.{pick.entry.channel}: {topic.topic} has no number '
                         f'{pick.path}; it has {known(topic.first)}')
    arrays = topic.codec.arrays(topic.first[0], [pick.path])
    for step in re.finditer(r'\[([^\[\]]+)\]', pick.path):
        name, element = pick.path[:step.start()], step[1]
        length, names = arrays.get(name, (0, []))
        if element in names[:length] or element.isdecimal() and int(element) < length:
            continue
        there = f'elements 0 to {length - 1}' if length else 'no elements'
        if names[:length]:
            there += f' or {", ".join(names[:length])}'
        raise InputError(f'{source}: channels.{pick.entry.channel}: {topic.topic} has no '
                         f"'{name}[{element}]'; {name} of its messages has length {length}: "
                         f'{there}')


def refuse_joints(picks: Sequence[Pick], topic: TopicNumbers, source: str) -> None:
    """Raise InputError if our own names do not tell which joint of a JointState is meant."""
    own = [pick for pick in picks if not pick.entry.source]
    if own and topic.unclear:
        entries = ', '.join(f"{pick.entry.channel}: '{topic.topic}."
                            f"{pick.path.replace('[0]', '[NAME]')}'" for pick in own)
        raise InputError(f'{source}: {topic.topic}: {topic.unclear}; name the one to read in a '
                         f'channel map, channels: {{{entries}}}: --channels MAP.yaml')


def _list(streams: Sequence[Stream]) -> str:
    names = [f'{stream.topic} ({stream.type})' for stream in streams]
    more = f' and {len(names) - _SHOWN} more' if len(names) > _SHOWN else ''
    return (', '.join(names[:_SHOWN]) + more) or 'no topics'
