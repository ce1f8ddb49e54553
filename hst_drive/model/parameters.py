# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The numbers of the baseline equations, taken from a rig.

What a unit of the same make may differ in (``rig.tolerances``) is a factor on one of them:
``SCALED`` says which.
"""
from __future__ import annotations

import math
from typing import Sequence

from hst_drive.rig import Curve, Rig, Surface
from hst_drive.rig.rig import WHOLE
from hst_drive.rig.schema import LOSSES, WAVES
import numpy as np

NAMES: tuple[str, ...] = (
    'pump_shaft_speed', 'max_displacement', 'displacement_lag', 'displacement_scale',
    'pump_leakage_scale', 'motor_displacement', 'inertia', 'motor_leakage_scale',
    'motor_efficiency_scale', 'pistons', 'bulk_modulus', 'compressibility_under_pressure',
    'volume', 'oil_density', 'relief_set_pressure', 'relief_reference_pressure', 'relief_gain',
    'gear_ratio', 'load_displacement', 'load_efficiency_scale', 'pprv_pressure_scale',
    'pprv_lag', 'pprv_override', 'pprv_reference_flow', 'characterised_at',
    'displacement_between_points', 'pprv_between_points', 'lowest_command', 'command_range',
    'displacement_wave_1', 'displacement_wave_2', 'displacement_wave_3',
    'displacement_series_lag', 'torque_loss', 'efficiency_tilt', 'efficiency_bend',
)
WAVED: dict[str, str] = {key: key.partition('.')[2] for key in WAVES}
# What the pump's actuator has beside a curve and a lag; neutral at 1.
ACTUATOR: dict[str, str] = {**WAVED, 'pump.displacement_series_lag': 'displacement_series_lag'}
# How the hydromotor's torque losses part from its sheet's; neutral at 1.
LOST: dict[str, str] = {key: key.partition('.')[2] for key in LOSSES}
SCALED: dict[str, str] = {
    'motor.displacement': 'motor_displacement', 'motor.inertia': 'inertia',
    'line.bulk_modulus': 'bulk_modulus',
    'line.compressibility_under_pressure': 'compressibility_under_pressure',
    'pump.displacement_vs_command': 'displacement_scale',
    'pump.displacement_lag': 'displacement_lag', 'pump.leakage': 'pump_leakage_scale',
    'motor.leakage': 'motor_leakage_scale',
    'motor.mechanical_efficiency': 'motor_efficiency_scale',
    'gear.efficiency': 'motor_efficiency_scale',
    'loading.pump_mechanical_efficiency': 'load_efficiency_scale',
    'loading.pprv_pressure': 'pprv_pressure_scale', 'loading.pprv_lag': 'pprv_lag',
    'loading.pprv_override': 'pprv_override',
    'pump.displacement_between_points': 'displacement_between_points',
    'loading.pprv_between_points': 'pprv_between_points', **ACTUATOR, **LOST,
}
TABLES: tuple[str, ...] = ('DISPLACEMENT', 'PUMP_LEAKAGE', 'MOTOR_LEAKAGE', 'MOTOR_EFFICIENCY',
                           'LOAD_EFFICIENCY', 'PPRV_PRESSURE', 'DISPLACEMENT_BULGE', 'PPRV_BULGE')
_FINER = 4      # cells of a smooth curve between two points
INDEX: dict[str, int] = {name: index for index, name in enumerate(NAMES)}


def baseline_parameters(rig: Rig) -> np.ndarray:
    """
    Return the numbers of ``NAMES`` for a whole drive, SI, calibration included.

    Raises
    ------
    InputError
        If a section of the rig is missing.

    """
    rig.require(*WHOLE, purpose='a model of the whole drive')
    pump, motor, line, valve, loading = (getattr(rig, name) for name in WHOLE)
    values = {
        'pump_shaft_speed': pump.shaft_speed, 'max_displacement': pump.max_displacement,
        'displacement_lag': pump.displacement_lag, 'displacement_scale': 1.0,
        'pump_leakage_scale': 1.0, 'motor_displacement': motor.displacement,
        'inertia': motor.inertia, 'motor_leakage_scale': 1.0, 'motor_efficiency_scale': 1.0,
        'pistons': float(motor.pistons), 'bulk_modulus': line.bulk_modulus,
        # Of the relief valve's pressure, over that of none.
        'compressibility_under_pressure': 1.0, 'volume': line.volume,
        'oil_density': line.oil_density,
        'relief_set_pressure': valve.set_pressure,
        'relief_reference_pressure': valve.reference_pressure,
        # Eq. (2): Cd*A*sqrt(2*dP/rho).
        'relief_gain': valve.discharge_coefficient * valve.area * math.sqrt(2 / line.oil_density),
        'gear_ratio': loading.gear_ratio, 'load_displacement': loading.pump_displacement,
        'load_efficiency_scale': 1.0, 'pprv_pressure_scale': 1.0, 'pprv_lag': loading.pprv_lag,
        'pprv_override': loading.pprv_override,
        'pprv_reference_flow': loading.pprv_reference_flow,
        'characterised_at': rig.characterised_at, 'displacement_between_points': 1.0,
        'pprv_between_points': 1.0, **actuator_numbers(pump.displacement),
        **dict.fromkeys(LOST.values(), 1.0),
    }
    for key, factor in rig.calibration.items():
        values[SCALED[key]] *= factor
    return np.array([values[name] for name in NAMES])


def baseline_tables(rig: Rig) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the tables, cut into cells in which each is bilinear, and where each begins.

    The kernel keeps the cell in which it looked last, so that it seldom searches, and never
    divides. Cells without end around a table hold its end values.

    Returns
    -------
    cells : ndarray, shape (cells, 8)
        For each cell its bounds (low and high in x, then in y) and a, b, c, d of
        ``a + b*x + (c + d*x)*y``. The cells of a table follow one another, y moving first.
    layout : ndarray of unsigned int, shape (tables, 3)
        Row of the first cell, and how far it is to the next in x and in y; rows as in ``TABLES``.

    """
    pump, motor, loading = rig.pump, rig.motor, rig.loading
    return cells_of((pump.displacement, pump.leakage, motor.leakage, motor.mechanical_efficiency,
                     loading.pump_mechanical_efficiency, loading.pprv_pressure,
                     bulge(pump.displacement), bulge(loading.pprv_pressure)))


