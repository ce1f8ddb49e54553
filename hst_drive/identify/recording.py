# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a recording leaves open, and no physics explains: when a command stepped, zeros, scatter.

A recorder that reads commands once a row shows a step up to a row late, each by another part of
it. What all have in common is in the lags of the actuators. A sensor's zero is known no better
than it scatters. Its scatter may grow with what it reads; but no two rows are alike in it.
"""
from __future__ import annotations

from typing import Sequence

from hst_drive.identify.campaign import Campaign
import numpy as np

_LAGS = 0.5     # s: what a model lacks shows in one of them


def in_time(campaign: Campaign, errors: Sequence[np.ndarray]) -> list[np.ndarray]:
    """
    Return errors as they are if each step came when it fits them best, within half a row.

    The errors are those of ``Campaign.errors``. A part's are left as they are.
    """
    errors = list(errors)
    for log, replay in enumerate([] if campaign.by_balance else campaign.replays):
        columns = [(index, column) for index, column in enumerate(campaign.columns)
                   if column.log == log]
        for starts, moved in replay.half_a_row_early(campaign.drive):
            step = np.searchsorted(starts, np.arange(len(replay.run)), side='right')
            shifts = {index: np.nan_to_num(moved[column.signal]) * column.scale
                      for index, column in columns}
            along, square = np.zeros((2, len(starts) + 1))
            for index, column in columns:
                rows = column.rows(None)
                weighted = (shifts[index] * column.weight**2)[rows]
                along += np.bincount(step[rows], weighted * errors[index][rows], len(along))
                square += np.bincount(step[rows], weighted * shifts[index][rows], len(along))
            early = np.clip(-along / np.maximum(square, 1e-30), -1.0, 1.0)
            early[0] = 0.0      # before the first step
            for index, shift in shifts.items():
                errors[index] = errors[index] + early[step] * shift
    return errors


def at_zero(campaign: Campaign, errors: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return errors less what is off by the same throughout, within the noise of each sensor."""
    errors = list(errors)
    for name in campaign.signals:
        own = [(index, column, column.rows(None)) for index, column in enumerate(campaign.columns)
               if column.signal == name]
        total = sum(float(np.sum((errors[index] * column.weight**2)[rows]) / column.scale)
                    for index, column, rows in own)
        count = sum(float(np.sum(column.weight[rows]**2)) for _, column, rows in own)
        noise = min(campaign.replays[column.log].noise[name] for _, column, _ in own)
        off = float(np.clip(total / max(count, 1e-30), -noise, noise))
        for index, column, _ in own:
            errors[index] = errors[index] - off * column.scale
    return errors


def lasting(campaign: Campaign, errors: Sequence[np.ndarray], name: str,
            held_out: bool | None) -> float:
    """
    Return the part of a signal's mean square error that rows without common noise share.

    The largest product of errors a lag apart, mean over the rows, from where they share no noise
    (``apart``) half a second on. White noise has none, a constant error all of it. The answer is
    in squared floors; it is infinite for operating points, which have no order. The rows are those
    to judge on where ``held_out`` is True and those to fit on where it is False; None: both.
    """
    total, count = 0.0, 0
    for error, column in zip(errors, campaign.columns):
        rows = column.rows(held_out)
        if column.signal != name or not len(rows):
            continue
        replay = campaign.replays[column.log]
        first = replay.apart(name)
        if not first:
            return np.inf
        own, counted = column.weighed(error, held_out), np.zeros(len(error))
        counted[rows] = 1.0
        last = first + max(int(_LAGS / replay.run.sample_time), 1)
        found = [abs(own[lag:] @ own[:-lag]) / pairs for lag in range(first, last)
                 if (pairs := counted[lag:] @ counted[:-lag])]
        # Where no two rows lie so far apart, nothing tells scatter from physics.
        total += len(rows) * max(found, default=own @ own / len(rows))
        count += len(rows)
    return total / max(count, 1)
