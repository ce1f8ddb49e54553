# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
CSV recordings: one column per channel, ``name[unit]`` or ``name (unit)`` in the header.

The unit in the header counts; units may have a line of their own below or above the names.
Separators are comma, semicolon (with decimal point or comma) or tab; lines that begin with # and
empty lines do not count; an empty cell is a missing sample. A time column without a unit may hold
dates. In a log that is read as a whole, stamps that are rounded more coarsely than rows come are
spread evenly.
"""
from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from operator import methodcaller
import os
from pathlib import Path
from typing import NamedTuple

from hst_drive.bag.align import finish_run
from hst_drive.bag.channels import (
    channel_of, ChannelMap, check_unit, column_of, differences, Entry, is_unit, left_out, picked,
    split_header)
from hst_drive.bag.csv_lines import cells_of, read_lines, separator_of
from hst_drive.bag.stamps import check_time, DATE, seconds, spread
from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.measure.run import Run
from hst_drive.units import from_si
import numpy as np

_MISSING = ('', 'nan', 'na', 'n/a', 'null', 'none', '-')
_NO_UNIT = ('', '-')
_SHOWN = 300    # characters of a header in a message


class Layout(NamedTuple):
    """What the header of a file says, and in how many ``lines``: which columns, and as what."""

    header: list[str]
    lines: int
    separator: str
    picks: list[tuple[int, Entry, str]]
    path: str
    notes: list[str]

    def read(self, lines: Sequence[str], rows: Sequence[int], whole: bool = False) -> tuple[
            np.ndarray, dict[str, np.ndarray]]:
        """
        Return time (s) and channels (SI) of lines, of which ``rows`` are the numbers.

        Of a ``whole`` log rounded stamps are spread.
        """
        places = [column for column, _, _ in self.picks]
        if not self.dated:
            return self.in_si(parse(lines, rows, self.separator, self.header, places, self.path),
                              rows, whole)
        values = parse(lines, rows, self.separator, self.header, places[1:], self.path)
        dates = [cells[places[0]] for cells in cells_of(lines, rows, self.separator, self.path)]
        time = seconds(dates, rows, self.path, self.header[places[0]])
        return self.in_si(np.column_stack([time, values]), rows, whole)

    def whole_rows(self, lines: Sequence[str], rows: Sequence[int]) -> Sequence[str]:
        """Return lines, the last with its end, without a last row that was not written to it."""
        if not lines or lines[-1].endswith('\n') or (
                lines[-1].count(self.separator) >= len(self.header) - 1):
            return lines
        self.notes.append(f'the last row ({rows[-1]}) is cut off; left out')
        return lines[:-1]

    @property
    def dated(self) -> bool:
        """Whether the time column holds dates."""
        return self.picks[0][2] == DATE

    def in_si(self, columns: np.ndarray, rows: Sequence[int], whole: bool = False) -> tuple[
            np.ndarray, dict[str, np.ndarray]]:
        """Return what ``read`` does from the numbers of the picked columns, (rows, picks)."""
        values = [entry.to_si(columns[:, index], 's' if unit == DATE else unit)
                  for index, (_, entry, unit) in enumerate(self.picks)]
        if whole:
            if self.dated:      # people count from the first row
                values[0] = values[0] - values[0][:1]
            values[0] = spread(values[0], self.notes)
        check_time(values[0], rows, self.path)
        return values[0], differences({
            entry.channel: column for (_, entry, _), column in zip(self.picks[1:], values[1:])})


def layout_of(lines: Sequence[str], channel_map: ChannelMap, path: str) -> Layout:
    """Return what a header says, which the first line or the first two of a file hold."""
    separator = separator_of(lines[0])
    header, second = (head_of(line, separator, path) for line in (*lines, '')[:2])
    count = 1
    if _are_units(header) and not any(map(_is_number, second)):
        header, second = second, header
    if _are_units(second) and not _are_units(header):
        count, second = 2, [*second, *[''] * len(header)]
        header = [f'{name}[{unit}]' if unit not in _NO_UNIT and split_header(name)[1] is None
                  else name for name, unit in zip(header, map(_bare, second))]
    notes: list[str] = []
    picks = picks_of(header, channel_map, path, notes)
    return Layout(header, count, separator, picks, path, notes)


def head_of(line: str, separator: str, path: str) -> list[str]:
    """Return the cells of a line at the top, without empty ones at its end."""
    cells = [cell.strip() for cell in next(cells_of([line], [1], separator, path), [])]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _are_units(cells: Sequence[str]) -> bool:
    named = [cell for cell in map(_bare, cells) if cell not in _NO_UNIT]
    # Of columns that nobody asks for the unit may be one that we do not know.
    return bool(named) and not any(map(_is_number, named)) and (
        sum(map(is_unit, named)) > 0.5 * len(named))


def _bare(cell: str) -> str:
    return cell.strip('[]() ')


def read_csv(path: str | os.PathLike[str], channel_map: ChannelMap = ChannelMap()) -> Run:
    """
    Read a CSV recording.

    Raises
    ------
    InputError
        If it cannot be used; names file and row or column.

    """
    lines, rows = read_lines(Path(path))
    layout = layout_of(lines[:2], channel_map, str(path))
    lines, rows = lines[layout.lines:], rows[layout.lines:]
    lines = layout.whole_rows(lines, rows)
    if not lines:
        raise InputError(f'{path}: has a header but no rows of data; record it again, or leave '
                         'the log out')
    time, channels = layout.read(lines, rows, whole=True)
    return finish_run(Path(path).stem, time, channels, str(path), layout.notes)


def write_csv(path: str | os.PathLike[str], run: Run) -> None:
    """Write a recording in the units of the field: 9 digits (time 15), missing samples empty."""
    units = {name: CHANNELS[name].display for name in run.channels}
    table = np.column_stack([run.time] + [from_si(run[name], unit)
                                          for name, unit in units.items()])
    with open(path, 'w', encoding='utf-8', newline='\n') as file:
        file.write(','.join(['time[s]'] + [f'{name}[{unit}]' for name, unit in units.items()]))
        file.write('\n')
        pattern = ','.join(['%.15g'] + ['%.9g'] * len(units)) + '\n'
        text = ''.join(pattern % tuple(row) for row in table.tolist())
        file.write(text.replace('nan', ''))


def _is_number(text: str) -> bool:
    try:
        float(text.replace(',', '.'))
    except ValueError:
        return False
    return True


def picks_of(header: list[str], channel_map: ChannelMap, path: str,
             notes: list[str]) -> list[tuple[int, Entry, str]]:
    """Return column, entry and unit of the time and of each channel."""
    if all(map(_is_number, header)):
        raise InputError(f'{path}: the first line holds numbers, no header; expected e.g. '
                         'time[s],pump_command[V],motor_speed[rpm]')
    names = [split_header(cell)[0] for cell in header]
    picks = [_time_of(channel_map, header, path), *picked([
        *channel_map.entries.values(),
        *(Entry(name, name) for name in names
          if name in CHANNELS and name not in channel_map.entries)],
        header, path, channel_map.source, lambda name: channel_of(name).display)]
    if len(picks) == 1:
        near = [f'{name} ({match[0]}?)' for name in names
                if (match := get_close_matches(name, CHANNELS, n=1))]
        raise InputError(f'{path}: none of its columns is known: {", ".join(near or names)}; '
                         'name the ones to use in a channel map: --channels MAP.yaml')
    used = {column for column, _, _ in picks}
    for column, name in enumerate(names):
        if column not in used:
            notes.append(left_out(name, CHANNELS, 0.8))
    return picks


def _time_of(channel_map: ChannelMap, header: list[str],
             path: str) -> tuple[int, Entry, str]:
    """Return column, entry and unit of the time; without a unit it holds dates."""
    entry = channel_map.time or Entry('time', 'time')
    if entry.source == 'time' and 'time' not in [split_header(cell)[0] for cell in header]:
        raise InputError(f'{path}: has no column time[s]; its columns are '
                         f'{", ".join(header)[:_SHOWN]}. Rename one, name it under "time" in '
                         'a channel map, or delete the lines above the header')
    column = column_of(entry, header, path, channel_map.source)
    unit = entry.unit or split_header(header[column])[1]
    return column, entry, DATE if unit is None else check_unit(
        unit, 's', f'{path}: column {header[column]!r}')


def parse(lines: Sequence[str], rows: Sequence[int], separator: str, header: list[str],
          columns: list[int], path: str) -> np.ndarray:
    """Return the numbers of the chosen columns, shape (rows, columns)."""
    comma = separator != ',' and any(',' in line for line in lines)
    plain = lines
    if comma:
        plain = [line.replace(',', '.') for line in lines]
    separators = set(map(methodcaller('count', separator), plain))
    if separators == {len(header) - 1}:
        try:
            return np.loadtxt(plain, delimiter=separator, usecols=columns, ndmin=2, comments=None)
        except ValueError:
            pass
    return _parse_slowly(plain, rows, separator, header, columns, path)


def _parse_slowly(lines: Sequence[str], rows: Sequence[int], separator: str, header: list[str],
                  columns: list[int], path: str) -> np.ndarray:
    """Do what ``parse`` does cell by cell: for gaps, quotes, and to say what is wrong."""
    out = np.empty((len(lines), len(columns)))
    for index, cells in enumerate(cells_of(lines, rows, separator, path)):
        while len(cells) > len(header) and not cells[-1].strip():
            cells.pop()
        if len(cells) != len(header):
            raise InputError(f'{path}: row {rows[index]} has {len(cells)} cells, the header '
                             f'{len(header)}; mend the row or leave it out')
        for place, column in enumerate(columns):
            try:
                out[index, place] = float(cells[column])
            except ValueError:
                cell = cells[column].strip()
                if cell.lower() not in _MISSING:
                    raise InputError(f'{path}: row {rows[index]}, column {header[column]!r}: '
                                     f'expected a number, found {cell[:40]!r}; leave a cell '
                                     'without a reading empty') from None
                out[index, place] = np.nan
    return out[:index + 1]
