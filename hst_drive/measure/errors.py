# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a model is from a measurement."""
from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np


class Russell(NamedTuple):
    """Russell's magnitude, phase and comprehensive error."""

    magnitude: float
    phase: float
    comprehensive: float

    @property
    def reading(self) -> str:
        """Usual reading: below 0.15 excellent, 0.15 to 0.28 acceptable, above poor."""
        return ('excellent' if self.comprehensive < 0.15
                else 'acceptable' if self.comprehensive <= 0.28 else 'poor')


def russell(model: np.ndarray, measured: np.ndarray) -> Russell:
    """
    Return Russell's errors.

    With A = sum f^2, B = sum g^2, C = sum f*g: relative magnitude m = (A-B)/sqrt(A*B), magnitude
    error M = sign(m)*log10(1+|m|), phase error P = arccos(C/sqrt(A*B))/pi, comprehensive error
    sqrt(pi/4*(M^2+P^2)). It hides small errors on a large mean.

    Parameters
    ----------
    model, measured : ndarray, shape (n,)
        In the same unit.

    Returns
    -------
    Russell
        NaN where one of the signals is zero throughout.

    References
    ----------
    D. M. Russell: Error measures for comparing transient data, Part I. Proceedings of the 68th
    Shock and Vibration Symposium, 1997.

    """
    return russell_of_sums(float(model @ model), float(measured @ measured),
                           float(model @ measured))


def russell_of_sums(a: float, b: float, c: float) -> Russell:
    """Return Russell's errors from A, B and C (``russell``)."""
    if a <= 0 or b <= 0:
        return Russell(math.nan, math.nan, math.nan)
    root = math.sqrt(a) * math.sqrt(b)
    relative = (a - b) / root
    magnitude = math.copysign(math.log10(1 + abs(relative)), relative)
    phase = math.acos(min(max(c / root, -1.0), 1.0)) / math.pi
    return Russell(magnitude, phase, math.sqrt(math.pi / 4 * (magnitude**2 + phase**2)))


class ErrorSummary(NamedTuple):
    """
    Errors of one signal, model minus measurement, SI.

    ``noise_std`` is the sensor's noise, ``floor`` the rmse that a perfect model would still show,
    ``noise_ratio`` the rmse over that floor; ``fit`` is 1 - NRMSE against the measured mean.
    """

    unit: str
    samples: int
    rmse: float
    bias: float
    max_abs: float
    noise_std: float
    floor: float
    noise_ratio: float
    fit: float
    russell: Russell


def summarise(model: np.ndarray, measured: np.ndarray, unit: str, noise: float,
              floor: float) -> ErrorSummary:
    """Compare one signal; samples that are NaN in either are left out."""
    valid = np.isfinite(model) & np.isfinite(measured)
    model, measured = model[valid], measured[valid]
    if not len(model):
        nan = math.nan
        return ErrorSummary(unit, 0, nan, nan, nan, noise, floor, nan, nan, Russell(nan, nan, nan))
    error = model - measured
    rmse = math.sqrt(float(np.mean(error**2)))
    spread = math.sqrt(float(np.mean((measured - measured.mean())**2)))
    moves = spread > 1e-9 * float(np.abs(measured).max())
    return ErrorSummary(
        unit, len(error), rmse, float(error.mean()), float(np.abs(error).max()), noise, floor,
        rmse / floor if floor > 0 else math.inf, 1 - rmse / spread if moves else math.nan,
        russell(model, measured))
