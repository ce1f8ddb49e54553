# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings that tell nothing: readings that stand still, a drive at rest, rows too far apart."""
from __future__ import annotations

from typing import Mapping, NoReturn, Sequence

from hst_drive.channels import CHANNELS, LINES, PRESSURES
from hst_drive.errors import InputError
from hst_drive.measure.balances import is_part, is_table
from hst_drive.measure.judged import MOST
from hst_drive.measure.noise import steady_noise
from hst_drive.measure.run import Run
from hst_drive.rig import Rig
from hst_drive.rig.rig import CREEPING, NO_SIGN, STANDSTILL
from hst_drive.units import from_si
import numpy as np

_OF_OTHERS = (*LINES, 'charge_pressure', 'valve_command')
_SLOWEST = 0.2      # s; the drive swings about once a second, its plate moves within tenths of one
_TAIL = 99.0        # percentile of the speed, so that a spike is no motion


def refuse_still(run: Run) -> None:
    """Raise InputError if none of the sensors' readings changes."""
    readings = [_finite(values) for name, values in run.channels.items()
                if CHANNELS[name].hold == 'linear']
    # A single one that stands still may do so rightly; what it lacks is told elsewhere.
    if len(readings) > 1 and all(len(np.unique(values)) < 2 for values in readings):
        raise InputError(f'{run.source}: every reading holds one number throughout; nothing was '
                         'measured: check the sensors and the logger, or leave this log out')


def missing_rows(run: Run, rows: np.ndarray | slice = slice(None)) -> dict[str, int]:
    """Return in how many rows each command that a replay follows is missing."""
    return {name: int(np.count_nonzero(~np.isfinite(run[name][rows])))
            for name in run.channels if CHANNELS[name].hold == 'zero'}


def refuse_starved(source: str, missing: Mapping[str, int], rows: int) -> None:
    """Raise InputError if a recording lacks the better part of a command."""
    for name, count in missing.items():
        if count > MOST * rows:
            raise InputError(f'{source}: {name} is missing in {count} of {rows} rows; expected it '
                             f'in at least {100 * (1 - MOST):.0f} %: check its stamps, its '
                             'column or its topic, or give the part of the log that has it')


def too_slow(rig: Rig, run: Run) -> str:
    """Say that rows are too far apart for a drive's motion; empty if they are not."""
    # A part of the drive is judged row by row, without its motion.
    if run.sample_time <= _SLOWEST or is_part(run, rig):
        return ''
    return (f'has a row each {run.sample_time:.3g} s; expected 20 a second, at least one each '
            f'{_SLOWEST:g} s: what the drive does between rows decides. Record faster; if the '
            "times are not seconds, name their unit ('time[ms]')")


def refuse_unjudged(source: str, names: Sequence[str]) -> NoReturn:
    """Raise InputError where no row of the signals that were measured can be judged."""
    raise InputError(f'{source}: no row of {", ".join(names)} can be judged: each is missing, or '
                     f'the drive rests or creeps (below {100 * CREEPING:.2g} % of its full speed; '
                     'a part: below a twentieth of its usual speed); record it turning')


def refuse_other_circuit(rig: Rig, runs: Sequence[Run]) -> None:
    """
    Raise InputError if recordings for a whole drive with an open circuit are of another circuit.

    Such a one has a channel of other circuits, and no pressure of this one.
    """
    for run in runs:
        other = next((name for name in _OF_OTHERS if name in run), '')
        if other and rig.whole and not any(name in run for name in PRESSURES):
            raise InputError(f'{run.source}: has the channel {other}, which an open circuit has '
                             f"not; {rig.source or rig.name} is of 'circuit: open': give the rig "
                             'file of this machine (--rig), or leave the column out')


def refuse_useless(rig: Rig, runs: Sequence[Run]) -> None:
    """
    Raise InputError if recordings cannot show what a drive lacks.

    It is raised if a recording is of another circuit, if none of its readings changes
    (``refuse_still``), if most of a command is missing, if rows are too far apart for a drive's
    motion, or if the drive turns in no recording.
    """
    refuse_other_circuit(rig, runs)
    for run in runs:
        refuse_still(run)
        refuse_starved(run.source, missing_rows(run), len(run))
        if slow := too_slow(rig, run):
            raise InputError(f'{run.source}: {slow}')
    speeds = [_finite(run['motor_speed']) if 'motor_speed' in run else np.zeros(0) for run in runs]
    if all(len(speed) and np.percentile(np.abs(speed), _TAIL) <= _least_turn(rig, run, speed)
            for run, speed in zip(runs, speeds)):
        greatest = from_si(max(np.abs(speed).max() for speed in speeds), 'rpm')
        raise InputError(
            f'{", ".join(run.source for run in runs)}: the drive never turns (motor_speed is '
            f'{greatest:.2g} rpm at most); nothing can be told from a drive at rest: record it '
            'drilling, or check the speed sensor')


def _least_turn(rig: Rig, run: Run, speed: np.ndarray) -> float:
    """Return the speed (rad/s) up to which a drive is taken for one at rest."""
    if is_part(run, rig) and is_table(run):
        return 0.0      # operating points lie apart, which is no noise
    # Of a part nobody knows its full speed: it may turn as slowly as it likes.
    full = 0.0 if is_part(run, rig) else rig.full_speed
    return max(STANDSTILL * full, NO_SIGN * steady_noise(speed))


def _finite(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]
