# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The numbers of the baseline equations, taken from a rig.

What a unit of the same make may differ in (``rig.tolerances``) is a factor on one of them:
``SCALED`` says which.
"""
from __future__ import annotations

import math

from hst_drive.rig import Curve, Rig
from hst_drive.rig.rig import WHOLE
import numpy as np

NAMES: tuple[str, ...] = (
    'pump_shaft_speed', 'max_displacement', 'displacement_lag', 'displacement_scale',
    'pump_leakage_scale', 'motor_displacement', 'inertia', 'motor_leakage_scale',
    'motor_efficiency_scale', 'pistons', 'bulk_modulus', 'volume', 'oil_density',
    'relief_set_pressure', 'relief_reference_pressure', 'relief_gain', 'gear_ratio',
    'load_displacement', 'load_efficiency_scale', 'pprv_pressure_scale', 'pprv_lag',
    'pprv_override', 'pprv_reference_flow', 'characterised_at',
)
SCALED: dict[str, str] = {
    'motor.displacement': 'motor_displacement', 'motor.inertia': 'inertia',
    'line.bulk_modulus': 'bulk_modulus', 'pump.displacement_vs_command': 'displacement_scale',
    'pump.displacement_lag': 'displacement_lag', 'pump.leakage': 'pump_leakage_scale',
    'motor.leakage': 'motor_leakage_scale',
    'motor.mechanical_efficiency': 'motor_efficiency_scale',
    'loading.pump_mechanical_efficiency': 'load_efficiency_scale',
    'loading.pprv_pressure': 'pprv_pressure_scale', 'loading.pprv_lag': 'pprv_lag',
    'loading.pprv_override': 'pprv_override',
}
TABLES: tuple[str, ...] = ('DISPLACEMENT', 'PUMP_LEAKAGE', 'MOTOR_LEAKAGE', 'MOTOR_EFFICIENCY',
                           'LOAD_EFFICIENCY', 'PPRV_PRESSURE')
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
        'volume': line.volume, 'oil_density': line.oil_density,
        'relief_set_pressure': valve.set_pressure,
        'relief_reference_pressure': valve.reference_pressure,
        # Eq. (2): Cd*A*sqrt(2*dP/rho).
        'relief_gain': valve.discharge_coefficient * valve.area * math.sqrt(2 / line.oil_density),
        'gear_ratio': loading.gear_ratio, 'load_displacement': loading.pump_displacement,
        'load_efficiency_scale': 1.0, 'pprv_pressure_scale': 1.0, 'pprv_lag': loading.pprv_lag,
        'pprv_override': loading.pprv_override,
        'pprv_reference_flow': loading.pprv_reference_flow,
        'characterised_at': rig.characterised_at,
    }
    for key, factor in rig.calibration.items():
        values[SCALED[key]] *= factor
    return np.array([values[name] for name in NAMES])


def baseline_tables(rig: Rig) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the tables in one vector, and where each lies in it.

    Returns
    -------
    values : ndarray
        All abscissae and values, one after another.
    layout : ndarray of int, shape (tables, 5)
        Place and length of the first axis, place and length of the second (place of the values
        and 0 for a table over one variable), place of the values; rows as in ``TABLES``.

    """
    pump, motor, loading = rig.pump, rig.motor, rig.loading
    tables = (pump.displacement, pump.leakage, motor.leakage, motor.mechanical_efficiency,
              loading.pump_mechanical_efficiency, loading.pprv_pressure)
    values, layout, end = [], [], 0
    for table in tables:
        parts = (table.x, table.y) if isinstance(table, Curve) else (table.x, table.y, table.z)
        places = [end]
        for part in parts:
            values.append(np.ravel(part))
            end += part.size
            places.append(end)
        layout.append((places[0], len(table.x), places[1], len(table.y) if len(parts) == 3 else 0,
                       places[len(parts) - 1]))
    return np.concatenate(values).astype(float), np.array(layout, dtype=np.int64)
