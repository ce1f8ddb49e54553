# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Recordings that begin at different angles of the shaft, turned into step.

What swings with the angle has one phase on a machine. Each recording counts the angle from where
it began; turned so that their swings agree, they can be fitted together.
"""
from __future__ import annotations

from typing import Sequence

from hst_drive.diagnose.campaign import Campaign
from hst_drive.diagnose.fit import Fit
from hst_drive.diagnose.orders import strongest_orders
from hst_drive.effects import catalogue
from hst_drive.measure.turns import start_angle, swinging
import numpy as np
from scipy.ndimage import gaussian_filter1d

_SLOW = 0.5     # s, standard deviation of what is taken away as no swing of a turn


def in_step(campaign: Campaign, fitted: Fit) -> None:
    """Turn all recordings so that what swings with the angle, or may, has one phase in them."""
    if sum('motor_angle' in replay.inputs for replay in campaign.replays) < 2:
        return
    drive = campaign.driver(fitted.model)
    names = swinging(drive)
    if not names:
        names = [name for name in campaign.candidates() if catalogue()[name].order]
        orders = strongest_orders(campaign, fitted.errors)
        for name in names if orders else ():
            drive.switch_on(name, {catalogue()[name].order: float(orders[0])})
    for name in names:
        for replay in campaign.replays:
            if name in drive.effects and 'motor_angle' in replay.inputs:
                replay.turn(start_angle(replay, drive, name))


def once_a_turn(campaign: Campaign, fitted: Fit, sizes: Sequence[np.ndarray]) -> None:
    """
    Turn all recordings so that what swings once a turn has one phase in them.

    Parameters
    ----------
    campaign : Campaign
        Its recordings are turned.
    fitted : Fit
        Swings that its model has stay as they are.
    sizes : sequence of ndarray
        What swings, log by log.

    """
    if not any('motor_angle' in replay.inputs for replay in campaign.replays):
        return
    drive = campaign.driver(fitted.model)
    counts = [drive.effects[name][catalogue(everything=True)[name].order]
              or drive.rig.motor.pistons for name in swinging(drive)]
    for replay, size in zip(campaign.replays, sizes):
        if 'motor_angle' in replay.inputs:
            swing = size - gaussian_filter1d(size, _SLOW / replay.run.sample_time)
            phase = float(np.angle(np.sum(swing * np.exp(-1j * replay.inputs['motor_angle']))))
            for count in counts:
                phase = round(phase * count / (2 * np.pi)) * 2 * np.pi / count
            replay.turn(phase)
