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


def russell(a: float, b: float, c: float) -> Russell:
    """
    Return Russell's errors of a model f and a measurement g.

    With A = sum f^2, B = sum g^2, C = sum f*g: relative magnitude m = (A-B)/sqrt(A*B), magnitude
    error M = sign(m)*log10(1+|m|), phase error P = arccos(C/sqrt(A*B))/pi, comprehensive error
    sqrt(pi/4*(M^2+P^2)). It hides small errors on a large mean.

    Parameters
    ----------
    a, b, c : float
        A, B and C, in the square of the signals' unit.

    Returns
    -------
    Russell
        NaN where one of the signals is zero throughout.

    References
    ----------
    D. M. Russell: Error measures for comparing transient data, Part I. Proceedings of the 68th
    Shock and Vibration Symposium, 1997.

    """
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


class Moments:
    """What an ``ErrorSummary`` needs of the samples so far: sums, not samples."""

    def __init__(self):
        self.count = 0
        self.error = self.squared = self.largest = self.largest_reading = 0.0
        self.mean = self.spread = 0.0           # of the measurement: Chan, Golub, LeVeque 1983
        self.sums = np.zeros(3)                 # Russell's A, B, C
        self.noise = self.floor = 0.0           # sums of squares

    def add(self, model: np.ndarray, measured: np.ndarray, noise: float, floor: float) -> None:
        """Add samples (SI; NaN do not count) with the noise and the floor that hold for them."""
        valid = np.isfinite(model) & np.isfinite(measured)
        model, measured = model[valid], measured[valid]
        count = len(model)
        if not count:
            return
        error, mean = model - measured, float(measured.mean())
        self.error += float(error.sum())
        self.squared += float(error @ error)
        self.largest = max(self.largest, float(np.abs(error).max()))
        self.largest_reading = max(self.largest_reading, float(np.abs(measured).max()))
        apart = mean - self.mean
        self.spread += float(np.sum((measured - mean)**2)) + apart**2 * count * self.count / (
            self.count + count)
        self.mean += apart * count / (self.count + count)
        self.sums += [float(model @ model), float(measured @ measured), float(model @ measured)]
        self.noise += count * noise**2
        self.floor += count * floor**2
        self.count += count

    def summary(self, unit: str) -> ErrorSummary:
        """Return the errors of all samples."""
        if not self.count:
            nan = math.nan
            return ErrorSummary(unit, 0, nan, nan, nan, nan, nan, nan, nan, Russell(nan, nan, nan))
        rmse, spread, noise, floor = (math.sqrt(value / self.count) for value in (
            self.squared, self.spread, self.noise, self.floor))
        moves = spread > 1e-9 * self.largest_reading
        return ErrorSummary(
            unit, self.count, rmse, self.error / self.count, self.largest, noise, floor,
            rmse / floor if floor > 0 else math.inf, 1 - rmse / spread if moves else math.nan,
            russell(*self.sums))


def summarise(model: np.ndarray, measured: np.ndarray, unit: str, noise: float,
              floor: float) -> ErrorSummary:
    """Compare one signal; samples that are NaN in either are left out."""
    found = Moments()
    found.add(model, measured, noise, floor)
    return found.summary(unit)
