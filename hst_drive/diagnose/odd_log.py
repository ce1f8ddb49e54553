# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A recording that is unlike the others of its campaign.

Physics that a model lacks is there in all recordings that visit where it shows. Where all but one
are explained, and that one is far off, something was different there: a unit in a column's
heading, a sensor that was changed, another machine.
"""
from __future__ import annotations

import copy

from hst_drive.diagnose.campaign import Campaign
from hst_drive.diagnose.fit import calibrated
from hst_drive.diagnose.judge import unexplained
import numpy as np

_FAR = 3.0      # noise ratio of the odd one
_FEWEST = 3     # recordings: of two nobody could tell which is odd


def odd_log(campaign: Campaign) -> int | None:
    """Return the number of the recording without which the others are explained, if one is."""
    if len(campaign.replays) < _FEWEST:
        return None
    for log in range(len(campaign.replays)):
        others = _only(campaign, lambda place: place != log)
        if not any(len(column.fit) for column in others.columns):
            continue
        fitted = calibrated(others)
        if any(unexplained(others, fitted, {}, held_out) for held_out in (True, False)):
            continue
        alone = _only(campaign, lambda place: place == log)
        left = [ratio for held_out in (True, False)
                for ratio in alone.ratios(fitted.errors, held_out).values()]
        if max(left, default=0.0) > _FAR:
            return log
    return None


def _only(campaign: Campaign, wanted) -> Campaign:
    """Return the campaign with the samples of some recordings alone."""
    part = copy.copy(campaign)
    nothing = np.zeros(0, dtype=int)
    part.columns = [column if wanted(column.log) else column._replace(fit=nothing, judge=nothing)
                    for column in campaign.columns]
    return part
