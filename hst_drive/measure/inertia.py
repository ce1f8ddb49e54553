# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The inertia of a hydromotor's shaft where the rig file of a part gives none.

A torque that goes with the acceleration is no loss: without the inertia it would be told as one,
or as a sensor that is off. So it is found beside whatever losses there may be.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Mapping, Sequence

from hst_drive.measure.balances import closed, is_table
from hst_drive.measure.part import PartReplay
from hst_drive.measure.run import Run
from hst_drive.model.part import PartModel
from hst_drive.rig import Rig
from hst_drive.rig.adopted import INERTIA_KEY
from hst_drive.rig.rig import OPEN
import numpy as np

INERTIA = 'motor.inertia'
_ASKED = 0.1        # of the squared error that losses leave must go with the acceleration
_SIGMA = 0.3        # how well it is known then, relative: losses may have other forms


def with_found_inertia(rig: Rig, runs: Sequence[Run]) -> Rig:
    """Return a rig with the inertia that logs tell, if its file gives none and they do."""
    if rig.circuit != OPEN or rig.motor is None or INERTIA_KEY in rig.motor.given:
        return rig
    unit = _with(rig, 1.0)
    rows = [_rows(rig, unit, run, name) for run in runs if not is_table(run)
            for name, balance in closed(run, rig).items() if balance.name == 'hydromotor torque']
    if not rows:
        return rig
    *losses, rate, error = np.concatenate(rows).T
    without, alone = (_left(np.array(losses).T, values) for values in (error, rate))
    found = float(alone @ without) / max(float(alone @ alone), 1e-30)
    left = without - found * alone
    return _with(rig, found) if found > 0.0 and (
        left @ left < (1.0 - _ASKED) * (without @ without)) else rig


def found_inertia(rig: Rig, taken: Rig, factors: Mapping[str, float]) -> float:
    """Return the inertia (kg.m^2) of a rig that was taken in the place of another; 0: the same."""
    same = rig.motor is None or rig.motor.inertia == taken.motor.inertia
    return 0.0 if same else taken.motor.inertia * factors.get(INERTIA, 1.0)


def _with(rig: Rig, inertia: float) -> Rig:
    return replace(rig, motor=replace(rig.motor, inertia=inertia), tolerances={
        **rig.tolerances, INERTIA: _SIGMA})


def _rows(rig: Rig, unit: Rig, run: Run, name: str) -> np.ndarray:
    """Return what losses may go with, the torque that 1 kg.m^2 takes, and the error, by row."""
    replay = PartReplay(run, PartModel(unit))
    ideal, turned = (replay.predict(PartModel(entry))[name] for entry in (rig, unit))
    good = replay.counted(name) & np.isfinite(run['motor_speed'])
    speed = run['motor_speed'][good]
    ideal, brakes = ideal[good], np.sign(speed)
    return np.column_stack([
        ideal, brakes * np.abs(ideal), brakes, speed, speed * np.abs(speed), np.ones(len(speed)),
        turned[good] - ideal, replay.run[name][good] - ideal])


def _left(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    scaled = columns / np.maximum(np.abs(columns).max(axis=0), 1e-30)
    return values - scaled @ np.linalg.lstsq(scaled, values, rcond=1e-9)[0]
