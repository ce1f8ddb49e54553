# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Tables of operating points: a CSV row per point, ``name[unit]`` in the header, no time.

A channel map (``--channels MAP.yaml``) names foreign columns as for logs, and may give what the
table leaves out as constants::

    channels:
      supply_pressure: {from: p1, unit: psi}
    constants:
      motor_displacement: 23 cc/rev

"""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
import math
import os
from pathlib import Path
from typing import Any

from hst_drive.bag.arrays import columns_of, numbers
from hst_drive.bag.channels import check_unit, Entry, entry_of, left_out, picked, split_header
from hst_drive.bag.csv_lines import read_lines, separator_of
from hst_drive.bag.csv_log import head_of, parse
from hst_drive.errors import InputError
from hst_drive.rig.yaml_file import read_yaml
from hst_drive.units import si_unit, to_si
import numpy as np

# Quantity -> unit that people write; pressures are gauge.
QUANTITIES: dict[str, str] = {
    'motor_displacement': 'cc/rev', 'oil_temperature': 'degC', 'load_torque': 'N.m',
    'motor_speed': 'rpm', 'supply_pressure': 'bar', 'supply_flow': 'L/min',
    'case_drain_flow': 'L/min', 'pump_speed': 'rpm', 'pump_displacement': 'cc/rev',
    'motor_speed_reverse': 'rpm',
}


@dataclass(frozen=True)
class PointTable:
    """
    A table of operating points.

    Attributes
    ----------
    source : str
        File.
    columns : dict of str to ndarray, shape (n,)
        SI values by the names of ``QUANTITIES``; NaN where a cell is empty.
    headers : dict of str to str
        How the file calls the column, for messages.
    lines : ndarray of int, shape (n,)
        Line of the file that each row stands on.
    constants : dict of str to float
        What the channel map gives for all rows, SI.
    notes : tuple of str
        What the reader should know.

    """

    source: str
    columns: dict[str, np.ndarray]
    headers: dict[str, str]
    lines: np.ndarray
    constants: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def read_points(path: str | os.PathLike[str],
                channels: str | os.PathLike[str] | Mapping | None = None) -> PointTable:
    """
    Read a table of operating points.

    Raises
    ------
    InputError
        If it cannot be used; names file, row and column.

    """
    entries, constants, mapped = _map(channels) if channels else ({}, {}, '')
    lines, rows = read_lines(Path(path))
    separator = separator_of(lines[0])
    header = head_of(lines[0], separator, str(path))
    picks, notes = _picks(header, entries, constants, str(path), mapped)
    if len(lines) == 1:
        raise InputError(f'{path}: has a header but no rows; expected one row per operating point')
    values = parse(lines[1:], rows[1:], separator, header, [column for column, _, _ in picks],
                   str(path))
    return _table_of(str(path), header, picks, values.T, np.array(rows[1:len(values) + 1]),
                     constants, notes)


def points_of(table: Any, channels: str | os.PathLike[str] | Mapping | None = None,
              name: str = 'table') -> PointTable:
    """
    Read a table of operating points that is in memory: a frame, or a mapping of columns.

    Raises
    ------
    InputError
        If it cannot be used; names the column.

    """
    entries, constants, mapped = _map(channels) if channels else ({}, {}, '')
    columns = columns_of(table, name)
    header = list(columns)
    picks, notes = _picks(header, entries, constants, name, mapped)
    values = numbers(columns, [header[column] for column, _, _ in picks], name)
    return _table_of(name, header, picks, values, np.arange(len(values[0])), constants, notes)


def _table_of(source: str, header: list[str], picks: list[tuple[int, Entry, str]],
              values: Iterable[np.ndarray], lines: np.ndarray, constants: dict[str, float],
              notes: list[str]) -> PointTable:
    return PointTable(source, {entry.channel: entry.to_si(column, unit)
                               for (_, entry, unit), column in zip(picks, values)},
                      {entry.channel: header[place] for place, entry, _ in picks},
                      lines, constants, tuple(notes))


def _picks(header: list[str], entries: Mapping[str, Entry], constants: Mapping[str, float],
           path: str, mapped: str) -> tuple[list[tuple[int, Entry, str]], list[str]]:
    """Return column, entry and unit of each quantity, and notes on the columns left out."""
    names = [split_header(cell)[0] for cell in header]
    picks = picked([*entries.values(), *(Entry(name, name) for name in dict.fromkeys(names)
                                         if name in QUANTITIES and name not in entries)],
                   header, path, mapped, QUANTITIES.__getitem__)
    if not picks:
        raise InputError(f'{path}: none of its columns is known: {", ".join(names)}; expected '
                         f'{", ".join(f"{name}[{unit}]" for name, unit in QUANTITIES.items())}; '
                         'name foreign ones in a channel map: --channels MAP.yaml')
    used = {place for place, _, _ in picks}
    notes = [left_out(name, QUANTITIES, 0.75)
             for index, name in enumerate(names) if index not in used]
    both = [entry.channel for _, entry, _ in picks if entry.channel in constants]
    if both:
        raise InputError(f'{mapped}: constants.{both[0]}: {path} has a column for it; give one')
    return picks, notes


def _map(given: str | os.PathLike[str] | Mapping) -> tuple[
        dict[str, Entry], dict[str, float], str]:
    """Read the channel map of a table: entries, constants (SI) and the file's name."""
    data, path = (given, 'channels') if isinstance(given, Mapping) else (read_yaml(given), given)
    for key in data:
        if key not in ('channels', 'constants'):
            raise InputError(f'{path}: unknown key {key!r}; expected channels or constants')
    entries, constants = data.get('channels') or {}, data.get('constants') or {}
    for section, content in (('channels', entries), ('constants', constants)):
        if not isinstance(content, dict):
            raise InputError(f'{path}: {section} is {content!r}, expected a mapping')
        for name in content:
            if name not in QUANTITIES:
                near = get_close_matches(str(name), QUANTITIES, n=1)
                raise InputError(f'{path}: {section}.{name}: no such quantity; '
                                 + (f'did you mean {near[0]!r}?' if near else
                                    f'known: {", ".join(QUANTITIES)}'))
    found = {name: entry_of(name, value, f'{path}: channels.{name}', si_unit(QUANTITIES[name]))
             for name, value in entries.items()}
    return found, {name: _constant(value, f'{path}: constants.{name}', QUANTITIES[name])
                   for name, value in constants.items()}, str(path)


def _constant(value, where: str, unit: str) -> float:
    number, _, given = str(value).strip().partition(' ')
    try:
        si = check_unit(given, si_unit(unit), where)
        found = float(to_si(float(number), si))
        if math.isfinite(found):
            return found
        raise ValueError(number)
    except ValueError:
        raise InputError(f'{where} is {value!r}, expected a number with its unit, as '
                         f"'12 {unit}'") from None
