# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Where a drive shakes by itself: stick-slip and other limit cycles.

The phase of a limit cycle cannot be predicted: a model that is right drifts out of step with the
machine within seconds, so that only means over some periods can be compared there.
"""
from __future__ import annotations

from hst_drive.measure.readings import filled
from hst_drive.measure.run import Run
import numpy as np
from scipy.ndimage import gaussian_filter1d, label, uniform_filter1d

_SMOOTH = 0.3       # s; means over about a second
_WINDOW = 0.5       # s
_LEAST = 2.0        # s; after a step a drive rings for less
_SHARE = 0.2        # of the mean speed, rms: ripple of pistons stays well below


def shaking(run: Run) -> np.ndarray:
    """
    Say where the hydromotor's speed, or its flow, swings on and on.

    Nowhere where neither was recorded.

    Returns
    -------
    ndarray of bool, shape (n,)

    """
    name = next((key for key in ('motor_speed', 'motor_inlet_flow') if key in run), None)
    if name is None or not np.isfinite(run[name]).any():
        return np.zeros(len(run), dtype=bool)
    speed, sample_time = filled(run[name]), run.sample_time
    slow = gaussian_filter1d(speed, _SMOOTH / sample_time)
    power = uniform_filter1d((speed - slow)**2, max(int(_WINDOW / sample_time), 1))
    parts, count = label(np.sqrt(np.maximum(power, 0.0)) > _SHARE * np.abs(slow) + 1e-9)
    lengths = np.bincount(parts, minlength=count + 1) * sample_time
    lengths[0] = 0.0
    return lengths[parts] >= _LEAST


def means_where(errors: np.ndarray, known: np.ndarray, where: np.ndarray,
                sample_time: float) -> np.ndarray:
    """
    Return errors with their running means where a drive shakes.

    Parameters
    ----------
    errors : ndarray, shape (n,)
        Model minus measurement.
    known, where : ndarray of bool, shape (n,)
        Where there is a measurement, and where the drive shakes.
    sample_time : float
        s.

    """
    if not (where.any() and known.any()):
        return errors
    errors = filled(np.where(known, errors, np.nan))
    return np.where(where, gaussian_filter1d(errors, _SMOOTH / sample_time), errors)
