# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A recording in which a sensor reads otherwise than in the others of its campaign.

Physics that a model lacks is there in all recordings that visit where it shows. Where all but one
are explained, and that one is once a sensor's zero and span are set right, something was different
there: the unit in a column's heading, a sensor that was changed, another machine.
"""
from __future__ import annotations

from hst_drive.diagnose.campaign import Campaign
from hst_drive.diagnose.causes import misreadings
from hst_drive.diagnose.fit import calibrated, Fit, fit
from hst_drive.diagnose.judge import unexplained
from hst_drive.diagnose.nameless import faint, PATIENT

_FEWEST = 3     # recordings: of two nobody could tell which is odd


def odd_log(campaign: Campaign) -> tuple[int, str] | None:
    """Return the number of the odd recording and what is different there, if one is."""
    if len(campaign.replays) < _FEWEST:
        return None
    for log in range(len(campaign.replays)):
        others = campaign.of_logs(lambda place: place != log)
        if not any(len(column.fit) for column in others.columns):
            continue
        unit = calibrated(others)
        if _left(others, unit):
            continue
        alone = campaign.of_logs(lambda place: place == log, all_to_fit=True)
        for freer in misreadings(campaign):
            start = faint(unit.model, freer)
            if not _left(alone, fit(alone, start, iterations=PATIENT)):
                return log, freer.what
    return None


def _left(campaign: Campaign, fitted: Fit) -> bool:
    return any(unexplained(campaign, fitted, {}, held_out) for held_out in (True, False))
