# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A model beside measurements: errors by signal and where they sit."""
from __future__ import annotations

from dataclasses import replace
import math
from typing import NamedTuple, Sequence

from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.measure.balances import is_part
from hst_drive.measure.circuit import replay_of
from hst_drive.measure.closed_loop import closed_loop_signals, command_floor, command_noise
from hst_drive.measure.errors import ErrorSummary, Moments, summarise
from hst_drive.measure.judged import Judged, judged
from hst_drive.measure.part import PartReplay
from hst_drive.measure.readings import best_delay, LONGEST_DELAY
from hst_drive.measure.replay import Replay
from hst_drive.measure.run import Run
from hst_drive.measure.useful import (
    missing_rows, refuse_other_circuit, refuse_starved, refuse_still, refuse_unjudged)
from hst_drive.measure.where import operating_variables, Region, where
from hst_drive.model import Drive
from hst_drive.model.circuit_model import part_model, refuse_placeless
from hst_drive.model.part import PartModel
from hst_drive.rig import Rig
import numpy as np

_MENDED = 0.3           # of the squared error may stay if clocks are to blame


class Sections(NamedTuple):
    """
    How a long log was cut: so many sections of ``seconds``, each judged without its overlap.

    ``before`` and ``after`` (s) are replayed with each but not judged; ``samples`` counts those
    of the log.
    """

    count: int
    seconds: float
    before: float
    after: float
    samples: int
    sample_time: float


class LogComparison(NamedTuple):
    """
    One log: the recording, what the model gives, and errors.

    ``delays`` is how late each measured signal was found, s; ``shift`` the delay that all have in
    common, by which the commands were moved; ``judged`` says which samples the errors count.
    Of a log that was compared in ``sections``, ``run`` and ``model`` hold a part of the samples;
    of the signals ``unjudged`` no row can be judged.
    """

    run: Run
    model: dict[str, np.ndarray]
    signals: dict[str, ErrorSummary]
    delays: dict[str, float]
    shift: float
    judged: Judged
    sections: Sections | None = None
    unjudged: tuple[str, ...] = ()

    @property
    def sample_time(self) -> float:
        """Time between the samples of the recording, s."""
        return self.sections.sample_time if self.sections else self.run.sample_time

    def measured(self, name: str) -> np.ndarray:
        """Return a measured signal, NaN where it is not judged."""
        return np.where(self.judged.samples, self.run[name], np.nan)


class Comparison(NamedTuple):
    """All logs together and each for itself."""

    rig: str
    closed_loop: bool
    signals: dict[str, ErrorSummary]
    where: list[Region]
    logs: list[LogComparison]


def model_of(rig: Rig, runs: Sequence[Run]) -> Drive | PartModel:
    """
    Return the model that the logs can be compared with: the whole drive or a part of it.

    Raises
    ------
    InputError
        If a log is of another circuit, or an effect of the rig has no place in its own.

    """
    refuse_other_circuit(rig, runs)
    part = part_model(rig)
    refuse_placeless(part, rig.effects)
    return part if any(is_part(run, rig) for run in runs) else Drive(rig)


def compare(drive: Drive | PartModel, runs: Sequence[Run], *,
            closed_loop: bool = False, all_seconds: bool = False) -> Comparison:
    """
    Replay recordings through a model and judge it.

    Parameters
    ----------
    drive : Drive or PartModel
        The model (``model_of``).
    runs : sequence of Run
        Recordings of what it models.
    closed_loop : bool
        Let the rig's PI controller command the pump instead of the recorded command; the
        command is then compared, too. Needs 'speed_setpoint'.
    all_seconds : bool
        Judge those seconds, too, that a diagnosis leaves out (``judged``).

    Raises
    ------
    InputError
        If a recording lacks the channels that a replay needs or most of a command, or none of its
        readings changes.

    """
    logs = []
    if closed_loop and isinstance(drive, PartModel):
        raise InputError(f'{runs[0].source}: is a log of a part of the drive; leave --closed-loop '
                         'out')
    for run in runs:
        refuse_starved(run.source, missing_rows(run), len(run))
        logs.append(compare_log(drive, run, closed_loop=closed_loop, all_seconds=all_seconds))
    return together(drive.rig.name, logs, closed_loop=closed_loop)


def together(rig: str, logs: Sequence[LogComparison], *, closed_loop: bool = False) -> Comparison:
    """Judge logs, each of which was compared with a model of the rig of that name, as one."""
    variables = [operating_variables(log.run) for log in logs]
    signals = pooled(logs)
    shared = set.intersection(*(set(entry) for entry in variables))
    everywhere = [name for name in signals if all(name in log.signals for log in logs)]
    regions = where(
        {name: [log.model[name] - log.measured(name) for log in logs] for name in everywhere},
        {name: [entry[name] for entry in variables] for name in variables[0] if name in shared},
        {name: signals[name].floor for name in everywhere})
    return Comparison(rig, closed_loop, signals, regions, list(logs))


def pooled(logs: Sequence[LogComparison]) -> dict[str, ErrorSummary]:
    """Return the errors of logs as if they were one, signal by signal."""
    found: dict[str, Moments] = {}
    for log in logs:
        for name, entry in log.signals.items():
            found.setdefault(name, Moments()).add(
                log.model[name], log.measured(name), entry.noise_std, entry.floor)
    return {name: entry.summary(CHANNELS[name].unit) for name, entry in found.items()}


