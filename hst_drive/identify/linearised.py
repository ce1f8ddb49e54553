# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Squared errors near a model: a quadratic of how far the unknowns move."""
from __future__ import annotations

from copy import copy

import numpy as np
from scipy.optimize import lsq_linear


class Linearised:
    """
    Squared errors and priors as a quadratic form.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Errors to fit on, over their floors.
    jacobian : ndarray, shape (n, m)
        What each unknown moves them by.
    vector : ndarray, shape (m,)
        The unknowns; those of the unit come first, with standard normal priors.
    factors : int
        How many belong to the unit.

    """

    def __init__(self, residual: np.ndarray, jacobian: np.ndarray, vector: np.ndarray,
                 factors: int):
        prior = (np.arange(len(vector)) < factors).astype(float)
        self._known = jacobian, residual
        self.normal = jacobian.T @ jacobian + np.diag(prior)
        self.gradient = jacobian.T @ residual + prior * vector
        self.cost = float(residual @ residual + prior @ vector**2)

    def least(self) -> float:
        """Return what is left at best."""
        return self.after(-np.linalg.solve(self.normal, self.gradient))

    def after(self, move: np.ndarray) -> float:
        """Return what is left once the unknowns have moved so far."""
        return float(self.cost + move @ (2.0 * self.gradient + self.normal @ move))

    def step(self, low: np.ndarray, high: np.ndarray, damping: float = 1e-9,
             moved: slice = slice(None)) -> np.ndarray:
        """Return how far those unknowns that are ``moved`` go, from ``low`` to ``high``."""
        # By default as if columns were alike but for the last digits, which they may be.
        normal = self.normal[moved, moved]
        scale = 1.0 / np.sqrt(np.diag(normal) + 1e-30)
        factor = np.linalg.cholesky(
            normal * np.outer(scale, scale) + damping * np.eye(len(normal)))
        target = np.linalg.solve(factor, -scale * self.gradient[moved])
        found = lsq_linear(factor.T, target, (low[moved] / scale - 1e-12,
                                              high[moved] / scale + 1e-12), method='bvls')
        move = np.zeros(len(self.gradient))
        move[moved] = scale * found.x
        return move

    def beside(self, column: np.ndarray) -> Linearised:
        """Return the same with an unknown more that moves the errors by ``column``."""
        (jacobian, residual), other = self._known, copy(self)
        across = jacobian.T @ column
        other.normal = np.block([[self.normal, across[:, None]],
                                 [across[None, :], np.array([[column @ column]])]])
        other.gradient = np.append(self.gradient, column @ residual)
        return other


def squared_slopes(jacobian: np.ndarray, residual: np.ndarray,
                   cluster: np.ndarray) -> np.ndarray:
    """
    Return the slope of the squared error times itself, summed over clusters of samples.

    The middle of a sandwich covariance, shape (unknowns, unknowns): samples of one cluster, by
    its number, may go together (P. Huber, Fifth Berkeley Symposium, 1967).
    """
    order = np.argsort(cluster, kind='stable')
    starts = np.flatnonzero(np.diff(cluster[order], prepend=-1))
    slopes = np.add.reduceat((jacobian * residual[:, None])[order], starts)
    return np.asarray(slopes.T @ slopes)
