# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Samples of a short time, weighed by a bell, and what the equations leave of the balances."""
from __future__ import annotations

import math
from typing import Any, Mapping, NamedTuple

from hst_drive.measure.circuit_balances import (
    CHANGES, circuit_state, predicted, read_instead)
from hst_drive.measure.equations import Weak
from hst_drive.model.circuits import Balance
from hst_drive.model.drive import turned
from hst_drive.model.part import PartModel
from hst_drive.rig import Rig
from hst_drive.rig.rig import Sensor
from hst_drive.watch.stream import Window
import numpy as np

SPEED = 'motor_speed'
_TORQUE = 1.6e-3    # of what the relief valve lets the motor make: 1 N m on the paper's rig
_STEP = 1e-3        # of a quantity, by which differences are taken
LEAST = 5           # samples in a window


class Accuracy(NamedTuple):
    """
    How far a sensor may be off, noise apart: standard uncertainties.

    The defaults are the motor-loss paper's: pressure 0.25 % of its range, flow 0.5 % of the
    reading, torque 1 % of 100 N m. The speed is counted.
    """

    pressure: float = 5e4       # Pa
    flow: float = 0.005         # of the reading
    torque: float = 1.0         # N.m
    speed: float = 0.0          # of the reading

    def of(self, unit: str, reading: float) -> tuple[float, float]:
        """Return what a sensor of an SI unit may be off, and by how much that moves a reading."""
        return {'Pa': (self.pressure, 1.0), 'N.m': (self.torque, 1.0),
                'm^3/s': (self.flow, reading), 'rad/s': (self.speed, reading)}.get(
                    unit, (0.0, 1.0))


def accuracy_of(rig: Rig, pressure: float = Accuracy().pressure, flow: float = Accuracy().flow,
                torque: float = 0.0) -> Accuracy:
    """Return how far a machine's sensors may be off; a torque of 0: as usual for its size."""
    valve = rig.relief_valve or rig.cross_port_relief
    if not torque and valve and rig.motor:
        torque = _TORQUE * valve.set_pressure * rig.motor.displacement
    return Accuracy(pressure, flow, torque or Accuracy().torque)


def noise_of(rig: Rig, name: str) -> float:
    """Return the noise of a sensor as the rig file states it, its resolution included, SI."""
    return rig.sensors.get(name, Sensor(0.0)).std


def bell(time: np.ndarray, middle: float, first: float = -math.inf
         ) -> tuple[np.ndarray, np.ndarray] | None:
    """
    Return weights whose sums are a smoothed signal and the equally smoothed rate of a signal.

    The rate is the weak form: the derivative falls on the weight, so that a balance with a rate
    in it holds of the smoothed signals as of the signals, across jumps, too (M. Shinbrot, On
    the analysis of linear and nonlinear dynamical systems, NACA TN 3288, 1954).

    Parameters
    ----------
    time : ndarray
        s.
    middle : float
        Where the weights are highest, s.
    first : float
        Samples before it weigh nothing, s.

    Returns
    -------
    level, rate : ndarray
        None if the samples are too few or lie on one side.

    """
    inside = time >= first - 1e-9
    at = time[inside] - middle
    if len(at) < LEAST:
        return None
    half = max(-at[0], at[-1]) * (1 + 1 / len(at))
    if min(-at[0], at[-1]) < 0.5 * half:
        return None
    place = at / half
    level, rate = np.zeros((2, len(time)))
    level[inside] = (1 - place * place)**2
    inner = place * (1 - place * place)
    inner -= inner.mean()
    rate[inside] = inner / (inner @ at)
    return level / level.sum(), rate