def compare_log(drive: Drive | PartModel, run: Run, *, closed_loop: bool = False,
                all_seconds: bool = False) -> LogComparison:
    """Do what ``compare`` does with one recording, but for the regions of the error."""
    refuse_still(run)
    bench = isinstance(drive, PartModel) and 'pump_command' not in run
    unit = drive.rig.fingerprint
    count = Judged(np.ones(len(run), dtype=bool)) if all_seconds or bench else judged(
        run, bool(unit and unit.starts))
    replay, shift, model, floor = _aligned(run, drive, count)
    run = replay.run
    noise = dict(replay.noise)
    if closed_loop:
        torque = {replay.torque: model[replay.torque]} if replay.can_correct else {}
        model = {**closed_loop_signals(drive, run, replay), **torque}
        noise['pump_command'] = command_noise(run['pump_command'])
        floor['pump_command'] = command_floor(drive, run, noise['pump_command'],
                                              floor.get('motor_speed', 0.0))
    log = LogComparison(run, model, {}, {}, shift, count)
    unjudged = tuple(name for name in model
                     if not np.isfinite(model[name] + log.measured(name)).any())
    model = {name: values for name, values in model.items() if name not in unjudged}
    if not model:
        refuse_unjudged(run.source, unjudged)
    log = log._replace(model=model, unjudged=unjudged)
    delays = {name: _delay(run.time, model[name], log.measured(name), floor[name])
              for name in model}
    signals = {name: summarise(model[name], log.measured(name), CHANNELS[name].unit,
                               noise[name], floor[name]) for name in model}
    return log._replace(signals=signals, delays=delays)


def _delay(time: np.ndarray, model: np.ndarray, measured: np.ndarray, floor: float) -> float:
    """Return by how much (s) the measurement lags behind the model; 0 where it cannot be told."""
    delay = best_delay(time, model, measured, floor)
    if not delay:
        return 0.0
    slope = np.gradient(model, time)
    valid = np.isfinite(slope + measured)
    before, after = (max(float(np.nanvar(np.interp(time - late, time, model) - measured)),
                         floor**2) for late in (0.0, delay))
    deviation = math.sqrt(after / valid.sum()) / float(slope[valid].std())
    # Residuals are correlated over some ten samples: ask for a clear sign. What a delay does not
    # mend is another error.
    mends = after - floor**2 <= _MENDED * (before - floor**2)
    return delay if mends and 10 * deviation < abs(delay) < LONGEST_DELAY else 0.0


class _Aligned(NamedTuple):
    """A replay, the delay (s) by which its commands were moved, its signals and their floors."""

    replay: Replay | PartReplay
    shift: float
    model: dict[str, np.ndarray]
    floor: dict[str, float]


def _aligned(run: Run, drive: Drive | PartModel, count: Judged) -> _Aligned:
    """
    Return the replay of a log with its commands moved to the stamps of the readings.

    The stamps of the readings stay. What moves with the commands moves the errors: look again.
    """
    first = last = _replayed(run, drive, count, 0.0)
    if isinstance(drive, PartModel):
        return first
    measured = {name: np.where(count.samples, run[name], np.nan) for name in first.model
                if np.isfinite(first.model[name])[count.samples & np.isfinite(run[name])].any()}

    def power(entry: _Aligned) -> float:
        return sum(float(np.nanmean((entry.model[name] - measured[name])**2))
                   / entry.floor[name]**2 for name in measured)

    for _ in range(4):
        found = _common({name: _delay(run.time, last.model[name], measured[name],
                                      last.floor[name]) for name in measured})
        if abs(found) < 0.3 * run.sample_time:
            break
        total = last.shift + found
        earlier = np.clip(np.searchsorted(run.time, run.time - total + 0.5 * run.sample_time,
                                          side='right') - 1, 0, len(run) - 1)
        last = _replayed(replace(run, channels={
            name: values[earlier] if CHANNELS[name].hold == 'zero' else values
            for name, values in run.channels.items()}), drive, count, total)
    # Missing physics looks like a delay, too, but a delay does not mend that.
    return last if power(last) < _MENDED * power(first) else first


def _replayed(run: Run, drive: Drive | PartModel, count: Judged, shift: float) -> _Aligned:
    replay = replay_of(run, drive)
    # A simulation goes on where nothing was read; a balance may give anything there.
    gaps = {name: isinstance(drive, Drive) & ~np.isfinite(run[name]) for name in replay.signals}
    model = {name: np.where(replay.counted(name) | gaps[name], values, np.nan)
             for name, values in replay.predict(drive).items()}
    return _Aligned(replay, shift, model, replay.floor(drive, count.samples))


def _common(delays: dict[str, float]) -> float:
    """
    Return the delay that most signals share, s: clocks of commands and readings that differ.

    One late signal alone is its sensor's affair, and an error that only looks like a delay
    differs from signal to signal.
    """
    values = np.array(list(delays.values()))
    if np.count_nonzero(values) < 3:
        return 0.0
    found = values[values != 0]
    middle = float(np.median(found))
    alike = np.abs(found - middle) < 0.25 * abs(middle)
    return middle if alike.sum() >= 3 else 0.0
