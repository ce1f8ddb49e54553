# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Shapes of effects: the power of a friction curve, how far a drag follows the viscosity.

They are fitted, since machines differ, but each has values that the field's formulas have: with
these the sizes come out right where the data cannot tell a shape.
"""
from __future__ import annotations

from typing import Sequence, TYPE_CHECKING

from hst_drive.effects import effect_of
from hst_drive.identify.fit import fit

if TYPE_CHECKING:
    from hst_drive.identify.search import Candidate, Search


def shapes_of(names: Sequence[str]) -> set[tuple[str, str]]:
    """Return the (effect, parameter) that have usual values."""
    return {(name, entry.name) for name in names
            for entry in effect_of(name).parameters if entry.usual}


def with_usual_shapes(search: Search, best: Candidate) -> Candidate:
    """Give shapes their usual values where the data do not ask for others."""
    kept: set[tuple[str, str]] = set()
    open_ = shapes_of(best.names) & {*best.fit.names}
    while open_:
        # One shape may stand for another: first the one that loses least by it.
        model, trials = best.fit.model, []
        for name, key in sorted(open_):
            for value in effect_of(name).parameter(key).usual:
                usual = model.with_effect(name, {**model.effects[name], key: value})
                found = fit(search.campaign, usual, known=best.fit.columns,
                            kept={*kept, (name, key)})
                trials.append((search.candidate(best.names, found), (name, key)))
        nearest, shape = min(trials, key=lambda item: item[0].score)
        if nearest.score >= best.score:
            break
        best = nearest
        kept.add(shape)
        open_.remove(shape)
    if kept:
        found = fit(search.campaign, best.fit.model, iterations=1, refresh=True, kept=kept)
        best = search.candidate(best.names, found)
    return best
