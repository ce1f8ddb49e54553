# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How a unit, and its sensors, are off their datasheets: what a fit says of that, for people."""
from __future__ import annotations

from typing import Container, Mapping

from hst_drive.channels import CHANNELS
from hst_drive.diagnose.result import Calibrated, Zero
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import at_limit, Fit, limited
from hst_drive.identify.zeros import LATE


def at_limits(campaign: Campaign, fitted: Fit) -> list[str]:
    """Return what is as far off as it may be."""
    return [f'the zero of {key}' if key in campaign.zeros else
            f'the delay of {key.removesuffix(LATE)}' if key in campaign.delays else key
            for key in limited(campaign, fitted)]


def calibration(campaign: Campaign, fitted: Fit,
                but: Container[str] = ()) -> tuple[Calibrated, ...]:
    """Return the quantities but for some, the furthest off in their tolerances first."""
    return tuple(sorted(
        (Calibrated(key, campaign.expected.get(key, 1.0) * fitted.model.scales[key],
                    value / campaign.tolerances[key], at_limit(campaign, key, value))
         for key, value in fitted.model.factors.items() if key not in but),
        key=lambda item: -abs(item.sigmas)))


def sensors(campaign: Campaign, found: Mapping[str, float]) -> tuple[Zero, ...]:
    """Return zeros or delays, the greatest in their sigmas first."""
    return tuple(sorted((
        Zero(key.removesuffix(LATE), value,
             's' if key in campaign.delays else CHANNELS[key].unit, value / campaign.sigmas[key])
        for key, value in found.items()), key=lambda item: -abs(item.sigmas)))
