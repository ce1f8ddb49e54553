# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Where a drive shakes by itself: stick-slip and other limit cycles.

Their phase is nobody's: a model that is right drifts out of step with the machine within
seconds, so that only means over some periods can be compared there.
"""
from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d, label, uniform_filter1d

_SMOOTH = 0.3       # s; means over about a second
_WINDOW = 0.5       # s
_LEAST = 2.0        # s; after a step a drive rings for less
_SHARE = 0.2        # of the mean speed, rms: ripple of pistons stays well below


def shaking(speed: np.ndarray, sample_time: float) -> np.ndarray:
    """
    Say where a speed swings on and on.

    Parameters
    ----------
    speed : ndarray, shape (n,)
        Of the hydromotor, or anything in proportion to it; finite.
    sample_time : float
        s.

    Returns
    -------
    ndarray of bool, shape (n,)

    """
    slow = gaussian_filter1d(speed, _SMOOTH / sample_time)
    power = uniform_filter1d((speed - slow)**2, max(int(_WINDOW / sample_time), 1))
    parts, count = label(np.sqrt(np.maximum(power, 0.0)) > _SHARE * np.abs(slow) + 1e-9)
    lengths = np.bincount(parts, minlength=count + 1) * sample_time
    lengths[0] = 0.0
    return lengths[parts] >= _LEAST


def means_where(errors: np.ndarray, where: np.ndarray, sample_time: float) -> np.ndarray:
    """Return errors with their running means where a drive shakes."""
    return np.where(where, gaussian_filter1d(errors, _SMOOTH / sample_time), errors)
