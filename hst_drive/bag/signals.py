# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""From the messages of a bag to signals on one clock."""
from __future__ import annotations

from collections.abc import Container, Sequence
from pathlib import Path

from hst_drive.bag.align import align, Signal
from hst_drive.bag.channels import ChannelMap
from hst_drive.bag.mcap_records import Stream
from hst_drive.bag.picks import all_picks, Key, mapped_pick, own_fields, Pick, refuse_beyond
from hst_drive.bag.rosbag2 import bag_blocks
from hst_drive.bag.topic_numbers import TopicNumbers
from hst_drive.bag.topics import DIAGNOSTIC_ARRAY, TOPICS
from hst_drive.measure.run import CHANNELS, Run
import numpy as np

_APART = 1_000_000_000
"""Stamps further than this (ns) from the receive time are of another clock."""


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

    Attributes
    ----------
    notes : list of str
        What a person should know.

    """

    def __init__(self, path: Path, channel_map: ChannelMap, only: Container[str] = CHANNELS):
        self.notes: list[str] = []
        self._path = path
        self._map = channel_map
        self._only = only
        self._mapped = {entry.channel: entry.topic_and_path()[0]
                        for entry in channel_map.entries.values()}
        self._streams: list[Stream] = []
        self._topics: dict[Key, TopicNumbers] = {}
        self._own_clock: dict[Key, bool] = {}
        self._forgotten = -np.inf

    def wanted(self, topic: str) -> bool:
        """Tell whether a topic may carry one of the channels."""
        channels = [channel for channel, source in self._mapped.items() if source == topic]
        channels += [field.channel for field in own_fields(topic, self._map)]
        return any(channel in self._only for channel in channels)

    def take(self, streams: Sequence[Stream]) -> None:
        """Take the messages of a block; all topics known so far come with it."""
        for stream in streams:
            key = stream.topic, stream.type
            if stream.data and key not in self._topics:
                own = TOPICS.get(stream.topic.rpartition('/')[2])
                paths = [field.path for field in own_fields(stream.topic, self._map)
                         if own and own.type == stream.type]
                paths += [mapped_pick(entry, [stream], self._map.source)[1].path
                          for entry in self._map.entries.values()
                          if self._mapped[entry.channel] == stream.topic]
                if paths:
                    self._topics[key] = TopicNumbers(stream, paths)
            if key in self._topics:
                self._topics[key].take(stream, str(self._path))
        self._streams = [stream.emptied() for stream in streams]

    def signals(self, low: float = -np.inf, high: float = np.inf) -> list[Signal]:
        """
        Return the signals with stamps from ``low`` to ``high`` (ns) of one clock.

        Raises
        ------
        InputError
            If the bag holds nothing of ours, or not what the channel map asks for.

        """
        signals = []
        for topic, stamps, wanted in self._timed():
            inside = (stamps >= low) & (stamps <= high)
            for pick in wanted:
                raw, at = topic.numbers(pick.path)[inside], stamps[inside]
                if topic.type == DIAGNOSTIC_ARRAY:     # the others say nothing about this number
                    at, raw = at[~np.isnan(raw)], raw[~np.isnan(raw)]
                signals.append(Signal(pick.entry.channel, at,
                                      pick.entry.to_si(raw, pick.unit, pick.absolute)))
        return signals

    def _timed(self) -> list[tuple[TopicNumbers, np.ndarray, list[Pick]]]:
        """Return the topics to read, their stamps on one clock (ns), and what to take of each."""
        chosen = []
        for key, (stream, wanted) in all_picks(self._streams, self._map, str(self._path),
                                               self.notes).items():
            topic = self._topics.get(key)
            if topic is None:
                self.notes.append(f'{stream.topic}: no messages')
                continue
            for pick in wanted:
                if pick.entry.source and pick.path not in topic.seen:
                    refuse_beyond(pick, topic, self._map.source)
            wanted = [pick for pick in wanted if pick.entry.channel in self._only
                      and (pick.path in topic.seen or not _may_be_empty(pick))]
            chosen.append((key, wanted))
        if any(key not in self._own_clock for key, _ in chosen):
            found = _own_clock([self._topics[key] for key, _ in chosen], self.notes)
            for (key, _), own in zip(chosen, found):
                self._own_clock.setdefault(key, own)    # what a part of a bag showed holds for all
        return [(self._topics[key], self._topics[key].times(self._own_clock[key]), wanted)
                for key, wanted in chosen]

    @property
    def empty(self) -> bool:
        """Whether no message came yet that may count."""
        return not self._topics

    @property
    def latest(self) -> float:
        """The latest stamp so far (ns); minus infinity before ``signals`` chose the clock."""
        return max((self._topics[key].latest(own) for key, own in self._own_clock.items()),
                   default=-np.inf)

    @property
    def earliest(self) -> float:
        """The earliest stamp that is held (ns)."""
        return min((int(stamps.min()) for key, own in self._own_clock.items()
                    if len(stamps := self._topics[key].times(own))), default=-np.inf)

    def forget(self, before: float) -> None:
        """Forget what has stamps before a time (ns)."""
        late = 0
        for key, own in self._own_clock.items():
            stamps = self._topics[key].times(own)
            late += int(np.count_nonzero(stamps < self._forgotten))
            self._topics[key].keep(stamps >= before)
        self._forgotten = before
        if late:
            self.notes.append(f'{late} messages have stamps long before those of others recorded '
                              'with them; left out; was the clock set back?')


def _own_clock(topics: Sequence[TopicNumbers], notes: list[str]) -> list[bool]:
    """Say whose own stamps are of one clock; the times of publishing serve for the others."""
    stamps = [topic.times(True) if topic.stamped else None for topic in topics]
    published = [topic.times(False) for topic in topics]
    if all(map(_usable, stamps)) and _overlap(stamps):
        return [True] * len(topics)
    own = [_usable(times) and (not len(times) or np.median(np.abs(times - other)) < _APART)
           for times, other in zip(stamps, published)]
    bare = [topic.topic for topic, good in zip(topics, own) if not good]
    if any(_usable(times) and not good for times, good in zip(stamps, own)):
        notes.append('not all stamps are of one clock; the times of publishing are used')
        return [False] * len(topics)
    notes.append(f'{", ".join(bare)}: no stamps; the times of publishing are used')
    return [bool(good) for good in own]


def _may_be_empty(pick: Pick) -> bool:
    """Tell whether a pick is of a sequence that its message may leave empty (JointState)."""
    return not pick.entry.source and '[' in pick.path


def _usable(times: np.ndarray | None) -> bool:
    """Tell whether stamps are filled in: not all zero, and not one and the same all over."""
    return times is not None and (len(times) == 1 or np.count_nonzero(
        np.diff(times)) >= 0.5 * (len(times) - 1))


def _overlap(stamps: Sequence[np.ndarray]) -> bool:
    """Tell whether all the signals share a stretch of time."""
    many = [times for times in stamps if len(times) > 1]
    return not many or max(map(np.min, many)) <= min(map(np.max, many))
