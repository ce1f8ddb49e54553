# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""From the topics of a bag to signals: which topic carries which channel, and its numbers."""
from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
import re
from typing import NamedTuple

from hst_drive.bag.align import align, Signal
from hst_drive.bag.cdr import Codec, MalformedError
from hst_drive.bag.channels import ChannelMap, Entry
from hst_drive.bag.diagnostic_values import known, parse_path, read_values
from hst_drive.bag.mcap_bag import Stream
from hst_drive.bag.rosbag2 import read_bag_streams
from hst_drive.bag.topics import (CHANNEL_FIELDS, DIAGNOSTIC_ARRAY, STANDARD_UNITS, TOPICS,
                                  TRUTH)
from hst_drive.errors import InputError
from hst_drive.measure.run import CHANNELS, Run
from hst_drive.units import si_unit
import numpy as np

_SEC, _NANOSEC = 'header.stamp.sec', 'header.stamp.nanosec'
_SHOWN = 12
_CARRIERS = {topic.name for topic, _ in CHANNEL_FIELDS.values()}
_APART = 1_000_000_000
"""Stamps further than this (ns) from the receive time are of another clock."""


class Pick(NamedTuple):
    """A number to read from a topic: the entry, and the unit where the entry leaves it open."""

    entry: Entry
    path: str
    unit: str
    absolute: bool


def read_bag(path: Path, channel_map: ChannelMap) -> Run:
    """
    Read a bag as a recording on one time base.

    Parameters
    ----------
    path : Path
        Folder, .mcap or .db3 file.
    channel_map : ChannelMap
        What of it is not under our own names.

    Raises
    ------
    InputError
        If it cannot be read or holds nothing of ours.

    """
    mapped = {entry.topic_and_path()[0] for entry in channel_map.entries.values()}
    notes: list[str] = []
    streams = read_bag_streams(
        path, lambda topic: topic in mapped or _tail(topic) in _CARRIERS, notes)
    picks = _own_picks(streams, channel_map, str(path), notes)
    for entry in channel_map.entries.values():
        stream, pick = _mapped_pick(entry, streams, channel_map.source)
        picks.setdefault(id(stream), (stream, []))[1].append(pick)
    if not any(stream.data for stream, _ in picks.values()):
        raise InputError(f'{path}: none of our topics {"has messages" if picks else "is"} in this '
                         f'bag. It holds: {_list(streams)}. Name the ones to use in a channel '
                         'map: --channels MAP.yaml')
    signals, stamped = [], []
    for stream, chosen in picks.values():
        if not stream.data:
            notes.append(f'{stream.topic}: no messages')
            continue
        codec = Codec(stream.type, stream.definition)
        times, values = _read(stream, codec, [pick.path for pick in chosen], str(path))
        for pick in chosen:
            if pick.entry.source and np.isnan(values[pick.path]).all():
                _refuse_beyond(pick, codec, stream, channel_map.source)
        stamped.append((stream, times))
        signals.append([(pick, values[pick.path]) for pick in chosen
                        if not _left_empty(pick, values[pick.path])])
    stamps = _common_clock(stamped, notes)
    return align([_signal(stream, pick, at, raw) for (stream, _), at, group in zip(
        stamped, stamps, signals) for pick, raw in group], path.stem, str(path), notes)


def _signal(stream: Stream, pick: Pick, stamps: np.ndarray, raw: np.ndarray) -> Signal:
    if stream.type == DIAGNOSTIC_ARRAY:     # the others say nothing about this number
        stamps, raw = stamps[~np.isnan(raw)], raw[~np.isnan(raw)]
    return Signal(pick.entry.channel, stamps, pick.entry.to_si(raw, pick.unit, pick.absolute))


def _tail(topic: str) -> str:
    return topic.rpartition('/')[2]


def _own_picks(streams: Sequence[Stream], channel_map: ChannelMap, source: str,
               notes: list[str]) -> dict[int, tuple[Stream, list[Pick]]]:
    """Find the table's topics by the end of their names, whatever the namespace."""
    picks: dict[int, tuple[Stream, list[Pick]]] = {}
    for topic in TOPICS.values():
        fields = [field for field in topic.fields
                  if field.channel and field.channel not in channel_map.entries]
        found = [stream for stream in streams if fields and _tail(stream.topic) == topic.name
                 and _in_namespace(stream.topic, channel_map.namespace)]
        fitting = [stream for stream in found if stream.type == topic.type]
        for stream in found:
            if stream not in fitting:
                notes.append(f'{stream.topic}: is {stream.type}, not {topic.type}; left out')
        fitting = [stream for stream in fitting if stream.data] or fitting[:1]
        if len(fitting) > 1:
            fitting = [stream for stream in fitting
                       if not stream.topic.endswith(f'/{TRUTH}{topic.name}')] or fitting
        if len(fitting) > 1:
            places = ', '.join(stream.topic.rpartition('/')[0] or '/' for stream in fitting)
            raise InputError(
                f'{source}: several drives in one bag (namespaces {places}); choose one with '
                '"namespace: /..." in a channel map: --channels MAP.yaml')
        for stream in fitting:
            picks[id(stream)] = (stream, [
                Pick(Entry(field.channel, ''), field.path, field.unit, field.absolute)
                for field in fields])
    return picks


