# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A channel whose sign is swapped, told by the balances of a part.

Turned round, such a channel makes ideal and measured values agree; and what is lost, brakes: an
ideal drive never gives more than it takes. So the balances with a torque are judged with friction
of either sort, which may not be negative.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Iterator

from hst_drive.channels import LINES, PRESSURES, TORQUES
from hst_drive.measure.circuit import replay_of
from hst_drive.measure.run import Run
from hst_drive.model.circuit_model import part_model
from hst_drive.model.part import PartModel
from hst_drive.rig import Rig
import numpy as np
from scipy.optimize import lsq_linear

_SIGNED = ('motor_speed', *TORQUES, 'motor_inlet_flow', 'pump_speed', 'pump_displacement',
           'pump_torque', 'pump_power')
_COMMANDS = ('pump_command', 'valve_command')
_SPEED, _OUTLET = _SIGNED[0], 'motor_outlet_pressure'
_LOSSES = {'hydromotor torque': -1.0, 'mass': 1.0}  # with what sign friction enters a balance
_SLOWER = 0.02      # s: signs show in what is slow
_TOLD = 0.05        # of a signal, rms: an error below tells nothing
_MENDED = 0.7       # of the error, rms, may stay with the right sign: half of its square
_ALIKE = 1.5        # times the least error: channels between which these logs cannot tell
_MOST = 0.5         # of a torque: no machine loses more
_OFF = 0.1          # of a reading: a sensor that is off by more is refused by the other sensors
_BRAKES = 0.98      # of the rows


def swapped(rig: Rig, run: Run) -> str:
    """Return a line for the channel whose sign contradicts the others; empty without one."""
    model, run = part_model(rig), run.slower(_SLOWER)
    before = _left(run, model)
    if before < _TOLD:
        return ''
    left = {name: _left(turned, model) for name, turned in _turned(run)}
    least = min(left.values(), default=np.inf)
    if least > _MENDED * before or [*left] == [_SPEED]:
        return ''
    alike = [name for name, error in left.items() if error < _ALIKE * least]
    signs = [name for name in alike if name in run]
    exchanged = [name for name in alike if name not in run]
    if alike == [_SPEED] and not _never_drives(run) and _left(
            next(_turned(run))[1], model, True) > _MENDED * _left(run, model, True):
        return ''       # a torque or a pressure that is a little off does that, too
    if not signs:
        # Without a torque an exchange of lines mends an error of size as well.
        return '' if least > _OFF and _OUTLET not in run else (
            f'{exchanged[0]} seem to be exchanged; exchange them in the channel map')
    return (f'{" or ".join(signs)} seems to have the wrong sign; add scale: -1 to it in the '
            f'channel map{"".join(f"; or {pair} are exchanged" for pair in exchanged)}')


def _turned(run: Run) -> Iterator[tuple[str, Run]]:
    """Yield the recording with one channel turned round, or two exchanged, by what was done."""
    for name in (*_SIGNED, *_COMMANDS, *(PRESSURES if _OUTLET not in run else ())):
        if name in run:
            yield name, replace(run, channels={**run.channels, name: -run[name]})
    for one, other in (LINES, *((name, _OUTLET) for name in PRESSURES)):
        if one in run and other in run:
            yield f'{one} and {other}', replace(run, channels={
                **run.channels, one: run[other], other: run[one]})


def _never_drives(run: Run) -> bool:
    torque = next((run[name] for name in TORQUES if name in run), np.zeros(len(run)))
    return bool(np.mean(torque * run[_SPEED] < 0) > _BRAKES)


def _left(run: Run, model: PartModel, faulty: bool = False) -> float:
    """
    Return what the balances leave of their signals, rms, the worst of them.

    ``faulty``: with the zero and the scale of a torque free.
    """
    replay = replay_of(run, model)
    predicted, worst = replay.predict(model), 0.0
    for name, balance in replay.balances.items():
        rows = replay.counted(name)
        size = float(np.sqrt(np.mean(replay.run[name][rows]**2))) if rows.any() else 0.0
        if name not in _SIGNED or not size:
            continue
        ideal = predicted[name][rows] / size
        error = replay.run[name][rows] / size - ideal
        if balance.name in _LOSSES:
            speed = np.nan_to_num(run[_SPEED][rows])
            brakes = _LOSSES[balance.name] * np.sign(speed)
            columns = np.column_stack([brakes * np.abs(ideal), brakes, brakes * np.abs(speed),
                                       ideal, np.ones(len(ideal)), error])
            high = [_MOST, np.inf, np.inf, *([_OFF, np.inf] if faulty else [1e-9, 1e-9])]
            low = [0.0, 0.0, 0.0, -high[3], -high[4]]
            # The triangle of the QR decomposition is all that the least squares need.
            triangle = np.linalg.qr(columns, mode='r')
            found = lsq_linear(triangle[:, :-1], triangle[:, -1], (low, high), 'bvls')
            least = float(np.sqrt(2.0 * found.cost / len(error)))
        else:
            least = float(np.sqrt(np.mean(error**2)))
        worst = max(worst, least)
    return worst
