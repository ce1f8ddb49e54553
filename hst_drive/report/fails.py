# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The error over the operating range: over pressure and speed, temperature, commands, torque."""
from __future__ import annotations

import math
from typing import Sequence

from hst_drive.channels import CHANNELS, PRESSURES
from hst_drive.measure.compare import LogComparison
from hst_drive.measure.where import operating_variables, WARMS
from hst_drive.units import difference_from_si, from_si
import numpy as np

_CELLS = 12
_STRIPS = 14
_FEWEST = 20    # samples of a cell that count
_OVER = ('oil_temperature', 'pump_command', 'pprv_command', 'load_torque', 'motor_torque')


def error_maps(logs: Sequence[LogComparison], names: Sequence[str]) -> dict[str, dict]:
    """
    Return, by signal, where its error is large.

    Returns
    -------
    dict
        'map': rms error over the floor on a grid of pressure and speed, or None; 'over': by
        variable, mean and standard deviation of the error in strips. Units of the field.

    """
    variables = [operating_variables(log.run) for log in logs]
    return {name: _signal([(log, entry) for log, entry in zip(logs, variables)
                           if name in log.signals], name) for name in names}


def _signal(pairs: list[tuple[LogComparison, dict]], name: str) -> dict:
    error = np.concatenate([log.model[name] - log.measured(name) for log, _ in pairs])
    error = difference_from_si(error, CHANNELS[name].display)
    floors = [log.signals[name].floor for log, _ in pairs]
    floor = difference_from_si(math.sqrt(sum(value**2 for value in floors) / len(floors)),
                               CHANNELS[name].display)

    def column(variable: str) -> np.ndarray | None:
        if not all(variable in entry for _, entry in pairs):
            return None
        values = np.concatenate([entry[variable] for _, entry in pairs])
        if variable == 'oil_temperature' and np.ptp(values) < WARMS:
            return None
        return from_si(values, CHANNELS[variable].display)

    pressure = next((key for key in PRESSURES[::-1] if column(key) is not None), None)
    speed = column('motor_speed')
    grid = None
    if pressure is not None and speed is not None:
        grid = _map(column(pressure), speed, error, floor)
        grid = grid and {**grid, 'x': pressure, 'y': 'motor_speed'}
    over = {}
    for variable in _OVER:
        values = column(variable) if variable != name else None
        found = None if values is None else _strips(values, error)
        if found:
            over[variable] = found
    return {'floor': floor, 'map': grid, 'over': over}


def _edges(values: np.ndarray, count: int) -> np.ndarray | None:
    """Return edges that span all but the outermost values; None where nothing varies."""
    if not np.isfinite(values).any():
        return None
    low, high = np.nanquantile(values, [0.002, 0.998])
    if high - low <= 1e-3 * max(abs(low), abs(high), 1e-9):
        return None
    return np.linspace(low, high, count + 1)


def _map(x: np.ndarray, y: np.ndarray, error: np.ndarray, floor: float) -> dict | None:
    edges_x, edges_y = _edges(x, _CELLS), _edges(y, _CELLS)
    if edges_x is None or edges_y is None:
        return None
    valid = np.isfinite(x) & np.isfinite(y) & np.isfinite(error)
    bins = (edges_x, edges_y)
    count = np.histogram2d(x[valid], y[valid], bins)[0]
    squares = np.histogram2d(x[valid], y[valid], bins, weights=error[valid]**2)[0]
    ratio = np.sqrt(squares / np.maximum(count, 1)) / max(floor, 1e-300)
    cells = [[float(ratio[i, j]) if count[i, j] >= _FEWEST else None for i in range(_CELLS)]
             for j in range(_CELLS)]
    return {'xEdges': edges_x.tolist(), 'yEdges': edges_y.tolist(), 'cells': cells}


def _strips(values: np.ndarray, error: np.ndarray) -> dict | None:
    edges = _edges(values, _STRIPS)
    if edges is None:
        return None
    valid = np.isfinite(values) & np.isfinite(error)
    values, error = values[valid], error[valid]
    count = np.histogram(values, edges)[0]
    safe = np.maximum(count, 1)
    mean = np.histogram(values, edges, weights=error)[0] / safe
    square = np.histogram(values, edges, weights=error**2)[0] / safe
    spread = np.sqrt(np.maximum(square - mean**2, 0.0))
    kept = np.flatnonzero(count >= _FEWEST)
    if len(kept) < 2:
        return None
    middle = 0.5 * (edges[:-1] + edges[1:])
    return {'x': middle[kept].tolist(), 'mean': mean[kept].tolist(),
            'spread': spread[kept].tolist()}
