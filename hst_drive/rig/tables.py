# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Tables over one variable and over two."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Curve:
    """
    A table over one variable, linear between its points, end values held outside.

    Attributes
    ----------
    x, y : ndarray, shape (n,)
        Strictly rising abscissa and values, SI.

    """

    x: np.ndarray
    y: np.ndarray

    def __call__(self, x):
        return np.interp(x, self.x, self.y)


@dataclass(frozen=True, eq=False)
class Surface:
    """
    A table over two variables, bilinear between its points, end values held outside.

    Attributes
    ----------
    x, y : ndarray, shape (n,) and (m,)
        Strictly rising abscissae, SI.
    z : ndarray, shape (n, m)
        Values, SI.

    """

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray

    def __call__(self, x, y):
        i, s = _cell(self.x, x)
        j, t = _cell(self.y, y)
        z = self.z
        return ((1 - s) * ((1 - t) * z[i, j] + t * z[i, j + 1])
                + s * ((1 - t) * z[i + 1, j] + t * z[i + 1, j + 1]))


def _cell(grid: np.ndarray, value) -> tuple[np.ndarray, np.ndarray]:
    """Return the index of the cell and the place inside it, 0 to 1."""
    # np.clip takes as long as the rest of a look-up of one value.
    value = np.minimum(np.maximum(value, grid[0]), grid[-1])
    index = np.searchsorted(grid[1:-1], value, side='right')
    return index, (value - grid[index]) / (grid[index + 1] - grid[index])


def nothing() -> Surface:
    """Return a table that is zero everywhere."""
    return Surface(np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.zeros((2, 2)))


def ideal() -> Surface:
    """Return a table that is one everywhere."""
    return Surface(np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.ones((2, 2)))
