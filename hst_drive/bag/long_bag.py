# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A bag that is too long for the memory, section by section.

Clock, order and time base are decided of the whole bag, as ``read_bag`` does: its numbers go to
files first, and only the stamps stay in memory.
"""
from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
from typing import NamedTuple

from hst_drive.bag.align import align, disorder, MIN_ROWS, Signal
from hst_drive.bag.channels import ChannelMap
from hst_drive.bag.csv_sections import Section
from hst_drive.bag.picks import Pick
from hst_drive.bag.rosbag2 import bag_blocks, bag_files
from hst_drive.bag.signals import BagSignals, signals_of
from hst_drive.bag.topic_numbers import TopicNumbers
import numpy as np

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
    for topic, wanted, stamps in bag.timed():
        bag.notes += disorder(topic.topic, stamps)
        topics.append(_Sorted.of(topic, wanted, stamps))
    base = max(topics, key=lambda topic: len(topic.stamps)).stamps
    origin, last = int(base[0]), int(base[-1])
    start = 0.0
    while True:
        end = start + seconds
        if last < origin + 1e9 * (end + 0.5 * seconds):
            end = np.inf
        rows = np.searchsorted(base, [origin + 1e9 * edge for edge in (start, end)])
        low, high = origin + 1e9 * (start - before), origin + 1e9 * (end + after)
        if rows[1] > rows[0] and np.subtract(*np.searchsorted(base, [high, low])) >= MIN_ROWS:
            signals = [signal for topic in topics
                       for signal in topic.signals(low, high, bag.notes)]
            if signals:
                yield Section(align(signals, path.stem, str(path), bag.notes, origin), start, end)
        if np.isinf(end):
            return
        if rows[1] == rows[0]:      # nothing for long: go to where it continues
            ahead = (int(base[rows[1]]) - origin) / 1e9 - start
            end = max(end, start + seconds * (ahead // seconds))
        start = end


class _Sorted(NamedTuple):
    """A topic with rising stamps (ns) and the places of its messages; None: as written."""

    topic: TopicNumbers
    wanted: list[Pick]
    stamps: np.ndarray
    places: np.ndarray | None

    @classmethod
    def of(cls, topic: TopicNumbers, wanted: list[Pick], stamps: np.ndarray) -> _Sorted:
        """Sort a topic."""
        if (np.diff(stamps) >= 0).all():
            return cls(topic, wanted, stamps, None)
        places = np.argsort(stamps, kind='stable')
        return cls(topic, wanted, stamps[places], places)

    def signals(self, low: float, high: float, notes: list[str]) -> list[Signal]:
        """Return what was true between two stamps."""
        first, last = np.searchsorted(self.stamps, [low, high])
        if last - first < _EARLIER:
            first = max(first - _EARLIER, 0)
        rows = np.arange(first, last)
        places = rows if self.places is None else self.places[rows]
        return signals_of(self.topic, self.wanted, self.stamps[rows],
                          lambda path: self.topic.some_numbers(path, places), notes)
