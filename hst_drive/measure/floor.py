# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The error that a perfect model would still show in a replay."""
from __future__ import annotations

from typing import TYPE_CHECKING

from hst_drive.measure.balances import BALANCES
from hst_drive.measure.noise import Coloured, estimate_coloured, steady_noise
from hst_drive.measure.readings import filled
from hst_drive.measure.recorded_load import DRAWS
from hst_drive.measure.run import BLOCK, usual_size
from hst_drive.model import Drive
from hst_drive.model.part import PartModel
import numpy as np

if TYPE_CHECKING:
    from hst_drive.measure.part import PartReplay
    from hst_drive.measure.replay import Replay

_NOT_NOISE = 0.8        # of the noise that was expected: an error that shows less has less


def part_floor(replay: PartReplay, model: PartModel) -> dict[str, float]:
    """Return the rmse, by signal, that the best model of a part would show."""
    random, base = np.random.default_rng(0), replay.predict(model)
    drawn = {name: [] for name in replay.signals}
    for _ in range(DRAWS):
        inputs, own = replay.draw_noise(random)
        moved = replay.predict(model, inputs)
        for name in replay.signals:
            drawn[name].append((moved[name] - base[name] - own[name])[replay.counted(name)])
    power = {name: float(np.mean(np.square(shifts))) if np.size(shifts) else 0.0
             for name, shifts in drawn.items()}
    if not replay.static:
        # In slow rows motion looks like noise; it is in no error where all signals follow it.
        for name, shifts in drawn.items():
            seen = steady_noise((base[name] - replay.run[name])[replay.counted(name)])
            expected = float(np.mean([steady_noise(entry) for entry in shifts]))
            if 0.0 < seen < _NOT_NOISE * expected:
                power[name] *= (seen / expected)**2
    # No judged row, no floor: the noise stands in, since errors are divided by it.
    return {name: float(np.hypot(np.sqrt(value), replay.sheet_error(name)))
            or replay.noise[name] for name, value in power.items()}


def replay_floor(replay: Replay, drive: Drive,
                 count: np.ndarray | None = None) -> dict[str, float]:
    """
    Return the rmse, by signal, that a perfect model would still show.

    Sensor noise, what no sheet tells of a leakage, and what the part of the load torque that the
    smoothing misses, and commands that no row shows, do to the replay: draws of them are replayed.
    Where no torque is measured, what is coloured counts as the work of the load.

    Parameters
    ----------
    replay : Replay
        The recording.
    drive : Drive
        The model.
    count : ndarray of bool, shape (n,), optional
        Which samples are judged, all unless given.

    """
    power = {name: replay.noise[name]**2 for name in replay.signals}
    drain = BALANCES['case drain']
    if drain.signal in power:
        power[drain.signal] += (drain.untold * usual_size(replay.run[drain.signal]))**2
    added: list[dict[str, float]] = []
    if replay.can_correct:
        misread = replay.misread(drive)
        power[replay.torque] = misread.noise_std**2
        if misread.std > 0:
            added += [_of_the_load(replay, drive, count), {replay.torque: misread.std**2}]
    else:
        added.append({name: rough.std**2 for name, rough in of_rough_load(replay, drive).items()})
    if any(steps.guessed for steps in replay.steps.values()):
        added.append(_of_guesses(replay, drive))
    for entry in added:
        for name, value in entry.items():
            power[name] += value
    return {name: float(np.sqrt(value)) for name, value in power.items()}


def of_rough_load(replay: Replay, drive: Drive) -> dict[str, Coloured]:
    """
    Return what is coloured in the signals that a rough load moves.

    In the torque if it was read; else in each signal what varies faster than about a second.
    """
    if replay.can_correct:
        return {replay.torque: replay.roughness}
    given, found = replay.predict(drive), {}
    for name in replay.signals:
        rest = filled(replay.run[name] - given[name])
        found[name] = estimate_coloured(replay.run.time, rest - replay.readings.slow(rest),
                                        replay.noise[name])
    return found


def _of_the_load(replay: Replay, drive: Drive, count: np.ndarray | None) -> dict[str, float]:
    """Return the squared error, by signal, that what the smoothing misses of the load makes."""
    base, part = replay.predict(drive), slice(None) if count is None else count
    power = {name: 0.0 for name in replay.signals if name != replay.torque}
    for missed in replay.missed(drive, np.random.default_rng(0)):
        moved = replay.predict(drive, missed)
        for name in power:
            power[name] += float(np.nanmean((moved[name] - base[name])[part]**2)) / replay.draws
    return power


def _of_guesses(replay: Replay, drive: Drive) -> dict[str, float]:
    """Return the squared error, by signal, that commands make which no row shows."""
    base = replay.predict(drive)
    random = np.random.default_rng(0)
    time = replay.run.time
    # Only blocks with rows: a record may pause for longer than a block.
    block = np.unique(((time - time[0]) / BLOCK).astype(int), return_inverse=True)[1]
    count = np.bincount(block)
    power = dict.fromkeys(base, 0.0)
    for _ in range(replay.draws):
        moved = replay.predict(drive, commands={
            name: steps.draw(random) for name, steps in replay.steps.items()})
        for name in base:
            shift = np.nan_to_num(moved[name] - base[name])
            # One large step that no row shows is an event, not a floor for the whole log.
            power[name] += float(np.median(np.bincount(block, shift**2) / count)) / replay.draws
    return power
