# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Real drilling torque: a table over depth or time becomes a torque profile for the rig.

Columns are ``name[unit]`` (``depth[ft],torque[klbf.ft],rpm[rpm],rop[ft/h]``); foreign headers are
named through ``columns``.
"""
from __future__ import annotations

from collections.abc import Mapping
import csv
from dataclasses import dataclass
from difflib import get_close_matches
import io
import math

from hst_drive.errors import InputError
from hst_drive.load.profiles import Points
from hst_drive.units import canonical, parse_header, si_unit, to_si, UnitError
import numpy as np

# Our columns: SI units that fit, and other names that a header may use.
COLUMNS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    'time': (('s',), ('t',)),
    'depth': (('m',), ('md', 'measured_depth', 'hole_depth')),
    'torque': (('N.m', '1'), ('tq',)),
    'speed': (('rad/s',), ('rpm', 'rotary_speed')),
    'penetration_rate': (('m/s',), ('rop',)),
}


@dataclass(frozen=True)
class DrillingLog:
    """
    A drilling record.

    Attributes
    ----------
    columns : dict of str to ndarray, shape (n,)
        By the names of ``COLUMNS``, SI, NaN where a value is missing. Torque in percent has the
        unit 1.
    torque_unit : str
        'N.m', or '1' for a record that has the shape only.
    source : str
        File.

    """

    columns: dict[str, np.ndarray]
    torque_unit: str
    source: str


def parse_drilling_log(text: str, source: str,
                       columns: Mapping[str, tuple[str, str]] | None = None) -> DrillingLog:
    """
    Read the text of a CSV file.

    Parameters
    ----------
    text : str
        The file's content.
    source : str
        Its name, for messages.
    columns : mapping, optional
        Our name to (header, unit), for headers without unit or with foreign names.

    Raises
    ------
    InputError
        Naming file, row and column.

    """
    try:
        header, *rows = list(csv.reader(io.StringIO('\n'.join(text.splitlines())))) or [[]]
    except csv.Error as error:
        raise InputError(f'{source}: cannot be read ({error}); expected a CSV') from None
    header = [cell.strip() for cell in header]
    if not any(header):
        raise InputError(f'{source}: is empty; expected a header and rows of a drilling log')
    places = _places(header, columns or {}, source)
    if 'torque' not in places or not ('time' in places or 'depth' in places):
        lacking = 'torque' if 'torque' not in places else 'time or depth'
        raise InputError(
            f'{source}: no column for {lacking}; write it as e.g. torque[N.m], depth[m], or name '
            f'the header under columns: (found {", ".join(header[:12])})')
    cells: dict[str, list[float]] = {name: [] for name in places}
    for number, row in enumerate(rows, start=2):
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(header):
            raise InputError(f'{source}: row {number} has {len(row)} cells, the header '
                             f'{len(header)}; mend or remove the row')
        for name, (index, _) in places.items():
            cells[name].append(_number(row[index], source, number, header[index]))
    found = {name: to_si(np.array(cells[name]), unit) for name, (_, unit) in places.items()}
    if np.isfinite(found['torque']).sum() < 2:
        raise InputError(f'{source}: fewer than 2 rows have a torque; nothing to drill')
    return DrillingLog(found, si_unit(places['torque'][1]), source)


def _number(cell: str, source: str, row: int, column: str) -> float:
    cell = cell.strip()
    if not cell:
        return math.nan
    try:
        value = float(cell)
    except ValueError:
        raise InputError(f"{source}: row {row}, column '{column}': found '{cell}', expected a "
                         'number or nothing') from None
    # Mud logs mark missing values with -999.25 and its kind.
    return value if math.isfinite(value) and not -10000 < value < -990 else math.nan


def _places(header: list[str], columns: Mapping[str, tuple[str, str]],
            source: str) -> dict[str, tuple[int, str]]:
    """Return index and unit of each of our columns that is there."""
    places: dict[str, tuple[int, str]] = {}
    for name, (wanted, unit) in columns.items():
        if wanted not in header:
            near = get_close_matches(wanted, header, n=1)
            hint = f"did you mean '{near[0]}'?" if near else f'found {", ".join(header[:12])}'
            raise InputError(f"{source}: no column '{wanted}' (columns.{name}); {hint}")
        places[name] = header.index(wanted), _unit(unit, name, source)
    for index, cell in enumerate(header):
        try:
            title, unit = parse_header(cell)
        except UnitError:
            continue  # a column without a unit is none of ours; those we need are missed above
        folded = title.lower().replace(' ', '_')
        for name, (_, others) in COLUMNS.items():
            if folded in (name, *others) and name not in places:
                places[name] = index, _unit(unit, name, source)
    return places


def _unit(unit: str, name: str, source: str) -> str:
    try:
        unit = canonical(unit)
    except UnitError as error:
        raise InputError(f"{source}: column '{name}': {error}") from None
    if si_unit(unit) not in COLUMNS[name][0]:
        raise InputError(f"{source}: column '{name}' has the unit [{unit}], expected one of the "
                         f'dimension [{COLUMNS[name][0][0]}]')
    return unit


@dataclass(frozen=True)
class Use:
    """
    How a log becomes the load of a run.

    Attributes
    ----------
    factor : float or None
        Rig torque over logged torque.
    torque_range : (float, float) or None
        Instead: the 1st and 99th percentile of the log map onto these, N.m, the rest is clipped.
    time_per_row : float or None
        s; None: the log's own time, or depth over penetration rate.
    speed_up : float
        How much faster than the log's own time.
    window : (float, float) or None
        Part to use: m of depth or s of time, as ``axis`` says.
    axis : str
        'depth' or 'time'.
    start : float
        Time of the first row, s; before, its torque.

    """

    factor: float | None = None
    torque_range: tuple[float, float] | None = None
    time_per_row: float | None = None
    speed_up: float = 1.0
    window: tuple[float, float] | None = None
    axis: str = 'depth'
    start: float = 0.0


def to_profile(log: DrillingLog, use: Use) -> tuple[Points, tuple[str, ...]]:
    """
    Return the torque at the hydromotor shaft over time, N.m, and what was done to the data.

    Raises
    ------
    InputError
        If the log lacks what ``use`` needs.

    """
    notes: list[str] = []
    columns = _window(log, use, notes)
    torque = columns['torque']
    missing = int(np.isnan(torque).sum())
    if missing:
        gap = int(np.diff(np.flatnonzero(np.isfinite(torque))).max()) - 1
        notes.append(f'{missing} of {len(torque)} rows without torque, the longest gap '
                     f'{gap} rows, bridged by straight lines')
        torque = _bridge(torque)
    time, keep = _clock(log, columns, use, notes)
    return Points((use.start + time).tolist(), _scale(log, torque[keep], use, notes).tolist()), \
        tuple(notes)


def _window(log: DrillingLog, use: Use, notes: list[str]) -> dict[str, np.ndarray]:
    """Return the rows between the first and last torque, inside the wanted window."""
    keep = np.isfinite(log.columns['torque'])
    if use.window is not None:
        if use.axis not in log.columns:
            raise InputError(f'{log.source}: has no {use.axis}, so no range of it can be used; '
                             f"it has {', '.join(log.columns)}")
        place = np.abs(log.columns[use.axis])
        keep &= (place >= use.window[0]) & (place <= use.window[1])
        if keep.sum() < 2:
            raise InputError(
                f'{log.source}: fewer than 2 rows with torque between {use.window[0]:g} and '
                f'{use.window[1]:g} ({use.axis}, SI); the log runs from {np.nanmin(place):g} to '
                f'{np.nanmax(place):g}')
    first, last = np.flatnonzero(keep)[[0, -1]]
    left_out = len(keep) - (last - first + 1)
    if left_out:
        notes.append(f'rows {first + 2} to {last + 2} used, {left_out} others left out')
    return {name: values[first:last + 1] for name, values in log.columns.items()}


def _clock(log: DrillingLog, columns: dict[str, np.ndarray], use: Use,
           notes: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return seconds from the first row, strictly rising, and the rows they belong to."""
    count = len(columns['torque'])
    if use.time_per_row is not None:
        return np.arange(count) * use.time_per_row, np.arange(count)
    if 'time' in columns:
        clock = _bridge(columns['time'])
        fall = np.flatnonzero(np.diff(clock) < 0)
        if len(fall):
            raise InputError(f'{log.source}: time runs back {len(fall)} times, first from '
                             f'{clock[fall[0]]:g} to {clock[fall[0] + 1]:g} s; sort the rows or '
                             'state time_per_row_s')
    elif 'penetration_rate' in columns:
        rate = columns['penetration_rate']
        bad = ~(rate > 0.0)
        if bad.all():
            raise InputError(f'{log.source}: no row has a penetration rate above 0; state '
                             'time_per_row_s')
        if bad.any():
            notes.append(f'{int(bad.sum())} rows without a penetration rate bridged')
        rate = _bridge(np.where(bad, np.nan, rate))
        depth = np.maximum.accumulate(np.abs(_bridge(columns['depth'])))
        middle = 0.5 * (rate[1:] + rate[:-1])
        clock = np.concatenate(([0.0], np.cumsum(np.diff(depth) / middle)))
    else:
        raise InputError(f'{log.source}: neither time nor penetration rate; state '
                         'time_per_row_s')
    clock = (clock - clock[0]) / use.speed_up
    keep = np.flatnonzero(np.concatenate(([True], np.diff(clock) > 0.0)))
    if len(keep) < 2:
        raise InputError(f'{log.source}: all rows are at one time or depth, or have none; state '
                         'time_per_row_s')
    if len(keep) < count:
        notes.append(f'{count - len(keep)} rows at the same time as the row before left out')
    return clock[keep], keep


