# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Where the shaft stood when a recording began.

No channel tells where it stood. Swings that come back with each piston, or each turn, do: two
predictions a quarter of their period apart give the angle at which they agree best.
"""
from __future__ import annotations

import copy
from typing import TYPE_CHECKING

from hst_drive.effects import catalogue
from hst_drive.measure.readings import filled
import numpy as np
from scipy.ndimage import gaussian_filter1d

if TYPE_CHECKING:
    from hst_drive.measure.replay import Replay
    from hst_drive.model import Drive

_SLOW = 0.1     # s, standard deviation of what is taken away as no swing
_PISTONS = 7    # of a rig that does not say


def swinging(drive: Drive) -> list[str]:
    """Return the effects that are on and swing with the angle."""
    known = catalogue(everything=True)
    return [name for name in drive.effects if known[name].order]


def swings_per_turn(drive: Drive, name: str) -> float:
    """Return how often in a turn an effect swings that is on."""
    order = catalogue(everything=True)[name].order
    return drive.effects[name][order] or drive.rig.motor.pistons or _PISTONS


def start_angle(replay: Replay, drive: Drive, name: str) -> float:
    """
    Return by how much further the shaft stood at the start than the replay has it.

    Parameters
    ----------
    replay : Replay
        Must know the angle.
    drive : Drive
        Model with the effect on.
    name : str
        The effect that swings with the angle.

    Returns
    -------
    float
        rad; 0 if nothing swings.

    """
    effect, values = catalogue(everything=True)[name], drive.effects[name]
    count = swings_per_turn(drive, name)
    still, later = copy.copy(drive), copy.copy(replay)
    still.parameters, still.switches = drive.parameters.copy(), drive.switches.copy()
    still.effects = dict(drive.effects)
    still.switch_on(name, {**effect.neutral, effect.order: values[effect.order]})
    later.turn(0.5 * np.pi / count)
    none, now, then = (entry.predict(model).signals for entry, model in (
        (replay, still), (replay, drive), (later, drive)))
    normal, side = np.zeros((2, 2)), np.zeros(2)
    for signal in replay.signals:
        left, first, second = (_fast(replay, values) / replay.noise[signal] for values in (
            filled(replay.run[signal]) - none[signal], now[signal] - none[signal],
            then[signal] - none[signal]))
        normal += [[first @ first, first @ second], [first @ second, second @ second]]
        side += [first @ left, second @ left]
    if np.linalg.det(normal) <= 1e-9 * np.trace(normal)**2:
        return 0.0
    with_now, with_then = np.linalg.solve(normal, side)
    return float(np.arctan2(with_then, with_now)) / count


def _fast(replay: Replay, values: np.ndarray) -> np.ndarray:
    values = np.nan_to_num(values)
    return values - gaussian_filter1d(values, _SLOW / replay.run.sample_time)
