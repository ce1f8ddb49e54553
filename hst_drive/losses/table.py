# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A motor bench table: operating points of one or several motors, checked, with its levels."""
from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from hst_drive.errors import InputError
from hst_drive.units import from_si
import numpy as np

COLUMNS: dict[str, str] = {
    'motor_displacement': 'cc/rev', 'oil_temperature': 'degC', 'load_torque': 'N.m',
    'motor_speed': 'rpm', 'supply_pressure': 'bar', 'supply_flow': 'L/min',
}
DRAIN = 'case_drain_flow'
# The four variables of the paper's figures: attribute of the table, unit, least gap of levels
# (share of the mean; for the size of itself, for the temperature in K), digits for people.
VARIABLES: dict[str, tuple[str, str, float, int]] = {
    'speed': ('speed', 'rpm', 0.015, 0), 'load': ('load_torque', 'N.m', 0.03, 0),
    'temperature': ('temperature', 'degC', 2.0, 0), 'size': ('displacement', 'cc/rev', 0.004, 1),
}
_FIELDS = {'motor_displacement': 'displacement', 'oil_temperature': 'temperature',
           'load_torque': 'load_torque', 'motor_speed': 'speed', 'supply_pressure': 'pressure',
           'supply_flow': 'flow', DRAIN: 'drain'}
# In the unit of the column; wide: they catch slips of the unit, not unusual machines.
_RANGE = {'motor_displacement': (0.05, 5e4), 'oil_temperature': (-60.0, 250.0),
          'load_torque': (0.0, 1e6), 'motor_speed': (0.01, 1e5), 'supply_pressure': (0.1, 2e3),
          'supply_flow': (1e-4, 1e5), DRAIN: (0.0, 1e5)}
# Of torque over its ideal and flow over its own, in the median row; beyond it a unit is another.
_EFFICIENCY = 0.3, 1.03


