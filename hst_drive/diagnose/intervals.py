# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How sure the fitted sizes are: 95 % intervals that know that errors are correlated.

The sandwich estimator over blocks (H. White, Econometrica 50, 1982; blocks of two seconds as
clusters) replaces the naive covariance, which takes every sample as independent and is far too
narrow. A share of the effect's own size is added for its functional form, and what the unit's
tables do between their points to what its tolerances leave open.
"""
from __future__ import annotations

from hst_drive.diagnose.campaign import Campaign
from hst_drive.diagnose.fit import Fit
from hst_drive.diagnose.unknowns import Unknowns
import numpy as np
from scipy.stats import norm

# Of the squared tolerance: a datasheet's tables say nothing of what lies between their points.
_BETWEEN_POINTS = 1.0
_FORM = 0.04    # relative standard deviation: no machine follows one formula exactly


def intervals(campaign: Campaign, fitted: Fit,
              level: float = 0.95) -> dict[tuple[str, str], tuple[float, float]]:
    """
    Return low and high of each unknown, SI, by (effect, parameter); effect '' for the unit.

    Factors of the unit are natural logarithms. Bounds of the parameters are kept.
    """
    unknowns = Unknowns(campaign, fitted.model)
    unknowns = Unknowns(campaign, fitted.model, {*unknowns.names} - {*fitted.names})
    jacobian = fitted.jacobian
    residual = campaign.training(fitted.errors)
    count = jacobian.shape[1]
    normal = jacobian.T @ jacobian
    normal[np.arange(unknowns.factors), np.arange(unknowns.factors)] += 1.0
    inverse = np.linalg.pinv(normal)
    meat = np.zeros((count, count))
    for rows in _clusters(campaign):
        push = jacobian[rows].T @ residual[rows]
        meat += np.outer(push, push)
    meat[np.arange(unknowns.factors), np.arange(unknowns.factors)] += 1.0 + _BETWEEN_POINTS
    deviation = np.sqrt(np.maximum(np.diag(inverse @ meat @ inverse), 0.0))
    vector = unknowns.pack(fitted.model)
    deviation = np.hypot(deviation, _FORM * np.abs(vector) * (
        np.arange(count) >= unknowns.factors))
    # What moves nothing is not known at all.
    deviation[~jacobian.any(axis=0)] = np.inf
    width = norm.ppf(0.5 + level / 2) * deviation
    # At a bound to the last digit: who reads it compares them.
    low = np.where(vector - width > unknowns.low, (vector - width) * unknowns.scale,
                   unknowns.bounds[:, 0])
    high = np.where(vector + width < unknowns.high, (vector + width) * unknowns.scale,
                    unknowns.bounds[:, 1])
    return {name: (float(a), float(b)) for name, a, b in zip(unknowns.names, low, high)}


def _clusters(campaign: Campaign) -> list[np.ndarray]:
    """Return the rows of the training vector that belong to one block of one log."""
    clusters: dict[tuple[int, int], list[np.ndarray]] = {}
    start = 0
    for column in campaign.columns:
        time = campaign.replays[column.log].run.time
        numbers = ((time[column.fit] - time[0]) / campaign.block).astype(int)
        if len(numbers):
            edges = np.flatnonzero(np.diff(numbers)) + 1
            for part in np.split(np.arange(len(numbers)), edges):
                clusters.setdefault((column.log, int(numbers[part[0]])), []).append(part + start)
        start += len(column.fit)
    return [np.concatenate(parts) for parts in clusters.values()]
