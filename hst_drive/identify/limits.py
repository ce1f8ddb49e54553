# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Units at the limits of their tolerances, and what takes them off."""
from __future__ import annotations

from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import at_limit, Fit
from hst_drive.identify.judge import SIGNIFICANT
from hst_drive.identify.search import Candidate, Search

# Natural logarithm of how much likelier something must make the logs to stand beside a unit at
# its limits: errors count as independent after 0.1 s, those of the torque are alike for 0.5 s.
_LIKELIER = 25.0


def limited(campaign: Campaign, fitted: Fit) -> set[str]:
    """Return the quantities of the unit that are as far off as their tolerances let them."""
    return {key for key, value in fitted.model.factors.items() if at_limit(campaign, key, value)}


def relieves(search: Search, other: Candidate, before: Candidate | None = None,
             tolerances: Campaign | None = None) -> bool:
    """
    Say whether something takes quantities of the unit off their limits and is far likelier.

    ``before`` is what it is laid beside: the unit alone by default. ``tolerances`` is the campaign
    that it was fitted in, if that has others.
    """
    before = before or search.baseline
    left = limited(tolerances or search.campaign, other.fit)
    return (left < limited(search.campaign, before.fit)
            and before.score - other.score >= 2 * _LIKELIER
            and max(search.gain(before, other, False).sigma.values(),
                    default=0.0) >= SIGNIFICANT)
