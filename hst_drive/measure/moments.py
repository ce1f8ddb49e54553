# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Errors of a signal, collected section by section: sums instead of samples."""
from __future__ import annotations

import math

from hst_drive.measure.errors import ErrorSummary, Russell, russell_of_sums
import numpy as np


class Moments:
    """What an ``ErrorSummary`` needs of the samples so far."""

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
            russell_of_sums(*self.sums))
