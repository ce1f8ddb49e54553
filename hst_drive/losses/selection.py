# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which of the motors serves a duty best, and in which zone a motor is reasonable."""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.losses.study import Study
import numpy as np

ZONE = 0.02         # efficiency below the motor's best, as a share of 1
_GRID = 41


class Duty(NamedTuple):
    """An operating point of a duty: N.m, rad/s, share of the time."""

    torque: float
    speed: float
    share: float


class Zone(NamedTuple):
    """
    Where a motor's efficiency is within ``ZONE`` of its best, inside the bench's range.

    ``bounds``: for some speeds (rad/s) the lowest and highest load torque (N.m) of the zone;
    ``share``: of the range over torque and speed.
    """

    best: float
    best_torque: float
    best_speed: float
    share: float
    bounds: tuple[tuple[float, float, float], ...]


class Candidate(NamedTuple):
    """
    A motor under a duty.

    ``efficiency``: shaft energy over hydraulic energy of the whole duty, ``low``, ``high`` 95 %;
    ``outside``: points of the duty outside what the bench measured with this motor.
    """

    displacement: float
    efficiency: float
    low: float
    high: float
    points: tuple[dict, ...]
    outside: int
    zone: Zone


def select(study: Study, duty: list[Duty], viscosity: float) -> list[Candidate]:
    """
    Return the motors of the bench, the most efficient first; those measured there before others.

    Parameters
    ----------
    study : Study
        The bench.
    duty : list of Duty
        Operating points with their shares of the time.
    viscosity : float
        Kinematic viscosity of the oil, m^2/s.

    """
    torque, speed, share = (np.array(values) for values in zip(*duty))
    share = share / share.sum()
    found = []
    for size in study.scales.sizes:
        at = study.operate(speed, torque, viscosity, size)
        gained, taken = share @ (torque * speed), share * at['pressure'] * at['flow']
        efficiency = float(gained / taken.sum())
        # The curve's errors at the points of a duty are nearly one error.
        sd = float(efficiency * (taken @ (at['efficiency_sd'] / at['efficiency'])) / taken.sum())
        beyond = _beyond(study, size, at['pressure'], speed)
        points = tuple({'load_torque': float(torque[k]), 'motor_speed': float(speed[k]),
                        'share': float(share[k]), 'outside_bench': bool(beyond[k]),
                        **{name: float(values[k]) for name, values in at.items()}}
                       for k in range(len(duty)))
        found.append(Candidate(size, efficiency, efficiency - 1.96 * sd, efficiency + 1.96 * sd,
                               points, int(beyond.sum()), zone(study, size, viscosity)))
    return sorted(found, key=lambda entry: (entry.outside > 0, -entry.efficiency))


def _beyond(study: Study, size: float, pressure: np.ndarray, speed: np.ndarray) -> np.ndarray:
    bench = study.bench
    own = bench.of_motor(size)
    margin = 1.02
    return ((pressure > margin * bench.pressure[own].max())
            | (pressure < bench.pressure[own].min() / margin)
            | (speed > margin * bench.speed[own].max())
            | (speed < bench.speed[own].min() / margin))


def grid(study: Study, size: float, viscosity: float, count: int = _GRID) -> dict:
    """Return a motor's performance over its range of load torque (rows) and speed (columns)."""
    bench = study.bench
    own = bench.of_motor(size)
    torque = np.linspace(max(bench.load_torque[own].min(), 1e-3 * bench.load_torque[own].max()),
                         bench.load_torque[own].max(), count)
    speed = np.linspace(bench.speed[own].min(), bench.speed[own].max(), count)
    shape = (count, count)
    at = study.operate(np.tile(speed, count), np.repeat(torque, count), viscosity, size)
    return {'load_torque': torque, 'motor_speed': speed,
            **{name: values.reshape(shape) for name, values in at.items()}}


def zone(study: Study, size: float, viscosity: float) -> Zone:
    """Return where a motor is within ``ZONE`` of its best efficiency."""
    field = grid(study, size, viscosity)
    efficiency = field['efficiency']
    row, column = np.unravel_index(np.argmax(efficiency), efficiency.shape)
    inside = efficiency >= efficiency[row, column] - ZONE
    bounds = []
    for k in np.unique(np.linspace(0, len(field['motor_speed']) - 1, 5).astype(int)):
        rows = np.flatnonzero(inside[:, k])
        if len(rows):
            bounds.append((float(field['motor_speed'][k]), float(field['load_torque'][rows[0]]),
                           float(field['load_torque'][rows[-1]])))
    return Zone(float(efficiency[row, column]), float(field['load_torque'][row]),
                float(field['motor_speed'][column]), float(inside.mean()), tuple(bounds))
