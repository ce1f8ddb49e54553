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

from hst_drive.diagnose.campaign import Campaign
from hst_drive.diagnose.fit import Fit, SIGMAS
from hst_drive.diagnose.judge import PRACTICAL, SIGNIFICANT
from hst_drive.effects import catalogue
import numpy as np
from scipy.optimize import lsq_linear


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
    held = np.array([base.model.factors[key] / value
                     for key, value in campaign.tolerances.items()])
    room = (-SIGMAS - held - 1e-6, SIGMAS - held + 1e-6)
    places = _places(campaign)
    found = []
    for name in names:
        effect = catalogue()[name]
        unseen = campaign.out_of_reach(name)
        if unseen:
            found.append(Visibility(name, np.inf, unseen))
            continue
        size = effect.parameters[0]
        model = base.model.with_effect(name, campaign.typical(name))
        move = campaign.training(campaign.errors(model, to_fit=True)) - start
        smallest = abs(size.typical) * _smallest(move, factors, normal, room, places)
        limit = max(abs(size.low), abs(size.high))
        reason = '' if smallest <= limit else \
            'these logs do not exercise it beyond what the unit may differ'
        found.append(Visibility(name, float(smallest), reason))
    return found


def _smallest(move: np.ndarray, factors: np.ndarray, normal: np.ndarray,
              room: tuple[np.ndarray, np.ndarray], places) -> float:
    """
    Return the factor on ``move`` from which the effect is worth naming.

    The unit's factors take up what they can, but not beyond their limits.
    """
    side = factors.T @ move
    root = np.linalg.cholesky(normal).T
    target = np.linalg.solve(root.T, side)
    size = 100.0
    for _ in range(24):
        share = lsq_linear(root, -size * target, room).x if len(side) else side
        left = size * move + factors @ share
        if min(_needed(left[place] / thin, blocks) for place, thin, blocks in places) > 1:
            break
        size /= 1.5
    return size * 1.5 if size < 100.0 else np.inf


def _places(campaign: Campaign) -> list[tuple[np.ndarray, float, int]]:
    """Return, by signal, its rows in the training vector, their weight, and how many blocks."""
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
        seconds = len(rows) * campaign.replays[0].run.sample_time
        found.append((rows, thin[name], int(seconds / campaign.block)))
    return found


def _needed(move: np.ndarray, blocks: int) -> float:
    """Return the squared factor on ``move`` at which it would be worth naming."""
    power = float(np.mean(move**2))
    # Mean squares of blocks scatter by about their own size where errors are correlated.
    return max(PRACTICAL, SIGNIFICANT * 0.7 / np.sqrt(max(blocks, 1))) / power if power else np.inf