class Samples:
    """
    The samples of a block and before it, and the balances that they close.

    Parameters
    ----------
    model : PartModel
        The drive.
    balances : mapping of str to Balance
        By id.
    window : Window
        From ``LEAD`` before the block to its end.
    level, rate : ndarray
        Weights of a mean over the block and of a mean rate.
    creeping : float
        Speed below which the sense of rotation is not sure, rad/s.

    Attributes
    ----------
    backwards : bool
        Whether the hydromotor turns backwards, on the mean.

    """

    def __init__(self, model: PartModel, balances: Mapping[str, Balance], window: Window,
                 level: np.ndarray, rate: np.ndarray, creeping: float):
        self._model, self._creeping, self._time = model, creeping, window.time
        self.backwards = bool(level @ window.values[SPEED] < 0.0)
        self._instead = read_instead(model)
        self._by_effect: dict[tuple, dict[str, float]] = {}
        self._angle = turned(window.time, window.values[SPEED])
        self.level, self.rate = level, rate
        self._weak = Weak(window.time, self.mean, lambda values: float(rate @ values))
        self.known = self._state(model, window.values)
        # The same however often the equations are asked.
        self._channels = {**window.values, 'viscosity_ratio': self.known['viscosity_ratio']}
        self._balances = {name: entry for name, entry in balances.items() if self._holds(entry)}
        self.residuals = {name: self._residual(name, model, self._channels, self.known)
                          for name in self._balances}

    def _holds(self, balance: Balance) -> bool:
        """Say whether what a balance hangs on is true, now and shortly before."""
        needed = balance.conditions
        if not needed:
            return True
        around = self._time > self._time[np.flatnonzero(self.level)[0]] - CHANGES
        return bool(np.all(np.any([self.known[when][around] >= 1.0 for when in needed], axis=0)))

    def mean(self, values: Any) -> float:
        """Return the weighted mean."""
        return float(self.level @ values) if np.ndim(values) else float(values)

    def _state(self, model: PartModel, channels: dict[str, np.ndarray]) -> dict[str, Any]:
        return circuit_state(model, channels, self._time, self._creeping, self._angle)

    def _residual(self, name: str, model: PartModel, channels: dict[str, np.ndarray],
                  known: dict[str, Any]) -> float:
        balance = self._balances[name]
        error = self.mean(channels[balance.channels(channels)[0]]) - self.mean(
            predicted(balance, model, known, channels, self._weak))
        return error * (self._model.motor_displacement if balance.swept else 1.0)

    @property
    def speed(self) -> np.ndarray:
        """The hydromotor's speed as it is, whatever its sensor does, rad/s."""
        return self.known.get('true', self.known)[SPEED]

    @property
    def temperature(self) -> np.ndarray | float:
        """The oil's temperature, K; that of the tables where it is not measured."""
        return self._channels.get('oil_temperature', self._model.rig.characterised_at)

    def drained(self) -> float:
        """Return what the case drain's meter reads; NaN without one."""
        return self.mean(self._channels.get('case_drain_flow', math.nan))

    def sheet(self, name: str) -> float:
        """Return how far off a maker's sheet may be on a balance, SI."""
        balance = self._balances[name]
        reading = self._channels[balance.channels(self._channels)[0]]
        return balance.untold * abs(self.mean(reading)) * (
            self._model.motor_displacement if balance.swept else 1.0)

    def by_channel(self, channel: str) -> dict[str, float]:
        """Return how the residuals that go by a channel move with it."""
        step = _STEP * (abs(self.mean(self._channels[channel])) or 1.0)
        moved = {**self._channels, channel: self._channels[channel] + step}
        known = self._state(self._model, moved)
        return {name: (self._residual(name, self._model, moved, known) - before) / step
                for name, before in self.residuals.items()
                if channel in self._balances[name].channels(moved) or channel in self._instead}

    def by_factor(self, key: str) -> dict[str, float]:
        """Return how the residuals move if a unit is off in a quantity, per share of it."""
        section = key.partition('.')[0]
        near = [name for name in self.residuals if section == 'line' or self._balances[name].parts
                or any(entry.partition('.')[0] == section for entry in self._balances[name].rig)]
        moved = self._model.changed({}, {key: 1.0 + _STEP})
        # What a log of the open circuit tells hangs on oil and hydromotor alone.
        known = self.known if section in ('pump', 'loading') and 'true' not in self.known else (
            self._state(moved, self._channels))
        return {name: (self.residuals[name] - self._residual(
            name, moved, self._channels, known)) / _STEP for name in near}

    def by_effect(self, effect: str, values: Mapping[str, float]) -> dict[str, float]:
        """Return how an effect with these parameters (SI) moves the residuals."""
        key = (effect, *values.items())
        if key not in self._by_effect:
            moved = self._model.with_effect(effect, values)
            known = self._state(moved, self._channels)
            self._by_effect[key] = {
                name: before - self._residual(name, moved, self._channels, known)
                for name, before in self.residuals.items()}
        return self._by_effect[key]
