# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""From the messages of a bag to signals on one clock."""
from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from hst_drive.bag.align import align, alternates, Signal
from hst_drive.bag.channels import channel_of, ChannelMap, lone
from hst_drive.bag.clock import set_forward_again
from hst_drive.bag.picks import (all_picks, Key, mapped_pick, own_fields, Pick, refuse_beyond,
                                 refuse_joints)
from hst_drive.bag.rosbag2 import bag_blocks
from hst_drive.bag.stream import Stream
from hst_drive.bag.topic_numbers import TopicNumbers
from hst_drive.bag.topics import DIAGNOSTIC_ARRAY, TOPICS
from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.measure.run import Run
import numpy as np

_APART = 1_000_000_000
"""Stamps further than this (ns) from the receive time are of another clock."""
_LATE = 25_000_000      # ns; sensors' own delays are shorter
_SAMPLE = 1_000_000     # messages that medians are taken of


def read_bag(path: Path, channel_map: ChannelMap, only: Container[str] = CHANNELS) -> Run:
    """
    Read a bag as a recording on one time base.

    Parameters
    ----------
    path : Path
        Folder, .mcap or .db3 file.
    channel_map : ChannelMap
        What of it is not under our own names.
    only : container of str
        Names of channels; others are left out.

    Raises
    ------
    InputError
        If it cannot be read or holds nothing of ours.

    """
    signals = BagSignals(path, channel_map, only)
    for streams in bag_blocks(path, signals.wanted, signals.notes):
        signals.take(streams)
    return align(signals.signals(), path.stem, str(path), signals.notes)


class BagSignals:
    """
    The numbers of a bag's topics, taken block by block, and the signals that they are.

    Parameters
    ----------
    path, channel_map, only
        As for ``read_bag``.
    on_disk : bool
        Whether the numbers are kept in files instead of the memory.

    Attributes
    ----------
    notes : list of str
        What a person should know.

    """

    def __init__(self, path: Path, channel_map: ChannelMap, only: Container[str] = CHANNELS,
                 on_disk: bool = False):
        self.notes: list[str] = []
        self._path = path
        self._map = channel_map
        self._only = only
        self._on_disk = on_disk
        self._mapped = {entry.channel: entry.topic_and_path()[0]
                        for entry in channel_map.entries.values()}
        self._streams: list[Stream] = []
        self._topics: dict[Key, TopicNumbers] = {}

    def wanted(self, topic: str) -> bool:
        """Tell whether a topic may carry one of the channels."""
        channels = [channel for channel, source in self._mapped.items() if source == topic]
        channels += [field.channel for field in own_fields(topic, self._map)]
        return any(channel_of(channel).name in self._only for channel in channels)

    def take(self, streams: Sequence[Stream]) -> None:
        """Take the messages of a block; all topics known so far come with it."""
        for stream in streams:
            key = stream.topic, stream.type
            if stream.data and key not in self._topics and (paths := self._paths(stream)):
                self._topics[key] = TopicNumbers(stream, paths, self._on_disk)
            if key in self._topics:
                self._topics[key].take(stream, str(self._path))
        self._streams = [stream.emptied() for stream in streams]

    def _paths(self, stream: Stream) -> list[str]:
        """Return where the numbers are that may be wanted of a topic; ``all_picks`` decides."""
        paths = []
        if TOPICS.get(stream.topic.rpartition('/')[2], stream).type == stream.type:
            paths += [field.path for field in own_fields(stream.topic, self._map)]
        for entry in self._map.entries.values():
            if self._mapped[entry.channel] == stream.topic:
                try:
                    paths.append(mapped_pick(entry, [stream], self._map.source)[1].path)
                except InputError:
                    pass    # a topic may have come under two types
        return paths

    def signals(self) -> list[Signal]:
        """Return the signals of all that was taken; raises as ``timed`` does."""
        signals = self.whole([
            signal for timed in sorted(self.timed()) for signal in signals_of(
                timed.topic, timed.wanted, timed.stamps, timed.topic.numbers, self.notes)])
        if not signals:
            raise InputError(f'{self._path}: none of our topics holds one signal alone')
        return signals

    def whole(self, signals: list[Signal]) -> list[Signal]:
        """Return signals without those of which what is taken off them is missing."""
        halves = lone(self._map, {signal.channel for signal in signals})
        for name in halves:
            note = f'{name}: what the map takes off it is missing; left out'
            if note not in self.notes:
                self.notes.append(note)
        return [signal for signal in signals if signal.channel not in halves]

    def timed(self) -> Iterator[Timed]:
        """
        Yield the topics with the stamps of one clock, one by one, in any order.

        Raises
        ------
        InputError
            If the bag holds nothing of ours, or not what the channel map asks for.

        """
        chosen = []
        for key, (stream, wanted) in all_picks(self._streams, self._map, str(self._path),
                                               self.notes).items():
            topic = self._topics.get(key)
            if topic is None:
                self.notes.append(f'{stream.topic}: no messages')
                continue
            refuse_joints([pick for pick in wanted if pick.path in topic.seen], topic,
                          str(self._path))
            for pick in wanted:
                if pick.entry.source and pick.path not in topic.seen:
                    refuse_beyond(pick, topic, self._map.source)
            chosen.append((topic, [
                pick for pick in wanted if channel_of(pick.entry.channel).name in self._only
                and (pick.path in topic.seen or not _may_be_empty(pick))]))
        clocked = _common_clock([topic for topic, _ in chosen], self.notes)
        if not any(wanted for _, wanted in chosen):
            raise InputError(f'{self._path}: none of our topics holds a number')
        for number, stamps in set_forward_again(clocked, self.notes):
            yield Timed(number, *chosen[number], stamps)


