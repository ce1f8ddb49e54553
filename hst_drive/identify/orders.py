# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How often in a turn of the hydromotor its errors swing: the order spectrum of what is left."""
from __future__ import annotations

from typing import Sequence

from hst_drive.identify.campaign import Campaign
from hst_drive.measure.turns import SLOW
import numpy as np
from scipy.ndimage import gaussian_filter1d

LOWEST, HIGHEST = 3, 40     # swings per turn: pistons of one machine, times the lobes of its cam
_AS_STRONG = 0.5            # of the strongest
_SEEN = 0.4                 # of the sampling rate: what swings faster is not seen


def strongest_orders(campaign: Campaign, errors: Sequence[np.ndarray]) -> list[int]:
    """Return the number of swings per turn that holds most of the errors, and one as strong."""
    orders = np.arange(LOWEST, HIGHEST + 1)
    power = np.zeros(len(orders))
    for error, column in zip(errors, campaign.columns):
        replay = campaign.replays[column.log]
        angle = replay.inputs.get('motor_angle')
        if angle is None or not len(column.fit):
            continue
        step = replay.run.sample_time
        swing = error * column.trust
        swing = (swing - gaussian_filter1d(swing, SLOW / step))[column.fit]
        speed = np.abs(np.gradient(angle, replay.run.time)[column.fit])
        turn = np.exp(-1j * angle[column.fit])
        wave = turn**LOWEST
        for place, order in enumerate(orders):
            seen = order * speed < 2.0 * np.pi * _SEEN / step
            if not seen.any():
                break
            power[place] += abs(np.sum(swing[seen] * wave[seen]))**2 / len(column.fit)
            wave *= turn
    strongest = np.argsort(-power)[:2]
    return [int(orders[place]) for place in strongest
            if power[place] > _AS_STRONG * power.max()]
