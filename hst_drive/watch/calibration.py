# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
This unit of the rig, learnt while it drills: tolerances and sensor offsets, block by block.

A unit differs from its datasheet within tolerances; that is no missing physics. Here a linear
Kalman filter of constants learns them from the residuals, beginning with the datasheet's
scatter. What it knows counts up to four sigma: what a unit of this make cannot explain stays in
the residual. (``diagnose`` stops at three; of fifteen unknowns one is beyond three sigma in
every twenty-fifth unit, which is too many for a watch over many drives.)
"""
from __future__ import annotations

import math
from types import MappingProxyType
from typing import Mapping, NamedTuple

from hst_drive.watch.residuals import Residual
import numpy as np

LIMIT = 4.0     # sigma


class Innovation(NamedTuple):
    """A residual beyond what the calibration explains, and its standard deviation, SI."""

    value: float
    deviation: float

    @property
    def score(self) -> float:
        """Value over deviation."""
        return self.value / self.deviation


class Calibration:
    """
    Tolerances and offsets of a unit.

    Parameters
    ----------
    spread : mapping of str to float
        Standard deviation of each before anything is measured.
    correlation : mapping of (str, str) to float
        Of pairs of them, each pair in both orders; what is not in it is not correlated.

    Attributes
    ----------
    mean : ndarray, shape (n,)
        What is known now, in the order of ``names``, without limits.
    covariance : ndarray, shape (n, n)
        How well.

    """

    def __init__(self, spread: Mapping[str, float],
                 correlation: Mapping[tuple[str, str], float] = MappingProxyType({})):
        self.names = tuple(name for name, value in spread.items() if value > 0.0)
        self._index = {name: place for place, name in enumerate(self.names)}
        self.spread = np.array([spread[name] for name in self.names])
        self.mean = np.zeros(len(self.names))
        self._correlation = correlation
        self.covariance = np.outer(self.spread, self.spread) * np.array(
            [[1.0 if one == other else correlation.get((one, other), 0.0)
              for other in self.names] for one in self.names])

    @property
    def beyond(self) -> bool:
        """Whether something has been learnt that no unit explains."""
        return bool(np.any(np.abs(self.mean) > LIMIT * self.spread))

    def fresh(self) -> Calibration:
        """Return what is known before anything is measured."""
        return Calibration(dict(zip(self.names, self.spread)), self._correlation)

    def copy(self) -> Calibration:
        """Return a copy that later blocks do not change."""
        other = object.__new__(Calibration)
        other.__dict__.update(self.__dict__, mean=self.mean.copy(),
                              covariance=self.covariance.copy())
        return other

    @property
    def unit(self) -> np.ndarray:
        """What is known now, as far as a unit may differ."""
        return np.clip(self.mean, -LIMIT * self.spread, LIMIT * self.spread)

    def row(self, residual: Residual) -> np.ndarray:
        """Return how a residual moves with each unknown."""
        row = np.zeros(len(self.names))
        for name, slope in residual.moved_by.items():
            if name in self._index:
                row[self._index[name]] = slope
        return row

    def predict(self, residual: Residual) -> tuple[Innovation, np.ndarray, np.ndarray]:
        """Return what the calibration leaves, the row, and the row's covariance."""
        row = self.row(residual)
        spread = self.covariance @ row
        deviation = math.sqrt(residual.noise**2 + residual.floor**2 + float(row @ spread))
        return Innovation(residual.value - float(row @ self.unit), max(deviation, 1e-30)), \
            row, spread

    def innovation(self, residual: Residual) -> Innovation:
        """Return what the calibration leaves of a residual."""
        return self.predict(residual)[0]

    def learn(self, residual: Residual, scatter: float = 0.0) -> Innovation:
        """Take a residual in, with more variance if need be; return what was left of it before."""
        found, row, spread = self.predict(residual)
        gain = spread / (found.deviation**2 + scatter)
        self.mean = self.mean + gain * (residual.value - float(row @ self.mean))
        self.covariance -= np.outer(gain, spread)
        return found