class Timed(NamedTuple):
    """
    A topic, what is wanted of it, and when its messages were true (ns).

    ``number`` is its place among the topics; stamps are in the order in which they were written.
    """

    number: int
    topic: TopicNumbers
    wanted: list[Pick]
    stamps: np.ndarray


class _Clocked(NamedTuple):
    """A topic as ``set_forward_again`` takes it; its stamps, or when it was published."""

    topic: TopicNumbers
    as_published: bool

    @property
    def name(self) -> str:
        return self.topic.topic

    @property
    def order(self) -> np.ndarray:
        return self.topic.order

    @property
    def stamps(self) -> np.ndarray:
        return self.topic.published if self.as_published else self.topic.stamps


class _Clock(NamedTuple):
    """What tells whether a topic's stamps can be used."""

    usable: bool
    first: int
    last: int
    count: int
    age: float      # ns from stamp to publishing, median
    apart: float    # ns between the two, median

    @classmethod
    def of(cls, topic: TopicNumbers) -> _Clock:
        stamps = topic.stamps
        if not _usable(stamps):
            return cls(False, 0, 0, 0, 0.0, np.inf)
        some = slice(None, None, max(len(stamps) // _SAMPLE, 1))
        age = topic.published[some] - stamps[some]
        return cls(True, int(stamps.min()), int(stamps.max()), len(stamps),
                   float(np.median(age)), float(np.median(np.abs(age))))


def signals_of(topic: TopicNumbers, wanted: Sequence[Pick], stamps: np.ndarray,
               numbers: Callable[[str], np.ndarray], notes: list[str]) -> list[Signal]:
    """Return the signals that the numbers of a topic are; none if it mixes two sources."""
    signals = []
    for pick in wanted:
        at, raw = stamps, numbers(pick.path)
        if topic.type == DIAGNOSTIC_ARRAY:     # the others say nothing about this number
            at, raw = stamps[~np.isnan(raw)], raw[~np.isnan(raw)]
        signals.append(Signal(pick.entry.channel, at,
                              pick.entry.to_si(raw, pick.unit, pick.absolute)))
    mixed = [signal.channel for signal in signals if alternates(signal)]
    if not mixed:
        return signals
    note = (f'{topic.topic}: its messages alternate between two signals ({", ".join(mixed)}); '
            'are there two publishers? Left out')
    if note not in notes:
        notes.append(note)
    return []


def _common_clock(topics: Sequence[TopicNumbers], notes: list[str]) -> list[_Clocked]:
    """Return the topics on one clock: the messages' own stamps, or the times of publishing."""
    for topic in topics:
        if topic.stamped and (unset := int(topic.unset.sum())):
            notes.append(f'{topic.topic}: {unset} messages with stamp 0, which is none; the times '
                         'of publishing are used for them')
    clocks = [_Clock.of(topic) for topic in topics]
    _out_of_step([topic.topic for topic in topics], clocks, notes)
    if all(clock.usable for clock in clocks) and _overlap(clocks):
        return [_Clocked(topic, False) for topic in topics]
    own = [clock.usable and clock.apart < _APART for clock in clocks]
    bare = [topic.topic for topic, good in zip(topics, own) if not good]
    if any(clock.usable and not good for clock, good in zip(clocks, own)):
        notes.append('not all stamps are of one clock; the times of publishing are used')
        return [_Clocked(topic, True) for topic in topics]
    if bare:
        notes.append(f'{", ".join(bare)}: no stamps; the times of publishing are used')
    return [_Clocked(topic, not good) for topic, good in zip(topics, own)]


def _out_of_step(names: Sequence[str], clocks: Sequence[_Clock], notes: list[str]) -> None:
    """Tell of topics whose stamps lie further before their publishing than those of others."""
    ages = {name: clock.age for name, clock in zip(names, clocks) if clock.usable}
    usual = float(np.median(list(ages.values()))) if ages else 0.0
    for name, age in ages.items():
        if _LATE < abs(age - usual) and abs(age) < _APART:
            notes.append(f'{name}: its messages are published {age / 1e6:.3g} ms after their '
                         f'stamps, others {usual / 1e6:.3g} ms: is its clock in step?')


def _may_be_empty(pick: Pick) -> bool:
    """Tell whether a pick is of a sequence that its message may leave empty (JointState)."""
    return not pick.entry.source and '[' in pick.path


def _usable(times: np.ndarray | None) -> bool:
    """Tell whether stamps are filled in: at least half of them differ from the one before."""
    return times is not None and (len(times) == 1 or np.count_nonzero(
        np.diff(times)) >= 0.5 * (len(times) - 1))


def _overlap(clocks: Sequence[_Clock]) -> bool:
    """Tell whether all the signals share a stretch of time."""
    many = [clock for clock in clocks if clock.count > 1]
    return not many or max(clock.first for clock in many) <= min(clock.last for clock in many)