@dataclass(frozen=True, eq=False)
class Bench:
    """
    Operating points of motors on a bench, SI.

    Attributes
    ----------
    displacement, temperature, load_torque, speed, pressure, flow : ndarray, shape (n,)
        m^3/rad, K, N.m, rad/s, Pa, m^3/s.
    drain : ndarray, shape (n,), or None
        Case drain flow, m^3/s; None where the table has no such column.
    viscosity : ndarray, shape (n,)
        Kinematic viscosity of the oil at the row's temperature, m^2/s.
    lines : ndarray of int
        Line of the file that each row stands on.
    source : str
        File.
    notes : tuple of str
        Rows left out and why.

    """

    displacement: np.ndarray
    temperature: np.ndarray
    load_torque: np.ndarray
    speed: np.ndarray
    pressure: np.ndarray
    flow: np.ndarray
    viscosity: np.ndarray
    lines: np.ndarray
    drain: np.ndarray | None = None
    source: str = 'bench table'
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.speed)

    def rows(self, keep: np.ndarray) -> Bench:
        """Return the table with some of its rows."""
        names = (*_FIELDS.values(), 'viscosity', 'lines')
        return replace(self, **{name: getattr(self, name)[keep] for name in names
                                if getattr(self, name) is not None})

    def of_motor(self, size: float) -> np.ndarray:
        """Return which rows are of the motor with this displacement (m^3/rad)."""
        return np.abs(self.displacement / size - 1.0) < VARIABLES['size'][2]

    def levels(self, variable: str) -> tuple[np.ndarray, np.ndarray]:
        """
        Return the level of each row, and the mean value of each level (SI).

        The columns of a bench scatter about their set points: values closer together than
        what ``VARIABLES`` says are one level. Values without levels are cut into fifths.
        """
        name, _, least, _ = VARIABLES[variable]
        values = getattr(self, name)
        order = np.argsort(values, kind='stable')
        ranked = values[order]
        gap = least * ranked[1:] if variable == 'size' else max(
            least if variable == 'temperature' else least * abs(ranked.mean()),
            0.02 * (ranked[-1] - ranked[0]))
        steps = np.diff(ranked) > gap
        number = np.concatenate([[0], np.cumsum(steps)])
        if variable != 'size' and (
                number[-1] > 24 or max(np.ptp(ranked[number == k]) for k in range(number[-1] + 1))
                > 6.0 * gap):
            count = min(5, max(len(values) // 4, 1))
            number = np.minimum(np.arange(len(values)) * count // len(values), count - 1)
        labels = np.empty(len(values), dtype=int)
        labels[order] = number
        return labels, np.array([values[labels == k].mean() for k in range(labels.max() + 1)])


def bench_of(columns: Mapping[str, np.ndarray], headers: Mapping[str, str], lines: np.ndarray,
             constants: Mapping[str, float], source: str,
             viscosity: Callable[[np.ndarray], np.ndarray]) -> Bench:
    """
    Check the columns of a table and return the bench.

    Parameters
    ----------
    columns : mapping of str to ndarray
        By the names of ``COLUMNS`` and ``DRAIN``, SI; NaN where a cell is empty.
    headers : mapping of str to str
        The file's name for each column.
    lines : ndarray of int
        Line of each row.
    constants : mapping of str to float
        Values for all rows, SI.
    source : str
        File, for messages.
    viscosity : callable
        Kinematic viscosity (m^2/s) at a temperature (K).

    Raises
    ------
    InputError
        One line with file, row and column.

    """
    count = len(lines)
    columns = {**columns, **{name: np.full(count, value) for name, value in constants.items()}}
    for name, unit in COLUMNS.items():
        if name not in columns:
            raise InputError(f'{source}: column {name}[{unit}] is missing; found '
                             f'{", ".join(headers.values())}; add it, name a foreign column in '
                             '--channels MAP.yaml, or give one value for all rows there')
    names = [*COLUMNS, *([DRAIN] if DRAIN in columns else [])]
    notes = []
    for name in names:
        _check(name, columns[name], headers.get(name, name), lines, source)
    keep = np.ones(count, dtype=bool)
    for name in names:
        empty = np.isnan(columns[name])
        if name == DRAIN and empty.all():
            names, notes = names[:-1], [*notes, 'the case drain flow is empty in all rows']
            continue
        if (empty & keep).any():
            notes.append(f'row{_many(lines[empty & keep])}: {headers.get(name, name)} is empty; '
                         'left out')
        keep &= ~empty
    table = np.column_stack([columns[name] for name in names])
    _, first = np.unique(table[keep], axis=0, return_index=True)
    kept = np.flatnonzero(keep)
    again = np.setdiff1d(kept, kept[first])
    if len(again):
        notes.append(f'row{_many(lines[again])}: repeats an earlier row in every column; '
                     'counted once')
        keep[again] = False
    if not keep.any():
        raise InputError(f'{source}: no row has all of {", ".join(COLUMNS)}; found '
                         f'{count} rows with empty cells; fill them')
    found = {_FIELDS[name]: columns[name][keep] for name in names}
    bench = Bench(**found, viscosity=viscosity(found['temperature']), lines=lines[keep],
                  source=source, notes=tuple(notes))
    _check_power(bench)
    return bench


def _many(lines: np.ndarray) -> str:
    shown = ', '.join(map(str, lines[:8])) + (f' and {len(lines) - 8} more' if len(lines) > 8
                                              else '')
    return f' {shown}' if len(lines) == 1 else f's {shown}'


def _check(name: str, values: np.ndarray, header: str, lines: np.ndarray, source: str) -> None:
    unit = COLUMNS.get(name, 'L/min')
    shown = from_si(values, unit)
    low, high = _RANGE[name]
    with np.errstate(invalid='ignore'):
        bad = np.flatnonzero(np.isinf(shown) | (shown < low) | (shown > high))
    if len(bad):
        more = f' (and {len(bad) - 1} rows more)' if len(bad) > 1 else ''
        raise InputError(f'{source}: row {lines[bad[0]]}, column {header!r}: found '
                         f'{shown[bad[0]]:.6g} {unit}{more}, expected {low:g} to {high:g} {unit}; '
                         'check the value and the unit in the header, or empty the cell to leave '
                         'the row out')


def _check_power(bench: Bench) -> None:
    """Refuse a table whose motors give more than they take, or lose most: a unit is another."""
    ratio = bench.load_torque * bench.speed / (bench.pressure * bench.flow)
    middle = float(np.median(ratio))
    torque = np.median(bench.load_torque / (bench.pressure * bench.displacement))
    flow = np.median(bench.displacement * bench.speed / bench.flow)
    low, high = _EFFICIENCY
    if not (middle < high and low < torque < high and low < flow < high):
        raise InputError(
            f'{bench.source}: shaft power is {middle:.3g} times the hydraulic power in the median '
            f'row {bench.lines[np.argsort(ratio)[len(ratio) // 2]]} (torque/(P D) = {torque:.3g}, '
            f'D speed/flow = {flow:.3g}; both expected from {low} to 1); check the units in the '
            'headers')
    drained = 0.0 if bench.drain is None else float(np.nanmedian(bench.drain / bench.flow))
    if drained > 1.0:
        raise InputError(
            f'{bench.source}: the case drain flow is {drained:.3g} times the supply flow in the '
            'median row, expected below 1; check the units in the headers')
