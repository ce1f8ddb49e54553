# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How sure the fitted sizes are: 95 % intervals that know that errors are correlated.

The sandwich estimator over blocks (H. White, Econometrica 50, 1982; blocks of two seconds as
clusters) replaces the naive covariance, which takes every sample as independent and is far too
narrow. Added are a share of the effect's own size for its functional form, what the unit's tables
do between their points, what shapes that took their usual values leave open, and the bias of the
prior on a unit that is far off its make.
"""
from __future__ import annotations

from typing import Mapping, NamedTuple

from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import differences, Fit, FORM
from hst_drive.identify.linearised import squared_slopes
from hst_drive.identify.model import Model
from hst_drive.identify.unknowns import Unknowns
import numpy as np
from scipy.special import ndtri


class Spread(NamedTuple):
    """
    What is known of a fit's unknowns: their values and covariances, SI.

    ``before`` are the values without the effects: adopted sizes, else 0. ``unit``, a column each:
    how the estimates move with what this unit is off the make in each of its unknowns, by a
    tolerance or as far as it is out.
    """

    unknowns: Unknowns
    values: np.ndarray
    covariances: np.ndarray
    before: np.ndarray
    unit: np.ndarray


def spread(campaign: Campaign, fitted: Fit, forms: Mapping[str, float] = {},
           between_points: float = 1.0) -> Spread:
    """
    Return how far the unknowns of a fit may be off, shapes that it kept among them.

    ``forms`` are the shares of effects by which they may be off their formulas, if more than
    usual, ``between_points`` is what the tables leave open between their points, of the squared
    tolerance.
    """
    unknowns = Unknowns(campaign, fitted.model)
    vector = unknowns.pack(fitted.model)
    # An effect that the rig has adopted has its form from there: what changed may be off another.
    before = unknowns.pack(Model({
        name: campaign.off(name) if name in campaign.adopted else dict.fromkeys(values, 0.0)
        for name, values in fitted.model.effects.items()}))
    jacobian = _whole(campaign, fitted, unknowns, vector)
    unit = np.arange(len(vector)) < unknowns.factors
    above, below = unknowns.high - vector, unknowns.low - vector
    # Anywhere within its bounds a parameter is as plausible: the mean square from where it is.
    prior = np.where(unit, 1.0, 3.0 * (above - below) / (above**3 - below**3))
    inverse = np.linalg.pinv(jacobian.T @ jacobian + np.diag(prior))
    residual = campaign.training(fitted.errors)
    # The prior draws a factor to the datasheet: it may be off by as much as it is far out.
    out = np.maximum(np.abs(vector), 1.0)
    meat = np.diag(np.where(unit, out**2 + between_points, prior))
    meat += squared_slopes(jacobian, residual, campaign.fitted_blocks())
    covariance = inverse @ meat @ inverse
    for name in fitted.model.effects:
        own = np.array([effect == name for effect, _ in unknowns.names]) * (vector - before)
        covariance += max(FORM, forms.get(name, 0.0))**2 * np.outer(own, own)
    # An effect's number that moves nothing is not known at all: ten times its range.
    still = ~jacobian.any(axis=0) & ~unit
    covariance[still, still] = (10.0 * (above - below)[still])**2
    mix = unknowns.mix
    return Spread(unknowns, mix(vector), mix(mix(covariance).T), mix(before),
                  mix((inverse * out)[:, :unknowns.factors]))


def _whole(campaign: Campaign, fitted: Fit, unknowns: Unknowns,
           vector: np.ndarray) -> np.ndarray:
    """Return the Jacobian with the columns of what the fit kept as it was."""
    known = fitted.columns
    kept = [index for index, name in enumerate(unknowns.names) if name not in known]
    added = differences(campaign, unknowns, vector, fitted.errors, kept,
                        lambda moved: campaign.errors(unknowns.unpack(moved), to_fit=True))
    known.update(zip((unknowns.names[index] for index in kept), added.T))
    return np.column_stack([known[name] for name in unknowns.names])


def intervals(campaign: Campaign, fitted: Fit, forms: Mapping[str, float] = {}
              ) -> dict[tuple[str, str], tuple[float, float]]:
    """
    Return low and high of each unknown, SI, by (effect, parameter); effect '' for the unit.

    Factors of the unit are natural logarithms. Bounds of the parameters are kept. For ``forms``
    see ``spread``. A size that its shape leaves open (a gas volume, known but for the precharge)
    is one by its ratio: where the effect is there for sure, nothing is no value for it.
    """
    found = spread(campaign, fitted, forms)
    unknowns, values = found.unknowns, found.values
    width = ndtri(0.975) * np.sqrt(np.diag(found.covariances))
    away = values - found.before
    first = {(name, next(iter(shape))) for name, shape in fitted.model.effects.items()}
    open_ = np.array([name in first for name in unknowns.names], dtype=bool) & (
        width >= np.abs(away)) & (width < np.ptp(unknowns.bounds, axis=1)) & (away != 0.0)
    # At a bound to the last digit: who reads it compares them.
    ends = np.array([values - width, values + width])
    ratio = np.exp(width[open_] / np.abs(away[open_]))
    ends[:, open_] = (values - away)[open_] + np.sort(
        [away[open_] / ratio, away[open_] * ratio], axis=0)
    low, high = np.clip(ends, *unknowns.bounds.T)
    return {name: (float(a), float(b)) for name, a, b in zip(unknowns.names, low, high)}
