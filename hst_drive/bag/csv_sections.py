# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A CSV recording that is too long for the memory, section by section."""
from __future__ import annotations

import codecs
from itertools import chain, islice
import os
from pathlib import Path
from typing import Iterator, NamedTuple

from hst_drive.bag.align import finish_run, MIN_ROWS
from hst_drive.bag.channels import ChannelMap
from hst_drive.bag.csv_log import layout_of
from hst_drive.errors import InputError
from hst_drive.measure.run import Run
import numpy as np

_LINES = 20_000         # read at a time


class Section(NamedTuple):
    """A part of a recording; what lies in ``start <= time < end`` (s) is its own."""

    run: Run
    start: float
    end: float


def csv_sections(path: str | os.PathLike[str], channel_map: ChannelMap, seconds: float,
                 before: float, after: float) -> Iterator[Section]:
    """
    Yield sections of a CSV recording that overlap.

    Parameters
    ----------
    path, channel_map
        As for ``read_csv``.
    seconds : float
        Length of a section, s; the last one takes a rest of less than half of that.
    before, after : float
        Overlap with the sections before and after, s.

    Raises
    ------
    InputError
        As ``read_csv`` does, once the wrong row is reached.

    """
    notes: list[str] = []
    blocks = _blocks(Path(path), channel_map, notes)
    time, channels = next(blocks, (None, {}))
    if time is None:
        raise InputError(f'{path}: has a header but no rows of data')
    start, ended = float(time[0]), False
    while True:
        end = start + seconds
        while not ended and time[-1] < max(end + after, end + 0.5 * seconds):
            more = next(blocks, None)
            ended = more is None
            if more is not None:
                if more[0][0] <= time[-1]:
                    raise InputError(f'{path}: the time runs back from {time[-1]:.9g} s to '
                                     f'{more[0][0]:.9g} s; expected rising time stamps')
                time = np.concatenate([time, more[0]])
                channels = {name: np.concatenate([channels[name], more[1][name]])
                            for name in channels}
        last = ended and time[-1] < end + 0.5 * seconds
        if last:
            end = np.inf
        rows = slice(*np.searchsorted(time, [start - before, end + after]))
        if rows.stop - rows.start >= MIN_ROWS and np.any((time >= start) & (time < end)):
            yield Section(finish_run(Path(path).stem, time[rows],
                                     {name: values[rows] for name, values in channels.items()},
                                     str(path), notes), start, end)
        if last:
            return
        if rows.stop == rows.start:     # nothing for long: go to where it continues
            end = max(end, start + seconds * ((float(time[rows.stop]) - start) // seconds))
        start = end
        keep = int(np.searchsorted(time, start - before))
        time = time[keep:].copy()
        channels = {name: values[keep:].copy() for name, values in channels.items()}


def _blocks(path: Path, channel_map: ChannelMap, notes: list[str]) -> Iterator[
        tuple[np.ndarray, dict[str, np.ndarray]]]:
    """Yield time and channels of some rows after the other; add to the notes what was left out."""
    try:
        with open(path, encoding=_encoding(path), errors='replace', newline=None) as file:
            numbered = ((number, line) for number, line in enumerate(file, 1)
                        if line.strip() and not line.lstrip().startswith('#'))
            first = list(islice(numbered, 2))
            if not first:
                raise InputError(f'{path}: the file is empty; expected a header and rows of '
                                 'data')
            layout = layout_of([line.rstrip('\n') for _, line in first], channel_map, str(path))
            notes += layout.notes
            layout = layout._replace(notes=notes)
            numbered = chain(first[layout.lines:], numbered)
            start = None
            while block := list(islice(numbered, _LINES)):
                rows, lines = zip(*block)
                lines = layout.whole_rows(lines, rows)
                if not lines:
                    return
                time, channels = layout.read([line.rstrip('\n') for line in lines], rows)
                if start is None:
                    start = time[0] if layout.dated else 0.0
                yield time - start, channels
    except OSError as error:
        raise InputError(f'{path}: cannot be read: {error.strerror}; check the path') from None


def _encoding(path: Path) -> str:
    with open(path, 'rb') as file:
        head = file.read(1 << 16)
    if head[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        return 'utf-16'
    try:
        codecs.getincrementaldecoder('utf-8')().decode(head)
    except UnicodeDecodeError:
        return 'latin-1'
    return 'utf-8-sig'
