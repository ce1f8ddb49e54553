# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which seconds of a recording a model of the whole drive is judged on.

Left out is what hangs on something that no channel shows: the moment at which the drive breaks
away from standstill, how a shaft that sticks lets go of the oil in a stop, a motion that began
before the recording did, oil that comes and goes where the inlet cavitates, a load while the
speed was not read, and what follows a command that was not read. All are told from the
measurement alone, never from the error, and together they may take ``MOST`` of a recording: what
fills more of it is how the drive runs (or what its pressure sensor says), and an error there is
an error.
"""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.channels import CHANNELS, COMMANDS
from hst_drive.measure.faults import stretches
from hst_drive.measure.run import Run
import numpy as np

MOST = 0.5              # share of a recording that may be left out
_START = 3.0            # s within which a drive may still break away from standstill
CAVITATING = 0.3e5     # Pa gauge
_AFTER = 1.0            # s that the ringing after each takes
_FIRST, _SOON = 0.05, 0.3   # s: between the first rows and those shortly after; a stop
_MOVED = 0.1            # of a reading: so much in that time and the drive was in motion before
_STANDS = 0.05          # of the usual speed
_OFF = 0.1              # of the way from its lowest to its usual value: a command that stops


class Span(NamedTuple):
    """Seconds of a recording's own time, and why they are left out."""

    start: float
    end: float
    why: str


class Judged(NamedTuple):
    """
    The samples that count, the spans that do not, and what was too long to leave out.

    ``kept`` is the share of the recording by reason.
    """

    samples: np.ndarray
    left_out: tuple[Span, ...] = ()
    kept: dict[str, float] = {}

    @property
    def seconds_left_out(self) -> float:
        """How much is left out, s."""
        return sum(span.end - span.start for span in self.left_out)


def judged(run: Run, own_starts: bool = False) -> Judged:
    """
    Return which samples of a recording of the whole drive count.

    ``own_starts``: the machine's file says how far a model errs in starts from rest.
    """
    time = run.time - run.time[0]
    out = np.zeros(len(run), dtype=bool)
    reasons, kept = {}, {}
    rest = _starting(run)
    start = 'start from rest' + " (by the machine's own in a diagnosis)" * own_starts
    for why, part in ((start, rest),
                      ('start in motion', _in_motion(run, time) & ~rest.any()),
                      ('cavitation', _cavitating(run, time)),
                      ('stop', _stopped(run, time) & ~rest),
                      *((f'{CHANNELS[name].title} missing', _without(run, time, name))
                        for name in ('motor_speed', *COMMANDS))):
        if np.mean(out | part) > MOST:
            kept[why] = float(np.mean(part))
        elif part.any():
            reasons[why] = part
            out |= part
    return Judged(~out, _spans(run.time, out, reasons), kept)


def _starting(run: Run) -> np.ndarray:
    """Tell the start: breaking away hangs on fractions of a volt and a newton metre."""
    time = run.time - run.time[0]
    if 'motor_speed' not in run:
        return np.zeros(len(time), dtype=bool)
    speed = np.abs(run['motor_speed'])
    slow = (time < _START) & (speed < 0.3 * np.nanmedian(speed))
    return time <= time[np.flatnonzero(slow)[-1]] + _AFTER if slow.any() else slow


def start_of(run: Run) -> np.ndarray:
    """
    Tell the rows of a start that other starts of the machine foretell.

    Those in which the oil has no void; none if it breaks away later than a start is looked for.
    """
    rows, pressure = _starting(run), run.channels.get('pump_outlet_pressure', np.zeros(len(run)))
    late = (rows & (run.time - run.time[0] > _START + _AFTER - _SOON)).any()
    return rows & ~(pressure < -CAVITATING) & (not late)


def _in_motion(run: Run, time: np.ndarray) -> np.ndarray:
    """Tell the start of a recording that begins at a step: its states are in no channel."""
    first = time <= max(_FIRST, time[min(2, len(time) - 1)])
    soon = (time > _SOON - _FIRST) & (time <= _SOON + _FIRST)
    for name in ('motor_speed', 'pump_outlet_pressure', 'motor_inlet_pressure'):
        values = run.channels.get(name, np.zeros(0))
        if not len(values) or not (np.isfinite(values[first]).any()
                                   and np.isfinite(values[soon]).any()):
            continue
        before, after = np.nanmean(values[first]), np.nanmean(values[soon])
        if abs(after - before) > _MOVED * np.nanmedian(np.abs(values)):
            return time <= _AFTER
    return np.zeros(len(time), dtype=bool)


def _stopped(run: Run, time: np.ndarray) -> np.ndarray:
    """Tell where the shaft stands since nothing is asked for (a stall is how the drive runs)."""
    out, off = np.zeros((2, len(time)), dtype=bool)
    if 'motor_speed' not in run:
        return out
    for name in {'pump_command', 'speed_setpoint'} & run.channels.keys():
        above = run[name] - np.nanmin(run[name])
        off |= above < _OFF * np.nanmedian(above)
    speed = np.abs(run['motor_speed'])
    for first, end in stretches(speed < _STANDS * np.nanmedian(speed)):
        if off[first:end].any() and time[end - 1] - time[first] > _SOON:
            out |= (time >= time[first]) & (time < time[end - 1] + _AFTER)
    return out


def _cavitating(run: Run, time: np.ndarray) -> np.ndarray:
    """Tell where the inlet cavitates: oil comes and goes there that no balance counts."""
    pressure = run.channels.get('pump_outlet_pressure')
    if pressure is None:
        return np.zeros(len(time), dtype=bool)
    last = np.maximum.accumulate(np.where(pressure < CAVITATING, np.arange(len(time)), -1))
    return (last >= 0) & (time - time[np.maximum(last, 0)] < _AFTER)


def _without(run: Run, time: np.ndarray, name: str) -> np.ndarray:
    """Tell where a channel that all goes by is missing for longer than can be bridged."""
    out = np.zeros(len(time), dtype=bool)
    missing = ~np.isfinite(run.channels.get(name, np.zeros(len(time))))
    for first, end in stretches(missing) if not missing.all() else ():
        if time[end - 1] - time[first] > _AFTER:
            out |= (time >= time[first]) & (time < time[end - 1] + _AFTER)
    return out


def _spans(time: np.ndarray, out: np.ndarray, reasons: dict[str, np.ndarray]) -> tuple[Span, ...]:
    return tuple(Span(
        float(time[first]), float(time[min(end, len(time) - 1)]),
        ', '.join(why for why, part in reasons.items() if part[first:end].any()))
        for first, end in stretches(out))
