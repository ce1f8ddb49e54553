# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The fit of the unit alone."""
from __future__ import annotations

from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit, fit, PATIENT
from hst_drive.identify.judge import excess, PRACTICAL
from hst_drive.identify.model import Model
import numpy as np

_HOT, _LONGEST = 9.0, 3     # squared error of a block, blocks: an event


def calibrated(campaign: Campaign) -> Fit:
    """
    Return the fit of the unit's factors alone.

    Where the model stalls and the machine does not, or the other way round, a few seconds may
    keep all else from being fitted: if all else then fits down to the noise, they are left to
    the effects. What comes back is no event, but physics that shows only there.
    """
    plain = fit(campaign, Model(), iterations=5, refresh=True)
    if not campaign.events or _fits(campaign, plain):
        return plain
    # Without the blocks that are off most, as many as single events may spoil.
    number = campaign.fitted_blocks()
    blocks, block = np.unique(number, return_inverse=True)
    worst = np.argsort(-np.bincount(block, campaign.training(plain.errors)**2))
    spoilt = blocks[worst[:int(np.ceil(campaign.events * len(blocks)))]]
    calm = ~np.isin(number, spoilt)
    found = fit(campaign.without_blocks(spoilt), plain.model, iterations=PATIENT,
                known={name: column[calm] for name, column in plain.columns.items()})
    trimmed = fit(campaign, found.model, iterations=0)
    if not (_fits(campaign, trimmed) and _is_one_event(campaign, trimmed)):
        return plain
    return fit(campaign, found.model, iterations=0, refresh=True)


def _fits(campaign: Campaign, fitted: Fit) -> bool:
    return excess(campaign.ratios(fitted.errors, False)) < PRACTICAL


def _is_one_event(campaign: Campaign, fitted: Fit) -> bool:
    """Tell whether the blocks that the fit leaves far off lie side by side."""
    worst = np.nanmax(list(campaign.blocks(fitted.errors, False).values()), axis=0)
    hot = np.flatnonzero(worst > _HOT)
    return len(hot) == 0 or int(hot[-1] - hot[0]) < _LONGEST
