# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A bag that is too long for the memory, section by section.

Clock, order and time base are decided of the whole bag, as ``read_bag`` does: its numbers go to
files first, and the stamps of one topic at a time come into the memory.
"""
from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
from typing import NamedTuple

from hst_drive.bag.align import align, disorder, MIN_ROWS, Signal
from hst_drive.bag.channels import ChannelMap
from hst_drive.bag.column import Column
from hst_drive.bag.csv_sections import Section
from hst_drive.bag.picks import Pick
from hst_drive.bag.rosbag2 import bag_blocks, bag_files
from hst_drive.bag.signals import BagSignals, signals_of, Timed
from hst_drive.bag.topic_numbers import TopicNumbers
import numpy as np

_SPARSE = 1000
_EARLIER = 20       # messages before a section: a command may have been sent long ago


def bag_size(path: str | os.PathLike[str]) -> int:
    """Return how many bytes the files of a bag have."""
    return sum(file.stat().st_size for file in bag_files(Path(path), []))


def bag_sections(path: str | os.PathLike[str], channel_map: ChannelMap, seconds: float,
                 before: float, after: float) -> Iterator[Section]:
    """
    Yield sections of a bag that overlap.

    Parameters
    ----------
    path, channel_map, seconds, before, after
        As for ``csv_sections``.

    Raises
    ------
    InputError
        As ``read_bag`` does.

    """
    path = Path(path)
    bag = BagSignals(path, channel_map, on_disk=True)
    for streams in bag_blocks(path, bag.wanted, bag.notes):
        bag.take(streams)
    topics = []
    for timed in bag.timed():
        if not timed.wanted:
            continue
        bag.notes += disorder(timed.topic.topic, timed.stamps)
        topics.append(_Sorted.of(timed))
    topics.sort(key=lambda topic: topic.number)
    base = max(topics, key=lambda topic: topic.stamps.count).stamps
    origin, last = base.at(0), base.at(base.count - 1)
    start = 0.0
    while True:
        end = start + seconds
        if last < origin + 1e9 * (end + 0.5 * seconds):
            end = np.inf
        rows = [base.place(origin + 1e9 * edge) for edge in (start, end)]
        low, high = origin + 1e9 * (start - before), origin + 1e9 * (end + after)
        if rows[1] > rows[0] and base.place(high) - base.place(low) >= MIN_ROWS:
            signals = bag.whole([signal for topic in topics
                                 for signal in topic.signals(low, high, bag.notes)])
            if signals:
                yield Section(align(signals, path.stem, str(path), bag.notes, origin), start, end)
        if np.isinf(end):
            return
        if rows[1] == rows[0]:      # nothing for long: go to where it continues
            ahead = (base.at(rows[1]) - origin) / 1e9 - start
            end = max(end, start + seconds * (ahead // seconds))
        start = end


class _Rising:
    """Rising stamps (ns) in a file; of each thousand one stays in memory, to find places by."""

    def __init__(self, stamps: np.ndarray):
        self.count = len(stamps)
        self._some = stamps[::_SPARSE].copy()
        self._column = Column(on_disk=True)
        self._column.append(stamps)

    def at(self, place: int) -> int:
        """Return the stamp at a place."""
        return int(self.part(place, place + 1)[0])

    def part(self, first: int, last: int) -> np.ndarray:
        """Return the stamps from one place to another."""
        return self._column.part(first, last)

    def place(self, stamp: float) -> int:
        """Return the place of the first stamp that is not earlier."""
        start = max(int(np.searchsorted(self._some, stamp)) - 1, 0) * _SPARSE
        return start + int(np.searchsorted(self.part(start, start + _SPARSE), stamp))


class _Sorted(NamedTuple):
    """A topic with rising stamps and the places of its messages; None: as written."""

    number: int
    topic: TopicNumbers
    wanted: list[Pick]
    stamps: _Rising
    places: np.ndarray | None

    @classmethod
    def of(cls, timed: Timed) -> _Sorted:
        """Sort a topic."""
        number, topic, wanted, stamps = timed
        if (np.diff(stamps) >= 0).all():
            return cls(number, topic, wanted, _Rising(stamps), None)
        places = np.argsort(stamps, kind='stable')
        return cls(number, topic, wanted, _Rising(stamps[places]), places)

    def signals(self, low: float, high: float, notes: list[str]) -> list[Signal]:
        """Return what was true between two stamps."""
        first, last = self.stamps.place(low), self.stamps.place(high)
        if last - first < _EARLIER:
            first = max(first - _EARLIER, 0)
        places = np.arange(first, last) if self.places is None else self.places[first:last]
        return signals_of(self.topic, self.wanted, self.stamps.part(first, last),
                          lambda path: self.topic.some_numbers(path, places), notes)
