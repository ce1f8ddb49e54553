# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""By how much one healthy machine differs from log to log, and a model errs while it starts."""
from __future__ import annotations

from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit
from hst_drive.identify.linearised import squared_slopes
from hst_drive.measure.judged import start_of
import numpy as np

# Share of the make's tolerance, one sigma: units of a make differ by wear, by what they were made
# like and by their oil; one unit differs from itself the next day by a tenth of that.
DAY_TO_DAY = 0.1
_SHARES = np.geomspace(0.01, 1.0, 61)   # of the tolerance, that logs are asked for


def repeatability(campaign: Campaign, fitted: Fit) -> float:
    """
    Return by how much the machine differs from log to log, in tolerances.

    The likeliest standard deviation of the unknowns between the logs, from the slope of each
    log's error at what fits all. What is usual (``DAY_TO_DAY``) counts as much as one log more.
    """
    count = len(campaign.tolerances)
    residual = campaign.training(fitted.errors)
    owner = np.concatenate([np.full(len(column.fit), column.log) for column in campaign.columns])
    jacobian, blocks = fitted.jacobian[:, :count], campaign.fitted_blocks()
    chance = -0.5 * count * (np.log(_SHARES**2) + DAY_TO_DAY**2 / _SHARES**2)
    for log in range(len(campaign.replays)):
        rows = np.flatnonzero(owner == log)
        slope = jacobian[rows].T @ residual[rows]
        curvature = jacobian[rows].T @ jacobian[rows]
        noise = np.eye(count) + squared_slopes(jacobian[rows], residual[rows], blocks[rows])
        for index, share in enumerate(_SHARES):
            spreads = noise + share**2 * curvature @ curvature
            chance[index] -= 0.5 * (np.linalg.slogdet(spreads)[1]
                                    + slope @ np.linalg.solve(spreads, slope))
    logs = len(campaign.replays)
    return float(_SHARES[np.argmax(chance)]) * float(np.sqrt(logs / (logs - 1.0)))


def start_errors(campaign: Campaign, fitted: Fit) -> dict[str, float]:
    """
    Return how far a model errs while the drive starts from rest, by signal, SI.

    The largest root mean square of these logs. Empty if fewer than two start from rest: one start
    does not tell how they differ.
    """
    found: dict[str, list[float]] = {}
    for error, column in zip(fitted.errors, campaign.columns):
        replay = campaign.replays[column.log]
        rows = start_of(replay.run) & replay.counted(column.signal)
        if rows.any() and not campaign.by_balance:
            found.setdefault(column.signal, []).append(
                float(np.sqrt(np.mean(error[rows]**2))) / column.scale)
    return {name: max(errors) for name, errors in found.items() if len(errors) > 1}
