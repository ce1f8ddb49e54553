# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which effect more may take away what a fitted model leaves.

A score test (added variables): each effect's move of the signals is put beside what the model can
do by itself, linearly, within the bounds and with the priors of the unit. Shapes stay where they
are in this, since a shape may stand in the place of an effect.
"""
from __future__ import annotations

from typing import Iterator, TYPE_CHECKING

from hst_drive.effects import catalogue
from hst_drive.identify.shapes import shapes_of
from hst_drive.identify.unknowns import Unknowns
import numpy as np
from scipy.optimize import lsq_linear

if TYPE_CHECKING:
    from hst_drive.identify.search import Candidate, Search


def score_test(search: Search, candidate: Candidate) -> Iterator[tuple[float, str]]:
    """Yield what share of the squared error each effect may take away, and its name."""
    campaign, own = search.campaign, candidate.fit
    unknowns = Unknowns(campaign, own.model, shapes_of(candidate.names))
    columns_of = dict(zip(own.names, own.jacobian.T))
    vector = unknowns.pack(own.model)
    prior = np.where(np.arange(len(vector)) < unknowns.factors, 1.0, 0.0)
    without = campaign.training(own.errors)
    left = np.append(without, prior * vector)
    known = np.vstack([np.column_stack([columns_of[key] for key in unknowns.names]),
                       np.diag(prior)])
    low = np.minimum(unknowns.low - vector, 0.0)
    high = np.maximum(unknowns.high - vector, 0.0)
    start = campaign.training(search.base.errors)

    def least(move: np.ndarray, lowest: float) -> float:
        columns = np.column_stack([known, np.append(move, np.zeros(len(vector)))])
        normal = columns.T @ columns
        scale = 1.0 / np.sqrt(np.diag(normal) + 1e-30)
        factor = np.linalg.cholesky(normal * np.outer(scale, scale) + 1e-9 * np.eye(len(normal)))
        target = np.linalg.solve(factor, -scale * (columns.T @ left))
        found = lsq_linear(factor.T, target, (
            np.append(low, lowest) / scale - 1e-12, np.append(high, np.inf) / scale + 1e-12))
        return float(np.sum((left + columns @ (scale * found.x))**2))

    total = float(without @ without)
    alone = least(np.zeros_like(without), 0.0)
    for name in search.candidates:
        if name in candidate.names:
            continue
        size = catalogue(everything=True)[name].parameters[0]
        lowest = -np.inf if size.low < campaign.off(name)[size.name] else 0.0
        typical = own.model.with_effect(name, campaign.typical(name))
        moves = (campaign.training(search.single(name).fit.errors) - start,
                 campaign.training(campaign.errors(typical, to_fit=True)) - without)
        yield max(alone - least(move, lowest) for move in moves) / total, name
