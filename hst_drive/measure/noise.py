# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Noise and coloured disturbances, estimated from a record itself.

White sensor noise is what remains of a signal after differencing that removes smooth motion.
A coloured disturbance (the roughness of the ground) is taken as an Ornstein-Uhlenbeck process:
its precision matrix over any time stamps is tridiagonal, so that the best estimate from noisy
samples, and draws of the error that remains, cost one banded solution each (C. E. Rasmussen,
C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006, section B.2).
"""
from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded, solve_banded
from scipy.optimize import nnls

_BLOCK = 50         # samples in which noise is told from motion
_SPAN, _FEWEST = 1.0, 10    # s and samples: a block of increments; a step of the load spoils few
_SHORT = 0.3        # s: lags that tell white noise; steps of the load show in longer ones
_SECOND = (0.15, 0.3, 0.5, 1.0)     # time constant of a second pole over that of the first
_CLEARLY = 0.7      # of the misfit of one pole: below, two poles fit better than by chance


def noise_std(values: np.ndarray) -> float:
    """
    Estimate the standard deviation of the white noise in a signal.

    Fourth differences in blocks; the lower third of the blocks counts, so that steps and
    ringing in the others do no harm.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Evenly sampled; NaN are left out.

    Returns
    -------
    float
        In the unit of the signal; 0 if there are too few samples.

    """
    values = values[np.isfinite(values)]
    if len(values) < 10:
        return 0.0
    size = min(_BLOCK, max((len(values) - 4) // 4, 3))
    fourth = np.diff(values, 4) / np.sqrt(70.0)
    blocks = fourth[:len(fourth) // size * size].reshape(-1, size)
    deviations = np.sort(np.sqrt(np.mean(blocks**2, axis=1)))
    # The mean of the lower third of k estimates with relative scatter s lies about 1.1*s low.
    lower = deviations[:max(len(deviations) // 3, 1)].mean()
    scatter = np.sqrt(1.77 / size) / np.sqrt(2.0) * 1.45
    return float(lower * (1 + (1.09 * scatter if len(deviations) >= 3 else 0.0)))


def steady_noise(values: np.ndarray) -> float:
    """Return the white noise of a signal, also where most of a short record holds a step."""
    values = values[np.isfinite(values)]
    if len(values) < 10:
        return 0.0
    fourth = np.abs(np.diff(values, 4)) / np.sqrt(70.0)
    return min(noise_std(values), float(np.median(fourth)) / 0.6745)


def surface_noise(values: np.ndarray, over: Sequence[np.ndarray]) -> float:
    """
    Return the deviation of a table's column from a smooth function of others.

    Parameters
    ----------
    values : ndarray, shape (n,)
        The column.
    over : sequence of ndarray, shape (n,)
        What a cubic in each, without mixed terms, may take away.

    """
    terms = [np.ones(len(values))]
    for column in over:
        if np.ptp(column) > 1e-9 * np.max(np.abs(column)):
            scaled = 2 * (column - column.min()) / np.ptp(column) - 1
            terms += [scaled, scaled**2, scaled**3]
    matrix = np.column_stack(terms[:max(len(values) // 3, 1)])
    left = values - matrix @ np.linalg.lstsq(matrix, values, rcond=None)[0]
    return float(np.sqrt(left @ left / max(len(values) - matrix.shape[1], 1)))


class Coloured(NamedTuple):
    """An Ornstein-Uhlenbeck disturbance in white noise: deviations and correlation time (s)."""

    std: float
    time_constant: float
    noise_std: float

    @classmethod
    def white(cls, noise: float) -> Coloured:
        """Return white noise alone; what is not there has a usual time constant."""
        return cls(0.0, 0.3, noise)


def estimate_coloured(time: np.ndarray, values: np.ndarray, noise: float) -> Coloured:
    """
    Fit a coloured disturbance in white noise to a residual by its structure function.

    The squared increments over lags of one sample to 1 s, as medians over blocks, grow as
    ``2*noise**2 + 2*std**2*(1 - exp(-lag/time_constant))``. Where a disturbance of two poles,
    smoother at short lags, fits these better, the white noise is what stands beside that.

    Parameters
    ----------
    time, values : ndarray, shape (n,)
        s and any unit.
    noise : float
        Upper limit for the standard deviation of the white noise.

    """
    step = float(np.median(np.diff(time)))
    lags = np.unique(np.maximum(np.round(np.geomspace(step, 1.0, 20) / step), 1).astype(int))
    lags = lags[lags < len(values) // 8]
    if len(lags) < 3:
        return Coloured.white(noise)
    growth, size = [], _block_size(step)
    for lag in lags:
        squares = (values[lag:] - values[:-lag])**2
        squares = squares[np.isfinite(squares)]
        growth.append(np.median(_block_means(squares, size)) if len(squares) else 0.0)
    half = 0.5 * np.array(growth)
    top = float(half.max())
    if top < 1e-100:
        return Coloured.white(0.0)
    half, most = half / top, noise**2 / top
    short = lags * step < _SHORT
    (_, misfit), *smooth = (_fitted(lags[short] * step, half[short], 0.0, most, second)
                            for second in (0.0, *_SECOND))
    best, smoother = min(smooth, key=lambda found: found[1])
    least = best.noise_std**2 if smoother < _CLEARLY * misfit else 0.0
    rough, _ = _fitted(lags * step, half, least, most)
    return Coloured(rough.std * math.sqrt(top), rough.time_constant,
                    rough.noise_std * math.sqrt(top))


def variance_ratio(time: np.ndarray, rough: np.ndarray, load: np.ndarray, noise: float,
                   known: np.ndarray) -> np.ndarray:
    """
    Return how the variance of a rough load goes with the load's square, over its usual one.

    What is rough in rock is a share of its torque, and what is rough in a drive is not.

    Parameters
    ----------
    time, rough, load : ndarray, shape (n,)
        s, and N.m: what is fast in the unexplained torque, and the load itself.
    noise : float
        White part of the first, N.m.
    known : ndarray of bool, shape (n,)
        Rows in which the torque was read and the drive turned.

    """
    known = known & np.isfinite(rough) & np.isfinite(load)
    size = _block_size(float(np.median(np.diff(time))))
    if known.sum() < 12 * size:
        return np.ones(len(time))
    power, level = (_block_means(values[known]**2, size) for values in (rough, load))
    # Medians of quarters: what a model misses now and then is no roughness.
    quarters = np.array_split(np.argsort(level), 4)
    squares, powers = (np.array([np.median(values[part]) for part in quarters])
                       for values in (level, power))
    scale = max(float(squares.max()), 1e-30)
    alike, share = nnls(np.column_stack([np.ones(4), squares / scale]),
                        np.maximum(powers - noise**2, 0.0))[0]
    usual = float(np.median(alike + share * level / scale))
    if not usual > 0.0:
        return np.ones(len(time))
    return np.nan_to_num((alike + share * load**2 / scale) / usual, nan=1.0)


def _fitted(lags: np.ndarray, half: np.ndarray, least: float, most: float,
            second: float = 0.0) -> tuple[Coloured, float]:
    """
    Fit half the squared increments, white noise between two variances; return the misfit, too.

    ``second`` is the time constant of a second pole over that of the first.
    """
    weights = 1 / np.maximum(half, 1e-2)
    best, error = Coloured.white(math.sqrt(most)), np.inf
    for constant in np.geomspace(0.03, 2.0, 25):
        if 0.0 < second * constant < 2.0 * lags[0]:
            continue    # of so few rows that nothing tells it from white noise
        ago = lags / constant
        shape = 1.0 - (np.exp(-ago) * (1.0 + ago) if second == 1.0 else np.exp(-ago))
        if 0.0 < second < 1.0:
            shape = 1.0 - (np.exp(-ago) - second * np.exp(-ago / second)) / (1.0 - second)
        columns = np.column_stack([np.ones(len(lags)), shape]) * weights[:, None]
        white, variance = np.linalg.lstsq(columns, half * weights, rcond=None)[0]
        white = min(max(float(white), least), most)
        rest = (half - white) * weights
        variance = max(float(columns[:, 1] @ rest / (columns[:, 1] @ columns[:, 1])), 0.0)
        misfit = float(np.sum((rest - variance * columns[:, 1])**2))
        if misfit < error:
            best = Coloured(math.sqrt(variance), constant, math.sqrt(white))
            error = misfit
    return best, error


def _block_size(step: float) -> int:
    """Return how many samples a block of increments has, which come each ``step`` (s)."""
    return max(round(_SPAN / step), _FEWEST)


def _block_means(values: np.ndarray, size: int) -> np.ndarray:
    """Return the means of blocks of ``size`` or a little more, that hold all values."""
    return np.array([block.mean()
                     for block in np.array_split(values, max(len(values) // size, 1))])


class Smoother:
    """
    Best estimate of a coloured disturbance from noisy samples, and draws of its error.

    Parameters
    ----------
    time : ndarray, shape (n,)
        s, strictly rising.
    coloured : Coloured
        What is assumed.
    valid : ndarray of bool, shape (n,)
        Samples that count.

    """

    def __init__(self, time: np.ndarray, coloured: Coloured, valid: np.ndarray):
        variance = max(coloured.std**2, 1e-12)
        noise = max(coloured.noise_std**2, 1e-12)
        decay = np.exp(-np.diff(time) / coloured.time_constant)
        innovation = variance * (1 - decay**2)
        diagonal = np.zeros(len(time))
        diagonal[0] = 1 / variance
        diagonal[1:] = 1 / innovation
        diagonal[:-1] += decay**2 / innovation
        self._weight = np.where(valid, 1 / noise, 0.0)
        # A straight line between samples misses a bridge; its mean has this deviation.
        self._bridge = np.sqrt(np.append(innovation, innovation[-1]) / 12.0)
        self._negligible = coloured.std <= 1e-6
        self._factor = cholesky_banded(
            np.array([np.concatenate([[0.0], -decay / innovation]), diagonal + self._weight]))

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """Return the estimate, shape (n,)."""
        if self._negligible:
            return np.zeros(len(values))
        rhs = self._weight * np.where(self._weight > 0, values, 0.0)
        return cho_solve_banded((self._factor, False), rhs)

    def draw_error(self, random: np.random.Generator) -> np.ndarray:
        """Return one draw of what the estimate misses, shape (n,)."""
        if self._negligible:
            return np.zeros(len(self._weight))
        n = len(self._weight)
        at_samples = solve_banded((0, 1), self._factor, random.standard_normal(n))
        return at_samples + self._bridge * random.standard_normal(n)
