# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Recordings that begin at different angles of the shaft, turned into step.

What swings with the angle has one phase on a machine. Each recording counts the angle from where
it began; turned so that their swings agree, they can be fitted together.
"""
from __future__ import annotations

from typing import Sequence

from hst_drive.diagnose.campaign import Campaign, Model
from hst_drive.diagnose.fit import Fit
from hst_drive.diagnose.orders import strongest_orders
from hst_drive.effects import catalogue
from hst_drive.measure.turns import start_angle, swinging, swings_per_turn
import numpy as np
from scipy.ndimage import gaussian_filter1d

_SLOW = 0.5     # s, standard deviation of what is taken away as no swing of a turn


def in_step(campaign: Campaign, model: Model,
            errors: Sequence[np.ndarray] | None = None) -> None:
    """
    Turn all recordings so that what swings with the angle has one phase in them.

    Parameters
    ----------
    campaign : Campaign
        Its recordings are turned.
    model : Model
        What swings in it decides.
    errors : sequence of ndarray, optional
        Of the model (``Campaign.errors``): if nothing swings in it, what swings in them decides.

    """
    turning = [replay for replay in campaign.replays if 'motor_angle' in replay.inputs]
    if not turning:
        return
    drive = campaign.driver(model)
    if errors is not None and not swinging(drive):
        orders = strongest_orders(campaign, errors)
        for name in campaign.candidates() if orders else ():
            if order := catalogue()[name].order:
                drive.switch_on(name, {order: float(orders[0])})
    for name in swinging(drive):
        for replay in turning:
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
    counts = [swings_per_turn(drive, name) for name in swinging(drive)]
    for replay, size in zip(campaign.replays, sizes):
        if 'motor_angle' in replay.inputs:
            swing = size - gaussian_filter1d(size, _SLOW / replay.run.sample_time)
            phase = float(np.angle(np.sum(swing * np.exp(-1j * replay.inputs['motor_angle']))))
            for count in counts:
                phase = round(phase * count / (2 * np.pi)) * 2 * np.pi / count
            replay.turn(phase)
