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

from hst_drive.effects import effect_of
from hst_drive.measure.readings import filled
import numpy as np
from scipy.ndimage import gaussian_filter1d

if TYPE_CHECKING:
    from hst_drive.measure.part import PartReplay
    from hst_drive.measure.replay import Replay
    from hst_drive.model import Drive
    from hst_drive.model.part import PartModel

SLOW = 0.1      # s, standard deviation of what is taken away as no swing
_ROUNDS = 3
_NEAR = 1e-3    # of a swing: nearer than that is in step
_APART = 1e-3   # of the two predictions' product: below they are the same, or opposite


def turn(replay: Replay | PartReplay, angle: float) -> None:
    """Let the shaft have stood further by an angle (rad) at the start."""
    replay.inputs = {**replay.inputs, 'motor_angle': replay.inputs['motor_angle'] + angle}


def swinging(model: Drive | PartModel) -> dict[str, float]:
    """Return the effects that are on and swing with the angle: how often in a turn, most first."""
    often = {name: _swing(model, name)[0] for name in model.effects}
    return {name: often[name] for name in sorted(often, key=lambda name: -often[name])
            if often[name]}


def _swing(model: Drive | PartModel, name: str) -> tuple[float, dict[str, float]]:
    """Return how often in a turn an effect swings, and its parameters without that."""
    effect, motor = effect_of(name), model.rig.motor
    if effect.swings is None or motor is None:
        return 0.0, {}
    return effect.swings(model.effects[name], motor.pistons)


def into_step(replay: Replay | PartReplay, model: Drive | PartModel) -> None:
    """Turn a replay so that what swings in it agrees with what swings in a model."""
    known = 0.0
    for name, count in swinging(model).items():
        angle = _start_angle(replay, model, name)
        if known:
            # Whole periods of what agrees already.
            angle = round(angle * known / (2 * np.pi)) * 2 * np.pi / known
        turn(replay, angle)
        known = count


def _start_angle(replay: Replay | PartReplay, model: Drive | PartModel, name: str) -> float:
    """Return by how much further (rad) the shaft stood at the start, by an effect that swings."""
    count, values = _swing(model, name)
    still = model.with_effect(name, values)
    trial, total = copy.copy(replay), 0.0
    for _ in range(_ROUNDS):
        # All of it may be of the second order.
        step = _towards(trial, model, still, count) or _towards(trial, model, still, 2 * count)
        turn(trial, step)
        total += step
        if abs(step) * count < 2 * np.pi * _NEAR:
            break
    return total


def _towards(replay: Replay | PartReplay, model: Drive | PartModel, still: Drive | PartModel,
             count: float) -> float:
    """Return the angle (rad) to turn by, exact for swings of one order."""
    later = copy.copy(replay)
    turn(later, 0.5 * np.pi / count)
    # Other effects may swing with the angle, too.
    (now, none), (then, none_then) = ((entry.predict(model), entry.predict(still))
                                      for entry in (replay, later))
    normal, side = np.zeros((2, 2)), np.zeros(2)
    for signal in replay.signals:
        measured = replay.run[signal]
        there = np.isfinite(measured)
        if not there.any():
            continue
        left, first, second = ((_fast(replay, values) / replay.noise[signal])[there]
                               for values in (filled(measured - none[signal]),
                                              now[signal] - none[signal],
                                              then[signal] - none_then[signal]))
        normal += [[first @ first, first @ second], [first @ second, second @ second]]
        side += [first @ left, second @ left]
    if np.linalg.det(normal) <= _APART * np.trace(normal)**2:
        return 0.0
    with_now, with_then = np.linalg.solve(normal, side)
    return float(np.arctan2(with_then, with_now)) / count


def _fast(replay: Replay | PartReplay, values: np.ndarray) -> np.ndarray:
    values = np.nan_to_num(values)
    return values - gaussian_filter1d(values, SLOW / replay.run.sample_time)
