# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The samples of a campaign: one column per signal and log, to fit on and to judge on."""
from __future__ import annotations

from typing import Mapping, NamedTuple, Sequence

from hst_drive.measure.readings import filled
import numpy as np
from scipy.ndimage import gaussian_filter1d


class Column(NamedTuple):
    """
    One signal of one log.

    ``fit`` and ``judge`` are the samples for either; ``scale`` is one over the floor; ``weight``
    is below 1 where time stamps matter, since the signal moves fast, where no formula is sure, or
    where rock is rougher than usual.
    """

    log: int
    signal: str
    fit: np.ndarray
    judge: np.ndarray
    scale: float
    weight: np.ndarray

    def rows(self, held_out: bool | None) -> np.ndarray:
        """Return the samples to judge on or to fit on; None: both."""
        if held_out is None:
            return np.concatenate([self.fit, self.judge])
        return self.judge if held_out else self.fit

    def weighed(self, error: np.ndarray, held_out: bool | None = None) -> np.ndarray:
        """Return a weighted error, with 0 where it is not judged (or not fitted)."""
        found, rows = np.zeros(len(error)), self.rows(held_out)
        found[rows] = error[rows] * self.weight[rows]
        return found


def columns(replays: Sequence, floors: Sequence[Mapping[str, float]],
            splits: Sequence[np.ndarray]) -> list[Column]:
    """
    Return the columns of all logs in turn.

    Parameters
    ----------
    replays : sequence of Replay or PartReplay
        The logs.
    floors : sequence of dict
        What a perfect model would show, by signal, SI.
    splits : sequence of ndarray
        +1 for samples to fit on, -1 for samples to judge on, 0 for neither.

    """
    found = []
    for index, (replay, part) in enumerate(zip(replays, splits)):
        time_std = np.hypot(replay.stamp_std, replay.command_time_std)
        for name in replay.signals:
            valid, floor = replay.counted(name), floors[index][name]
            known = filled(replay.run[name]) if valid.any() else np.zeros(len(valid))
            moving = np.gradient(gaussian_filter1d(known, 1.5), replay.run.time)
            extra = np.hypot(time_std * moving, replay.extra_std.get(name, 0.0)) / floor
            weight = 1.0 / np.sqrt(1.0 + extra**2)
            found.append(Column(index, name, np.flatnonzero(valid & (part > 0)),
                                np.flatnonzero(valid & (part < 0)), 1.0 / floor, weight))
    return found