def actuator_numbers(curve: Curve) -> dict[str, float]:
    """Return the first command and the length of the pump's curve; neither waves nor a lag."""
    return {'lowest_command': curve.x[0], 'command_range': float(np.ptp(curve.x)) or 1.0,
            **dict.fromkeys(ACTUATOR.values(), 1.0)}


def bulge(curve: Curve) -> Curve:
    """
    Return by how much a smooth curve through the points of one lies above straight lines.

    Cubics whose slope at a point is the harmonic mean of the slopes beside it, so that they swing
    nowhere beyond the points (F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5, 1984).
    """
    step, slope = np.diff(curve.x), np.diff(curve.y) / np.diff(curve.x)
    before, after = slope[:-1], slope[1:]
    same = before * after > 0.0
    inner = np.where(same, 2.0 * before * after / np.where(same, before + after, 1.0), 0.0)
    ends = np.array([slope[0], *inner, slope[-1]])
    at = np.arange(_FINER)[:, None] / _FINER
    above = step * at * (1.0 - at) * (
        (1.0 - at) * (ends[:-1] - slope) - at * (ends[1:] - slope))
    return Curve(np.append((curve.x[:-1] + at * step).T.ravel(), curve.x[-1]),
                 np.append(above.T.ravel(), 0.0))


def cells_of(tables: Sequence[Curve | Surface]) -> tuple[np.ndarray, np.ndarray]:
    """Return tables as ``baseline_tables`` does, rows in their order."""
    cells, layout, end = [], [], 0
    for table in tables:
        found = _cells(table)
        layout.append((end, found.shape[1], 1))
        cells += [*found]
        end += found.shape[0] * found.shape[1]
    # Unsigned: with an index that may be negative the compiled code would look at its sign.
    return (np.concatenate([*cells, np.empty((0, 8))]),
            np.array(layout, dtype=np.uint64).reshape(-1, 3))


def _cells(table: Curve | Surface) -> np.ndarray:
    """Return the cells of a table, shape (in x, in y, 8)."""
    x, y, z = ((table.x, np.zeros(1), table.y[:, None]) if isinstance(table, Curve)
               else (table.x, table.y, table.z))
    found = np.empty((len(x) + 1, len(y) + 1, 8))
    found[..., 0], found[..., 1], x_from, x_step = (part[:, None] for part in _intervals(x))
    found[..., 2], found[..., 3], y_from, y_step = _intervals(y)
    z = np.pad(z, 1, mode='edge')
    corner = z[:-1, :-1]
    b = (z[1:, :-1] - corner) / x_step
    c = (z[:-1, 1:] - corner) / y_step
    d = (z[1:, 1:] - z[1:, :-1] - z[:-1, 1:] + corner) / (x_step * y_step)
    found[..., 4] = corner - b * x_from - (c - d * x_from) * y_from
    found[..., 5] = b - d * y_from
    found[..., 6] = c - d * x_from
    found[..., 7] = d
    return found


def _intervals(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return low and high ends, origins and lengths of what lies between points, and beyond."""
    # The value does not change in an outer cell: any length does.
    return (np.append(-np.inf, points), np.append(points, np.inf), np.append(points[0], points),
            np.concatenate([[1.0], np.diff(points), [1.0]]))
