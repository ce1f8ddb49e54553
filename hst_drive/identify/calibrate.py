# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The fit of the unit alone, as deep as it goes."""
from __future__ import annotations

from dataclasses import replace

from hst_drive.effects import effect_of
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import cost_of, Fit, fit
from hst_drive.identify.judge import excess, PRACTICAL
from hst_drive.identify.model import Model
from hst_drive.identify.unknowns import SIGMAS, Unknowns
import numpy as np

_END = 0.8 * SIGMAS     # tolerances: near the end of what a factor may be
_HOT, _LONGEST = 9.0, 3     # squared error of a block, blocks: an event


def calibrated(campaign: Campaign) -> Fit:
    """
    Return the fit of the unit's factors alone.

    Where the model stalls and the machine does not, or the other way round, a few seconds may
    keep all else from being fitted: if all else then fits down to the noise, they are left to
    the effects. What comes back is no event, but physics that shows only there.
    """
    plain = fit(campaign, Model(), iterations=5, refresh=True)
    if _fits(campaign, plain):
        return plain
    plain = _deepest(campaign, plain)
    trimmed = fit(campaign, Model(), iterations=8, refresh=True, trimmed=True)
    return trimmed if _fits(campaign, trimmed) and _is_one_event(campaign, trimmed) else plain


def without_adopted(campaign: Campaign, base: Fit) -> Fit:
    """Return the unit's fit with the errors that it has without what the rig has adopted."""
    if not campaign.adopted:
        return base
    return base._replace(errors=campaign.errors(replace(base.model, effects={
        name: effect_of(name).neutral for name in campaign.adopted})))


def _fits(campaign: Campaign, fitted: Fit) -> bool:
    return excess(campaign.ratios(fitted.errors, False)) < PRACTICAL


def _deepest(campaign: Campaign, plain: Fit) -> Fit:
    """
    Return the fit of the unit in the deepest valley.

    The drive rings, and a fit may end a period of the ringing off. Then the model is better, if
    all else stays, where one factor has the other end of its tolerance: from there it goes on.
    """
    unknowns = Unknowns(campaign, plain.model)
    vector, factors = unknowns.pack(plain.model), len(campaign.tolerances)
    if not factors:
        return plain

    def at(index: int, end: float) -> tuple[float, Model]:
        moved = vector.copy()
        moved[index] = _END * end
        model = unknowns.unpack(moved)
        errors = campaign.errors(model, to_fit=True)
        return cost_of(unknowns, moved, campaign.training(errors)), model

    cost, start = min((at(index, end) for index in range(factors) for end in (-1.0, 1.0)),
                      key=lambda item: item[0])
    if cost >= plain.cost:
        return plain
    return min(plain, fit(campaign, start, iterations=5, refresh=True),
               key=lambda item: item.cost)


def _is_one_event(campaign: Campaign, fitted: Fit) -> bool:
    """Tell whether the blocks that the fit leaves far off lie side by side."""
    worst = np.nanmax(list(campaign.blocks(fitted.errors, False).values()), axis=0)
    hot = np.flatnonzero(worst > _HOT)
    return len(hot) == 0 or int(hot[-1] - hot[0]) < _LONGEST
