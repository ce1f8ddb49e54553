# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Swings with the angle of the shaft: their orders, and recordings turned into step.

What swings with the angle has one phase on a machine. Each recording counts the angle from where
it began; turned so that their swings agree, they can be fitted together.
"""
from __future__ import annotations

from typing import Sequence

from hst_drive.effects import catalogue
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit
from hst_drive.identify.model import Model
from hst_drive.measure.turns import into_step, SLOW, swinging, turn
import numpy as np
from scipy.ndimage import gaussian_filter1d

LOWEST, HIGHEST = 3, 40     # swings per turn: pistons of one machine, times the lobes of its cam
_AS_STRONG = 0.5            # of the strongest
_SEEN = 0.4                 # of the sampling rate: what swings faster is not seen
_SLOW = 0.5     # s, standard deviation of what is taken away as no swing of a turn


def in_step(campaign: Campaign, model: Model,
            errors: Sequence[np.ndarray] | None = None) -> Campaign:
    """
    Return the campaign with recordings turned so that their swings have one phase.

    The one that is given stays as it is. What swings in the model decides. If nothing does, what
    swings in its ``errors`` (``Campaign.errors``) decides.
    """
    if errors is not None and not swinging(campaign.driver(model)):
        orders = strongest_orders(campaign, errors)
        for name in campaign.candidates() if orders else ():
            if order := catalogue()[name].order:
                model = model.with_effect(name, {**campaign.typical(name),
                                                 order: float(orders[0])})
    drive = campaign.driver(model)
    if not swinging(drive):
        return campaign
    turned = campaign.copied()
    for replay in turned.replays:
        if 'motor_angle' in replay.inputs:
            into_step(replay, drive)
    return turned


def once_a_turn(campaign: Campaign, fitted: Fit, sizes: Sequence[np.ndarray]) -> Campaign:
    """
    Return the campaign with recordings turned so that what swings once a turn has one phase.

    The one that is given stays as it is. ``sizes`` are what swings, log by log. Swings that the
    fitted model has stay in step.
    """
    counts = swinging(campaign.driver(fitted.model)).values()
    turned = campaign.copied()
    for replay, size in zip(turned.replays, sizes):
        if 'motor_angle' in replay.inputs:
            swing = size - gaussian_filter1d(size, _SLOW / replay.run.sample_time)
            phase = float(np.angle(np.sum(swing * np.exp(-1j * replay.inputs['motor_angle']))))
            for count in counts:
                phase = round(phase * count / (2 * np.pi)) * 2 * np.pi / count
            turn(replay, phase)
    return turned


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
        swing = column.weighed(error, False)
        swing = (swing - gaussian_filter1d(swing, SLOW / step))[column.fit]
        speed = np.abs(np.gradient(angle, replay.run.time)[column.fit])
        turn = np.exp(-1j * angle[column.fit])
        wave = turn**LOWEST
        for index, order in enumerate(orders):
            seen = order * speed < 2.0 * np.pi * _SEEN / step
            if not seen.any():
                break
            power[index] += abs(np.sum(swing[seen] * wave[seen]))**2 / len(column.fit)
            wave *= turn
    strongest = np.argsort(-power)[:2]
    return [int(orders[index]) for index in strongest
            if power[index] > _AS_STRONG * power.max()]
