# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Whole records behind what has a memory of its own: a lag, a play."""
from __future__ import annotations

import math

from hst_drive.model.kernel_template import played
import numpy as np


def behind_play(command: np.ndarray, half: float, softness: float, start: float) -> np.ndarray:
    """Return a command behind a play of twice ``half``; it starts as near as that lets it."""
    behind, last = np.empty(len(command)), command[0]
    inside = min(max(start, last - half), last + half)
    for k, value in enumerate(command):
        inside = played(inside, last, value, half, softness)
        behind[k], last = inside, value
    return behind


def held_share(series_lag, lag, interval):
    """Return which share of what a lag is ahead by moves the next one as far, if it is held."""
    if abs(lag - series_lag) < 1e-3 * lag:
        series_lag = 0.998 * lag    # where both are alike the formula is 0 over 0
    kept, gone = math.exp(-interval / series_lag), math.exp(-interval / lag)
    return series_lag / (lag - series_lag) * (gone - kept) / (1.0 - gone)


def follow(time: np.ndarray, target: np.ndarray, lag: float, rate: float = math.inf,
           back_rate: float = math.inf, back_lag: float | None = None,
           start: float | None = None) -> np.ndarray:
    """
    Return what follows a target with a first-order lag, its speed limited.

    Parameters
    ----------
    time : ndarray, shape (n,)
        s.
    target : ndarray, shape (n,)
        Any unit; held between samples.
    lag, back_lag : float
        s, upwards and downwards; by default the same.
    rate, back_rate : float
        Most that it rises and falls, units of the target per second.
    start : float, optional
        Where it is first; by default on its target.

    """
    start = target[0] if start is None else start
    steps = np.append(np.diff(time), 0.0)
    up, down = (-np.expm1(-steps / entry) for entry in (
        lag, lag if back_lag is None else back_lag))
    if rate == back_rate == math.inf and len(time) > 1:
        from scipy.linalg import solve_banded     # late: nodes start without it

        # Linear, but for the lag of each step: a system of equations. Each solution tells the
        # right lag of at least one more step.
        rising = np.ones(len(time), dtype=bool)
        for _ in time:
            share = np.where(rising, up, down)
            out = solve_banded((1, 0), [np.ones(len(time)), share - 1.0], np.append(
                start, share[:-1] * target[:-1]), check_finite=False)
            before, rising = rising, target > out
            if back_lag in (None, lag) or np.array_equal(before, rising):
                break
        return out
    out, value = np.empty(len(time)), start
    for k, goal in enumerate(target):
        out[k] = value
        move = (goal - value) * (up[k] if goal > value else down[k])
        value += min(max(move, -back_rate * steps[k]), rate * steps[k]) if move else 0.0
    return out
