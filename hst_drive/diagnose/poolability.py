# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Recordings that are not of one drive: a sensor that reads otherwise in one, another unit in each.

Physics that a model lacks is there in all recordings that visit where it shows. Where all but one
are explained, and that one is once a sensor's zero and span are set right, something was different
there: the unit in a column's heading, a sensor that was changed, another machine. Where each alone
is explained, but not all by one unit, they may be of several drives.
"""
from __future__ import annotations

from hst_drive.diagnose.causes import misreadings
from hst_drive.diagnose.free_forms import with_start
from hst_drive.identify.calibrate import calibrated
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit, fit, PATIENT
from hst_drive.identify.judge import parts, unexplained


def outlier_record(campaign: Campaign) -> tuple[int, str] | None:
    """Return the number of the odd recording and what is different there, if one is."""
    if len(campaign.replays) < 3:   # of two nobody could tell which is odd
        return None
    for log in range(len(campaign.replays)):
        others = campaign.of_logs(lambda index: index != log)
        if not any(len(column.fit) for column in others.columns):
            continue
        unit = calibrated(others)
        if _left(others, unit):
            continue
        alone = campaign.of_logs(lambda index: index == log, all_to_fit=True)
        for form in misreadings(campaign):
            start = with_start(unit.model, form)
            if not _left(alone, fit(alone, start, iterations=PATIENT)):
                return log, form.what
    return None


def several_drives(campaign: Campaign) -> bool:
    """Say whether each recording alone is explained, though not all are by one unit."""
    alone = (campaign.of_logs(lambda index, log=log: index == log, all_to_fit=True)
             for log in range(len(campaign.replays)))
    return len(campaign.replays) > 1 and not any(_left(each, calibrated(each)) for each in alone)


def _left(campaign: Campaign, fitted: Fit) -> bool:
    return any(unexplained(campaign, fitted, {}, part) for part in parts(campaign))
