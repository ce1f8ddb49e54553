# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A bag that is too long for the memory, section by section."""
from __future__ import annotations

import os
from pathlib import Path
from typing import Iterator

from hst_drive.bag.align import align, MIN_ROWS, Signal
from hst_drive.bag.channels import ChannelMap
from hst_drive.bag.csv_sections import Section
from hst_drive.bag.rosbag2 import bag_blocks
from hst_drive.bag.signals import BagSignals
import numpy as np

_LATE = 5.0     # s; messages of one instant are written within less


def bag_sections(path: str | os.PathLike[str], channel_map: ChannelMap, seconds: float,
                 before: float, after: float) -> Iterator[Section]:
    """
    Yield sections of a bag that overlap.

    Parameters
    ----------
    path, channel_map
        As for ``read_bag``.
    seconds : float
        Length of a section, s; the last one takes a rest of less than half of that.
    before, after : float
        Overlap with the sections before and after, s.

    Raises
    ------
    InputError
        As ``read_bag`` does, once the wrong message is reached.

    """
    path = Path(path)
    bag = BagSignals(path, channel_map)
    blocks = bag_blocks(path, bag.wanted, bag.notes)
    while bag.empty and (block := next(blocks, None)) is not None:
        bag.take(block)
    origin = _first(bag.signals())

    def reached() -> float:
        return (bag.latest - origin) / 1e9

    start, ended = 0.0, False
    while True:
        end = start + seconds
        while not ended and reached() < max(end + after, end + 0.5 * seconds) + _LATE:
            block = next(blocks, None)
            ended = block is None
            if block is not None:
                bag.take(block)
        bag.forget(origin + 1e9 * (start - before))
        last = ended and reached() < end + 0.5 * seconds
        if last:
            end = np.inf
        signals = bag.signals(origin + 1e9 * (start - before), origin + 1e9 * (end + after))
        base = max(signals, key=lambda signal: len(signal.stamps)).stamps
        time = (base - origin) / 1e9
        if len(base) >= MIN_ROWS and np.any((time >= start) & (time < end)):
            notes = dict.fromkeys(bag.notes)
            yield Section(align(signals, path.stem, str(path), list(notes), origin), start, end)
        if last:
            return
        if not len(base):   # nothing for long: go to where it continues
            ahead = (bag.earliest - origin) / 1e9 - start
            end = max(end, start + seconds * (ahead // seconds))
        start = end


def _first(signals: list[Signal]) -> int:
    """Return the stamp at which the densest signal begins (ns)."""
    return int(min(max(signals, key=lambda signal: len(signal.stamps)).stamps))
