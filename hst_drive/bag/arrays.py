# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Tables in memory, pandas frames and mappings of arrays, read as the same table in a file."""
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hst_drive.bag.align import finish_run
from hst_drive.bag.channels import ChannelMap
from hst_drive.bag.csv_log import Layout, picks_of
from hst_drive.bag.stamps import in_seconds, seconds
from hst_drive.errors import InputError
from hst_drive.measure.run import Run
import numpy as np


def is_table(value: object) -> bool:
    """Tell a frame or a mapping of columns from anything else."""
    return isinstance(value, Mapping) or hasattr(value, 'columns')


def read_arrays(table: Any, channel_map: ChannelMap = ChannelMap(), name: str = 'log') -> Run:
    """
    Read a recording that is in memory.

    Parameters
    ----------
    table : frame or mapping
        Columns ``name[unit]``; a named index of a pandas frame is a column as well. Rows count
        from 0 in messages.
    channel_map : ChannelMap
        What is not under our own names.
    name : str
        For tables and messages.

    Raises
    ------
    InputError
        If it cannot be used; names row or column.

    """
    columns = columns_of(table, name)
    header, notes = list(columns), []
    layout = Layout(header, 0, '', picks_of(header, channel_map, name, notes), name, notes)
    wanted = [header[place] for place, _, _ in layout.picks]
    if layout.dated:
        columns[wanted[0]] = _dates(columns[wanted[0]], wanted[0], name)
    values = np.column_stack(numbers(columns, wanted, name))
    time, channels = layout.in_si(values, range(len(values)), whole=True)
    return finish_run(name, time, channels, name, notes)


def columns_of(table: Any, name: str) -> dict[str, Any]:
    """Return the columns of a table by their headers."""
    if hasattr(table, 'columns'):
        index = getattr(table, 'index', None)
        named = getattr(index, 'name', None)
        if named is None and len(table) and getattr(
                getattr(index, 'dtype', None), 'kind', None) in ('m', 'M'):
            table, named = table.rename_axis('time'), 'time'    # dates without a name
        if named is not None and named not in table.columns:
            table = table.reset_index()
        keys = list(table.columns)
    else:
        keys = list(table)
    if not keys:
        raise InputError(f'{name}: has no columns; expected some like motor_speed[rpm]')
    headers = [str(key) for key in keys]
    twice = [header for header in headers if headers.count(header) > 1]
    if twice:
        raise InputError(f'{name}: column {twice[0]!r} comes twice; keep one')
    return {header: table[key] for header, key in zip(headers, keys)}


def numbers(columns: Mapping[str, Any], wanted: list[str], name: str) -> list[np.ndarray]:
    """
    Return columns as floats, NaN where a value is missing.

    Raises
    ------
    InputError
        If one holds no numbers, or not as many as the others.

    """
    found = [_floats(columns[header], f'{name}: column {header!r}') for header in wanted]
    for header, values in zip(wanted, found):
        if len(values) != len(found[0]):
            raise InputError(f'{name}: column {header!r} has {len(values)} values, '
                             f'{wanted[0]!r} has {len(found[0])}; expected as many in each')
    return found


def _dates(values: Any, column: str, name: str) -> np.ndarray:
    if getattr(getattr(values, 'dtype', None), 'tz', None) is not None:     # of pandas
        values = values.dt.tz_convert(None)
    found = np.asarray(values)
    if found.dtype.kind in 'mM':
        return in_seconds(found)
    return seconds([str(value) for value in found.ravel()], range(found.size), name, column)


def _floats(values: Any, where: str) -> np.ndarray:
    kind = np.asarray(values).dtype.kind
    if kind in 'mM':
        raise InputError(f'{where}: holds dates; expected numbers in the unit of the header. A '
                         'time column of dates has no unit: call it time')
    if kind in 'bc':
        raise InputError(f'{where}: holds {"complex" if kind == "c" else "logical"} values; '
                         'expected real numbers in the unit of the header')
    try:
        if hasattr(values, 'to_numpy') and kind == 'O':     # None and NA of pandas
            found = values.to_numpy(dtype=float, na_value=np.nan)
        else:
            found = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f'{where}: holds other things than numbers; expected numbers, NaN where '
                         'a sample is missing') from None
    if found.ndim != 1:
        raise InputError(f'{where}: has {found.ndim} dimensions, expected one')
    return found
