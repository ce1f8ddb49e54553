# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Stamps of the rows of a table: rising, spread where they are rounded, dates in seconds.

Dates are those that loggers write for people: 2026-11-03 12:00:01.25, 03.11.2026 12:00:01,25.
"""
from __future__ import annotations

from collections.abc import Sequence
import re
from typing import Any

from hst_drive.errors import InputError
import numpy as np

DATE = 'date'       # in the place of a unit: the column holds dates
_DAY_FIRST = re.compile(r'(\d\d?)\.(\d\d?)\.(\d{4})')
# Day (or none), hour, the rest, zone (or none).
_STAMP = re.compile(r'(?:(\S+?)[ T]+)?(\d\d?)(:\d\d(?::\d\d(?:\.\d*)?)?)'
                    r'\s*(?:Z|([+-]\d\d):?(\d\d)?)?')
_NONE = np.datetime64('NaT')
_FEW, _FASTER = 10, 0.95    # stamps; rows so much closer than stamps are rounded share stamps


def seconds(cells: Sequence[str], rows: Sequence[int], path: str, column: str) -> np.ndarray:
    """
    Return stamps as seconds since 1970 (of UTC where they name a zone), NaN where there is none.

    Raises
    ------
    InputError
        If a cell of the column holds something else; ``rows`` has its number.

    """
    out = np.empty(len(cells), 'datetime64[ns]')
    for place, cell in enumerate(cells):
        try:
            out[place] = _stamp(cell)
        except ValueError:
            raise _no_date(cell.strip(), rows[place], path, column) from None
    return in_seconds(out)


def in_seconds(stamps: Any) -> np.ndarray:
    """Return an array of dates or of lengths of time in seconds."""
    whole = np.asarray(stamps)
    whole = whole.astype(f'{whole.dtype.kind}8[ns]')
    return np.where(np.isnat(whole), np.nan, whole.astype(np.int64) / 1e9)


def _stamp(text: str) -> np.datetime64:
    text = text.strip().replace(',', '.')
    if not text:
        return _NONE
    found = _STAMP.fullmatch(text)
    if not found:
        raise ValueError(text)
    day, hour, rest, east, minutes = found.groups()
    day = _DAY_FIRST.sub(lambda part: f'{part[3]}-{part[2]:0>2}-{part[1]:0>2}',
                         day or '1970-01-01')
    stamp = np.datetime64(f'{day}T{hour:0>2}{rest}', 'ns')
    if east:
        stamp -= np.timedelta64(60 * int(east) + int(f'{east[0]}{minutes or 0}'), 'm')
    return stamp


def _no_date(cell: str, row: int, path: str, column: str) -> InputError:
    try:
        float(cell)
    except ValueError:
        return InputError(f'{path}: row {row}, column {column!r}: expected a date like 2026-11-03 '
                          f'12:00:01.25, found {cell[:40]!r}')
    return InputError(f'{path}: column {column!r} has no unit; write it as {column}[s], or give '
                      'dates')


def spread(time: np.ndarray, notes: list[str]) -> np.ndarray:
    """Return stamps (s) that rise where several rows have one because stamps are rounded."""
    steps = np.diff(time)
    if not np.isfinite(time).all() or not (steps == 0).any() or (steps < 0).any():
        return time
    first = np.flatnonzero(np.append(True, steps > 0))
    rounding = float(steps[steps > 0].min(initial=np.inf))
    if len(first) < _FEW or time[-1] - time[0] > _FASTER * rounding * len(steps):
        return time     # a clock that stood still
    rows = np.diff(np.append(first, len(time)))
    usual = max(float(np.median(rows)), 1.0)
    notes.append(f'stamps are rounded to {rounding:.3g} s, rows come '
                 f'{len(steps) / (time[-1] - time[0]):.4g} a second: spread evenly')
    since = (np.arange(len(time)) - np.repeat(first, rows)).astype(float)
    # The first and the last stamp may have fewer rows than belong to them.
    since[:rows[0]] += max(usual - rows[0], 0.0)
    rows = np.maximum(rows, np.where(np.isin(first, (first[0], first[-1])), usual, 1.0))
    return time + rounding * since / np.repeat(rows, np.diff(np.append(first, len(time))))


def check_time(time: np.ndarray, rows: Sequence[int], path: str) -> None:
    """Raise InputError, with the row, unless stamps are finite and rise."""
    bad = np.flatnonzero(~np.isfinite(time))
    if len(bad):
        raise InputError(f'{path}: row {rows[bad[0]]}: the time is missing or not finite; '
                         'leave the row out')
    wrong = np.flatnonzero(np.diff(time) <= 0)
    if len(wrong):
        at = wrong[0]
        back = time[at + 1] < time[at]
        what = 'runs back' if back else 'stands still'
        raise InputError(f'{path}: row {rows[at + 1]}: the time {what} ({time[at]:.9g} s, then '
                         f'{time[at + 1]:.9g} s); expected rising time stamps; '
                         + ('cut the log there, or sort its rows by time' if back else
                            'leave out the rows that come twice'))
