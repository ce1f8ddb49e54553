# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Smooth curves and maps through the points of the datasheet, on even grids for quick look-up."""
import numpy as np
from scipy.interpolate import PchipInterpolator

#: How much of a curve is the smooth one (monotone cubic); the rest is straight lines between the
#: points, as the datasheet has them. A machine follows neither exactly.
SMOOTH = 0.35


def _between(x: np.ndarray, y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Interpolate along the first axis; the end values hold outside."""
    at = np.clip(at, x[0], x[-1])
    y = np.asarray(y, float)
    flat = y.reshape(len(x), -1)
    straight = np.stack([np.interp(at, x, column) for column in flat.T], -1)
    smooth = PchipInterpolator(x, flat)(at)
    return (SMOOTH * smooth + (1 - SMOOTH) * straight).reshape(len(at), *y.shape[1:])


def curve(x: list, y: list, top: float, count: int = 2001) -> np.ndarray:
    """Return y on an even grid from 0 to top."""
    return _between(np.asarray(x, float), y, np.linspace(0.0, top, count))


def chart(x: list, across: list, table: list, top: float, top_across: float) -> np.ndarray:
    """Return a table on an even grid from 0 to top (801 rows) and 0 to top_across (41 columns)."""
    rows = _between(np.asarray(x, float), table, np.linspace(0.0, top, 801))
    columns = _between(np.asarray(across, float), rows.T, np.linspace(0.0, top_across, 41))
    return np.ascontiguousarray(columns.T)


def tilted(values: np.ndarray, factor: float, tilt: float) -> np.ndarray:
    """Multiply by a factor that goes from factor - tilt at the first row to + tilt at the last."""
    along = factor + tilt * np.linspace(-1.0, 1.0, len(values))
    return values * along.reshape(-1, *[1] * (values.ndim - 1))


def walther(temperature: np.ndarray | float) -> np.ndarray | float:
    """Kinematic viscosity [mm2/s] of ISO VG 46 with 6.8 mm2/s at 100 degC (ASTM D341)."""
    double_log = np.log10(np.log10(np.array([46.0, 6.8]) + 0.7))
    log_t = np.log10(np.array([313.15, 373.15]))
    slope = (double_log[0] - double_log[1]) / (log_t[0] - log_t[1])
    at = double_log[0] + slope * (np.log10(np.asarray(temperature) + 273.15) - log_t[0])
    return 10 ** 10 ** at - 0.7
