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

from hst_drive.identify.fit import each
from hst_drive.identify.linearised import Linearised
from hst_drive.identify.shapes import shapes_of
from hst_drive.identify.unknowns import Unknowns
import numpy as np

if TYPE_CHECKING:
    from hst_drive.identify.search import Candidate, Search


def score_test(search: Search, candidate: Candidate) -> Iterator[tuple[float, str]]:
    """Yield what share of the squared error each effect may take away, and its name."""
    campaign, own = search.campaign, search.whole(candidate).fit
    unknowns = Unknowns(campaign, own.model, shapes_of(candidate.names))
    vector = unknowns.pack(own.model)
    without = campaign.training(own.errors)
    columns = own.columns
    jacobian = np.column_stack([columns[key] for key in unknowns.names])
    known = Linearised(without, jacobian, vector, unknowns.factors)
    low, high = np.minimum(unknowns.low - vector, 0.0), np.maximum(unknowns.high - vector, 0.0)
    start = campaign.training(search.base.errors)

    def least(move: np.ndarray, lowest: float) -> float:
        both = known.beside(move)
        return both.after(both.step(np.append(low, lowest), np.append(high, np.inf)))

    total = float(without @ without)
    alone = known.after(known.step(low, high))

    def typical(name: str) -> np.ndarray:
        model = own.model.with_effect(name, campaign.typical(name))
        return campaign.training(campaign.errors(model, to_fit=True)) - without

    names = [name for name in search.candidates if name not in candidate.names]
    for name, move in zip(names, each(typical, names)):
        lowest = -np.inf if campaign.either_way(name) else 0.0
        alone_move = campaign.training(search.single(name).fit.errors) - start
        yield max(alone - least(entry, lowest) for entry in (alone_move, move)) / total, name
