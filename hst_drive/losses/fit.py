# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Weighted, robust least squares for formulas of a few parameters.

Gauss-Newton with damping, bounds by projection, Gaussian priors (so that a parameter which the
table does not determine stays at its usual value) and Tukey's weights against outlying rows.
"""
from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

_TUKEY = 6.0        # standard deviations beyond which a row does not count at all


class Parameter(NamedTuple):
    """A parameter of a formula: start, bounds and prior (mean is the start; sd may be inf)."""

    name: str
    start: float
    low: float = -np.inf
    high: float = np.inf
    prior: float = np.inf


class Fit(NamedTuple):
    """
    Result: parameters, their covariance, weighted residuals, row weights (0 to 1).

    ``covariance`` is scaled by the residuals where these exceed the stated noise.
    """

    values: np.ndarray
    covariance: np.ndarray
    residuals: np.ndarray
    weights: np.ndarray


Formula = Callable[[np.ndarray, object], np.ndarray]


def solve(formula: Formula, parameters: list[Parameter], x, y: np.ndarray, sd: np.ndarray,
          start: np.ndarray | None = None, weights: np.ndarray | None = None,
          steps: int = 25) -> Fit:
    """
    Fit ``y = formula(values, x)`` with standard deviations ``sd``.

    Parameters
    ----------
    formula : callable
        Takes parameter vector and ``x``, returns an array like ``y``.
    parameters : list of Parameter
        Starts, bounds, priors.
    x : object
        Passed on.
    y, sd : ndarray, shape (n,)
        Values and their standard deviations.
    start : ndarray, optional
        Instead of the parameters' own.
    weights : ndarray, optional
        Weights of the rows, held; without them they are found (Tukey).
    steps : int
        Most iterations.

    """
    low = np.array([entry.low for entry in parameters])
    high = np.array([entry.high for entry in parameters])
    middle = np.array([entry.start for entry in parameters])
    stiff = np.array([1.0 / entry.prior for entry in parameters])
    values = np.clip(middle if start is None else start, low, high)
    held = weights is not None
    weight = weights if held else np.ones(len(y))

    def residuals(trial: np.ndarray) -> np.ndarray:
        with np.errstate(over='ignore', invalid='ignore'):
            return np.clip(np.nan_to_num((y - formula(trial, x)) / sd, nan=1e8), -1e8, 1e8)

    def cost(found: np.ndarray, trial: np.ndarray) -> float:
        return float(weight @ found**2 + np.sum(((trial - middle) * stiff)**2))

    damping = 1e-3
    found = residuals(values)
    settled = 0
    for step in range(steps):
        if not held and step > 1:
            weight = _tukey(found)
        now = cost(found, values)
        slope = _slopes(formula, values, x, sd)
        normal = slope.T @ (weight[:, None] * slope) + np.diag(stiff**2)
        push = slope.T @ (weight * found) - stiff**2 * (values - middle)
        # What stands at a bound and is pushed beyond it stays there.
        free = ~(((values <= low) & (push < 0)) | ((values >= high) & (push > 0)))
        moved = False
        for _ in range(8):
            trial = values.copy()
            block = normal[np.ix_(free, free)]
            trial[free] += _solve(block + damping * np.diag(np.diag(block) + 1e-12), push[free])
            trial = np.clip(trial, low, high)
            after = residuals(trial)
            if cost(after, trial) <= now:
                moved = True
                break
            damping *= 8.0
        if not moved:
            break
        change = now - cost(after, trial)
        values, found, damping = trial, after, max(damping * 0.15, 1e-9)
        settled = settled + 1 if change < 1e-6 * (now + 1e-9) else 0
        if settled > (0 if held else 1) and step > 2:
            break
    slope = _slopes(formula, values, x, sd)
    return Fit(values, _covariance(slope, weight, stiff, found, values, low, high), found, weight)


def _slopes(formula: Formula, values: np.ndarray, x, sd: np.ndarray) -> np.ndarray:
    """Return the slopes of the prediction over the parameters, in standard deviations."""
    out = np.empty((len(sd), len(values)))
    for index, value in enumerate(values):
        step = 1e-5 * max(abs(value), 0.1)
        up, down = values.copy(), values.copy()
        up[index] += step
        down[index] -= step
        with np.errstate(over='ignore', invalid='ignore'):
            out[:, index] = (formula(up, x) - formula(down, x)) / (2.0 * step * sd)
    return np.clip(np.nan_to_num(out), -1e8, 1e8)


def _covariance(slope, weight, stiff, found, values, low, high) -> np.ndarray:
    free = (values > low) & (values < high)
    out = np.zeros((len(values), len(values)))
    normal = slope[:, free].T @ (weight[:, None] * slope[:, free]) + np.diag(stiff[free]**2)
    scale = max(1.0, float(weight @ found**2) / max(weight.sum() - free.sum(), 1.0))
    out[np.ix_(free, free)] = scale * np.linalg.pinv(normal, hermitian=True)
    return out


def _solve(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    try:
        return np.linalg.solve(matrix, vector)
    except np.linalg.LinAlgError:
        return np.linalg.lstsq(matrix, vector, rcond=None)[0]


def _tukey(found: np.ndarray) -> np.ndarray:
    """Return Tukey's weights; the scale is the median deviation, at least the stated noise."""
    scale = max(1.4826 * float(np.median(np.abs(found))), 1.0)
    return np.maximum(1.0 - (found / (_TUKEY * scale))**2, 0.0)**2


def predict_sd(fit: Fit, formula: Formula, x) -> np.ndarray:
    """Return the standard deviation of the fitted curve at ``x``."""
    ones = np.ones(len(formula(fit.values, x)))
    slope = _slopes(formula, fit.values, x, ones)
    return np.sqrt(np.maximum(np.einsum('ij,jk,ik->i', slope, fit.covariance, slope), 0.0))
