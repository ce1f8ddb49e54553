# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The laws that a size may follow over a stretch of a machine's life, and their evidence."""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

STEADY, LINEAR, ONSET, ACCELERATING = range(4)
_STEADY = 0.5           # chance; all ways to grow are as likely
_RATES = np.geomspace(0.7, 6.5, 12)    # of an exponential, over the stretch


class Law(NamedTuple):
    """
    A law over a stretch: 0 at its start and 1 at its end; ``chance`` before anything is measured.

    ``shape`` is the place at which an onset begins, or the rate of what accelerates.
    """

    kind: int
    shape: float
    chance: float


def laws(places: np.ndarray) -> tuple[Law, ...]:
    """Return what is tried on a stretch with dates at these places, 0 to 1."""
    shapes = {STEADY: [0.0]}
    if len(places) > 1:
        shapes[LINEAR] = [0.0]
    if len(places) > 2:
        shapes[ACCELERATING] = [*_RATES]
    if len(places) > 3:
        # Two dates at least before it and after it; on a date or between two.
        shapes[ONSET] = [*places[1:-2], *(0.5 * (places[1:-2] + places[2:-1]))]
    growing = (1.0 - _STEADY) / max(len(shapes) - 1, 1)
    return tuple(Law(kind, float(shape), (growing if kind else _STEADY) / len(listed))
                 for kind, listed in shapes.items() for shape in listed)


def at(kinds: np.ndarray, shapes: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the laws' values at places."""
    kinds, shapes = np.asarray(kinds), np.asarray(shapes)
    late = np.where(kinds == ONSET, shapes, 0.0)
    rate = np.where(kinds == ACCELERATING, shapes, 1.0)
    with np.errstate(over='ignore'):    # what accelerates is beyond all bounds one day
        return np.select([kinds == LINEAR, kinds == ONSET, kinds == ACCELERATING], [
            places, np.maximum(places - late, 0.0) / (1.0 - late),
            np.expm1(rate * places) / np.expm1(rate)], 0.0)


def inverse(kinds: np.ndarray, shapes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the places at which the laws have these values; not finite where they never do."""
    late = np.where(kinds == ONSET, shapes, 0.0)
    rate = np.where(kinds == ACCELERATING, shapes, 1.0)
    return np.select([kinds == LINEAR, kinds == ONSET, kinds == ACCELERATING], [
        values, late + values * (1.0 - late), np.log1p(values * np.expm1(rate)) / rate], np.inf)


class Stretch(NamedTuple):
    """
    What the dates of a stretch say of each law and scatter.

    The law's level and rise, and how the size goes with the oil's temperature, are normal with a
    standard deviation of one (scale) before anything is measured; so the evidence is a closed
    form.

    Attributes
    ----------
    evidence : ndarray, shape (scatters, laws)
        Natural logarithm, with the chance of the law.
    means, precisions : ndarray, shape (laws, scatters, 3) and (laws, scatters, 3, 3)
        Of level, rise and temperature.

    """

    evidence: np.ndarray
    means: np.ndarray
    precisions: np.ndarray

    @classmethod
    def of(cls, tried: tuple[Law, ...], places: np.ndarray, values: np.ndarray,
           variances: np.ndarray, season: np.ndarray) -> Stretch:
        """
        Return the evidence of a stretch.

        Parameters
        ----------
        tried : tuple of Law
            The laws.
        places : ndarray, shape (dates,)
            Of the dates, 0 to 1.
        values : ndarray, shape (dates,)
            Sizes, scaled.
        variances : ndarray, shape (scatters, dates)
            Of each size, for each scatter.
        season : ndarray, shape (dates,)
            What temperatures do to the sizes, one standard deviation, scaled.

        """
        count = len(values)
        kinds, shapes = (np.array(column)[:, None] for column in list(zip(*tried))[:2])
        moved = at(kinds, shapes, places)
        design = np.stack([np.ones_like(moved), moved, np.broadcast_to(season, moved.shape)],
                          axis=-1)                                  # laws, dates, unknowns
        weighed = np.einsum('lnp,mn->lmnp', design, 1.0 / variances)
        precisions = np.einsum('lmnp,lnq->lmpq', weighed, design) + np.eye(3)
        pull = np.einsum('lmnp,n->lmp', weighed, values)
        means = np.linalg.solve(precisions, pull[..., None])[..., 0]
        fitted = np.einsum('lmp,lmp->lm', pull, means)
        square = (values**2 / variances).sum(axis=1)
        evidence = -0.5 * (
            count * np.log(2.0 * np.pi) + np.log(variances).sum(axis=1) + square - fitted
            + np.linalg.slogdet(precisions)[1])
        return cls((evidence + np.log([law.chance for law in tried])[:, None]).T, means,
                   precisions)

    def draw(self, law: int, scatter: int, count: int,
             random: np.random.Generator) -> np.ndarray:
        """Return level, rise and temperature's part, drawn by chance, shape (count, 3)."""
        root = np.linalg.cholesky(np.linalg.inv(self.precisions[law, scatter]))
        return self.means[law, scatter] + random.standard_normal((count, len(root))) @ root.T