def _scale(log: DrillingLog, torque: np.ndarray, use: Use, notes: list[str]) -> np.ndarray:
    if use.torque_range is not None:
        low, high = np.percentile(torque, [1.0, 99.0])
        if not high > low:
            raise InputError(f'{log.source}: the torque does not vary, so it cannot be spread '
                             'over a range; state a factor')
        a, b = use.torque_range
        unit = 'N.m' if log.torque_unit == 'N.m' else 'of full scale'
        notes.append(f'torque {low:.4g} to {high:.4g} {unit} (1st and 99th percentile) mapped '
                     f'to {a:g} to {b:g} N.m on this rig, clipped outside')
        return np.clip(a + (torque - low) * (b - a) / (high - low), min(a, b), max(a, b))
    if log.torque_unit != 'N.m':
        raise InputError(f'{log.source}: the torque is in percent, so a factor has no meaning; '
                         'state torque_range_N_m')
    notes.append(f'torque times {use.factor:g} on this rig')
    return torque * use.factor


def _bridge(values: np.ndarray) -> np.ndarray:
    """Return values with NaN replaced by straight lines, end values held."""
    good = np.isfinite(values)
    if not good.any():
        return np.zeros_like(values)
    places = np.arange(len(values))
    return np.interp(places, places[good], values[good])
