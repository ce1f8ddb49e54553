# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What these logs can show at all.

An effect that the channels cannot show, or that the log never exercised, is 'not observable
here', not absent; and where nothing is found, the smallest size that would have been found
says what 'none' is worth.
"""
from __future__ import annotations

from typing import NamedTuple, Sequence

from hst_drive.effects import catalogue
from hst_drive.effects.base import arguments
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit
from hst_drive.identify.judge import PRACTICAL, SIGNIFICANT
from hst_drive.identify.unknowns import SIGMAS, Unknowns
import numpy as np
from scipy.optimize import lsq_linear

# What an effect may read that a replay takes from a recording: the channel that it comes from.
_FROM = {'oil_temperature': 'oil_temperature', 'viscosity_ratio': 'oil_temperature',
         'motor_angle': 'motor_speed'}


class Visibility(NamedTuple):
    """
    How well an effect shows in a campaign.

    Attributes
    ----------
    id : str
        The effect.
    smallest : float
        Size (first parameter, SI) that these logs would have shown; inf if none.
    reason : str
        Why it cannot be seen; empty if it can.

    """

    id: str
    smallest: float
    reason: str


def visibility(campaign: Campaign, base: Fit, names: Sequence[str]) -> list[Visibility]:
    """
    Judge how large each effect would have to be to be found.

    Parameters
    ----------
    campaign : Campaign
        The recordings.
    base : Fit
        Calibrated model with its Jacobian; an effect that the unit's tolerances can imitate
        does not show.
    names : sequence of str
        Effects.

    """
    start = campaign.training(base.errors)
    factors = base.jacobian[:, :len(campaign.tolerances)]
    normal = factors.T @ factors + np.eye(factors.shape[1])
    unknowns = Unknowns(campaign, base.model)
    held = unknowns.pack(base.model)[:unknowns.factors]
    room = (-SIGMAS - held - 1e-6, SIGMAS - held + 1e-6)
    grams = [(rows, factors[rows].T @ factors[rows], need)
             for rows, need in _places(campaign)]
    found = []
    for name in names:
        effect = catalogue()[name]
        unseen = campaign.out_of_reach(name)
        if unseen:
            found.append(Visibility(name, np.inf, unseen))
            continue
        size = campaign.parameter(name, effect.parameters[0].name)
        model = base.model.with_effect(name, campaign.typical(name))
        move = campaign.training(campaign.errors(model, to_fit=True)) - start
        smallest = abs(size.typical) * _smallest(move, factors, normal, room, grams)
        limit = max(abs(size.low), abs(size.high))
        reason = '' if smallest <= limit else unread(campaign, name) or \
            'in these logs it does no more than the tolerances of the unit allow'
        found.append(Visibility(name, float(smallest), reason))
    return found


def unread(campaign: Campaign, name: str) -> str:
    """Say which channel an effect follows that no log has; empty if there is none."""
    missing = sorted({_FROM[entry] for _, function in catalogue()[name].terms
                      for entry in arguments(function) if entry in _FROM and not any(
                          _FROM[entry] in replay.run for replay in campaign.replays)})
    return f'needs the channel {" and ".join(missing)}' if missing else ''


def _smallest(move: np.ndarray, factors: np.ndarray, normal: np.ndarray,
              room: tuple[np.ndarray, np.ndarray],
              grams: list[tuple[np.ndarray, np.ndarray, float]]) -> float:
    """
    Return the factor on ``move`` from which the effect is worth naming.

    The unit's factors take up what they can, but not beyond their limits. All is quadratic in
    the factors, so that the long vectors are needed once.
    """
    sides = [(factors[rows].T @ move[rows], float(move[rows] @ move[rows]))
             for rows, _, _ in grams]
    root = np.linalg.cholesky(normal).T
    target = np.linalg.solve(root.T, factors.T @ move)

    def shows(size: float) -> bool:
        share = lsq_linear(root, -size * target, room, method='bvls').x if len(target) else target
        return any(share @ gram @ share + 2 * size * side @ share + size**2 * power > need
                   for (_, gram, need), (side, power) in zip(grams, sides))

    low, high = np.log(1e-4), np.log(1e3)
    if not shows(np.exp(high)):
        return np.inf
    for _ in range(9):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if shows(np.exp(middle)) else (middle, high)
    return float(np.exp(high))


def _places(campaign: Campaign) -> list[tuple[np.ndarray, float]]:
    """Return, by signal, its rows in the training vector, and the power worth naming there."""
    places: dict[str, list[np.ndarray]] = {}
    thin: dict[str, float] = {}
    start = 0
    for column in campaign.columns:
        places.setdefault(column.signal, []).append(np.arange(start, start + len(column.fit)))
        thin[column.signal] = campaign.thinning(column)
        start += len(column.fit)
    found = []
    for name, parts in places.items():
        rows = np.concatenate(parts)
        blocks = max(len(rows) * campaign.replays[0].run.sample_time / campaign.block, 1.0)
        # Mean squares of blocks scatter by about their own size where errors are correlated.
        worth = max(PRACTICAL, SIGNIFICANT * 0.7 / np.sqrt(blocks))
        found.append((rows, worth * thin[name]**2 * len(rows)))
    return found