def _in_namespace(topic: str, namespace: str | None) -> bool:
    return namespace is None or topic.rpartition('/')[0] == namespace.rstrip('/')


def _mapped_pick(entry: Entry, streams: Sequence[Stream], source: str) -> tuple[Stream, Pick]:
    topic, path = entry.topic_and_path()
    where = f'{source}: channels.{entry.channel}'
    by_name = {stream.topic: stream for stream in streams}
    if topic not in by_name:
        near = get_close_matches(topic, by_name, n=1)
        hint = f'did you mean {near[0]}?' if near else f'It holds: {_list(streams)}'
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
    if entry.unit is None and si_unit(unit) != CHANNELS[entry.channel].unit:
        raise InputError(f'{where}: {topic}.{path} is in [{unit}] by its definition, which is '
                         f'no {entry.channel}')
    return stream, Pick(entry, path, unit or '', absolute)


def _refuse_beyond(pick: Pick, codec: Codec, stream: Stream, source: str) -> None:
    """Raise InputError if a map asks for an element that the messages do not have."""
    if stream.type == DIAGNOSTIC_ARRAY:
        raise InputError(f'{source}: channels.{pick.entry.channel}: {stream.topic} has no number '
                         f'{pick.path}; it has {known(stream.data)}')
    arrays = codec.arrays(stream.data[0])
    for step in re.finditer(r'\[([^\[\]]+)\]', pick.path):
        name, element = pick.path[:step.start()], step[1]
        length, names = arrays.get(name, (0, []))
        if element in names[:length] or element.isdecimal() and int(element) < length:
            continue
        there = f'elements 0 to {length - 1}' if length else 'no elements'
        if names[:length]:
            there += f' or {", ".join(names[:length])}'
        raise InputError(f'{source}: channels.{pick.entry.channel}: {stream.topic} has no '
                         f"'{name}[{element}]'; {name} of its messages has length {length}: "
                         f'{there}')


def _list(streams: Sequence[Stream]) -> str:
    names = [f'{stream.topic} ({stream.type})' for stream in streams]
    more = f' and {len(names) - _SHOWN} more' if len(names) > _SHOWN else ''
    return (', '.join(names[:_SHOWN]) + more) or 'no topics'


def _read(stream: Stream, codec: Codec, paths: list[str],
          source: str) -> tuple[np.ndarray | None, dict[str, np.ndarray]]:
    """Return stamps (ns; None if the messages carry none) and numbers of a topic."""
    stamped = codec.has_stamp
    try:
        if stream.type == DIAGNOSTIC_ARRAY:
            values = {**read_values(stream.data, paths),
                      **codec.extract(stream.data, [_SEC, _NANOSEC])}
        else:
            values = codec.extract(stream.data, [*paths, _SEC, _NANOSEC] if stamped else paths)
    except MalformedError as error:
        raise InputError(f'{source}: {stream.topic}: a message does not fit its definition '
                         f'{stream.type} ({error})') from None
    if not stamped:
        return None, values
    stamps = values[_SEC].astype(np.int64) * 1_000_000_000 + values[_NANOSEC].astype(np.int64)
    return stamps, values


def _common_clock(stamped: Sequence[tuple[Stream, np.ndarray | None]],
                  notes: list[str]) -> list[np.ndarray]:
    """Return stamps of one clock: the messages' own ones, or the times of publishing."""
    published = [np.array(stream.publish_time if any(stream.publish_time) else stream.log_time,
                          dtype=np.int64) for stream, _ in stamped]
    if all(_usable(times) for _, times in stamped) and _overlap([at for _, at in stamped]):
        return [times for _, times in stamped]
    own = [_usable(times) and np.median(np.abs(times - other)) < _APART
           for (_, times), other in zip(stamped, published)]
    bare = [stream.topic for (stream, times), good in zip(stamped, own) if not good]
    if any(_usable(times) and not good for (_, times), good in zip(stamped, own)):
        notes.append('not all stamps are of one clock; the times of publishing are used')
        return published
    notes.append(f'{", ".join(bare)}: no stamps; the times of publishing are used')
    return [times if good else other for (_, times), other, good in zip(stamped, published, own)]


def _left_empty(pick: Pick, values: np.ndarray) -> bool:
    """Tell whether a sequence that its message may leave empty (JointState) is empty."""
    return not pick.entry.source and '[' in pick.path and bool(np.isnan(values).all())


def _usable(times: np.ndarray | None) -> bool:
    """Tell whether stamps are filled in: not all zero, and not one and the same all over."""
    return times is not None and (len(times) == 1 or np.count_nonzero(
        np.diff(times)) >= 0.5 * (len(times) - 1))


def _overlap(stamps: Sequence[np.ndarray]) -> bool:
    """Tell whether all the signals share a stretch of time."""
    many = [times for times in stamps if len(times) > 1]
    return not many or max(map(np.min, many)) <= min(map(np.max, many))
