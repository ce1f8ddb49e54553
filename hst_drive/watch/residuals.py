# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The balances of the running drive over short blocks of time: what the model leaves of each.

They are those of a log of a part (``measure.equations``), weighed by a bell over the block. With
each residual comes what would move it: the tolerances of the unit and the accuracies of the
sensors, which are no missing physics, and the effects of the catalogue. The equations themselves
tell that, by differences.
"""
from __future__ import annotations

from functools import cached_property
from typing import Any, Mapping, NamedTuple

from hst_drive.measure.balances import Balance, watched
from hst_drive.measure.equations import told, Weak
from hst_drive.measure.run import CHANNELS
from hst_drive.model.drive import turned
from hst_drive.model.part import PartModel
from hst_drive.rig import Rig
from hst_drive.watch.figures import Accuracy, bell, noise_of, PRESSURE, SPEED
from hst_drive.watch.stream import Window
import numpy as np

LEAD = 1.0          # s before a block, in which lags settle
_STAMPS = 3e-3      # s: how well the time stamps of two signals agree
_FLOOR = 0.25       # of the scatter between units: how good a calibrated model is expected to be
_CREEPING, _SCATTER = 0.023, 5.0     # of the full speed; deviations of the sensor's noise
_NEAR_RELIEF = 0.95  # of the relief valve's pressure
_LOWEST = 1e5       # Pa
_STEP = 1e-3        # of a quantity, by which differences are taken
_SENSOR = 'sensor.'


class Residual(NamedTuple):
    """
    One balance over one block, SI.

    Attributes
    ----------
    value : float
        Measured minus model.
    noise : float
        Standard deviation from sensor noise and time stamps.
    floor : float
        What a calibrated model may still be off.
    moved_by : dict of str to float
        How the residual moves per unit of each tolerance (a relative one) or sensor offset.

    """

    value: float
    noise: float
    floor: float
    moved_by: dict[str, float]


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

    """

    def __init__(self, model: PartModel, balances: Mapping[str, Balance], window: Window,
                 level: np.ndarray, rate: np.ndarray, creeping: float):
        self._model, self._balances = model, balances
        self._creeping = creeping
        self._by_effect: dict[tuple, dict[str, float]] = {}
        self._angle = turned(window.time, window.values[SPEED])
        self.level, self.rate = level, rate
        self._weak = Weak(window.time, self.mean, lambda values: float(rate @ values))
        self.known = self._told(model, window.values)
        # The same however often the equations are asked.
        self._channels = {**window.values, 'viscosity_ratio': self.known['viscosity_ratio']}
        self.residuals = {name: self._residual(name, model, self._channels, self.known)
                          for name in balances}

    def mean(self, values: Any) -> float:
        """Return the weighted mean."""
        return float(self.level @ values) if np.ndim(values) else float(values)

    def _told(self, model: PartModel, channels: dict[str, np.ndarray]) -> dict[str, Any]:
        return told(model, channels, self._creeping, self._angle)

    def _residual(self, name: str, model: PartModel, channels: dict[str, np.ndarray],
                  known: dict[str, Any]) -> float:
        balance = self._balances[name]
        return self.mean(channels[balance.channels(channels)[0]]) - self.mean(
            balance.equation(model, known, channels, self._weak))

    def by_channel(self, channel: str, step: float) -> dict[str, float]:
        """Return how the residuals that go by a channel move with it."""
        moved = {**self._channels, channel: self._channels[channel] + step}
        known = self._told(self._model, moved)
        return {name: (self._residual(name, self._model, moved, known) - before) / step
                for name, before in self.residuals.items()
                if channel in self._balances[name].channels(moved)}

    def by_factor(self, key: str) -> dict[str, float]:
        """Return how the residuals move if a unit is off in a quantity, per share of it."""
        section = key.partition('.')[0]
        near = [name for name in self.residuals if section == 'line' or any(
            entry.partition('.')[0] == section for entry in self._balances[name].rig)]
        moved = self._model.changed({}, {key: 1.0 + _STEP})
        # What is told hangs on oil and hydromotor alone.
        known = self.known if section in ('pump', 'loading') else self._told(
            moved, self._channels)
        return {name: (self.residuals[name] - self._residual(
            name, moved, self._channels, known)) / _STEP for name in near}

    def by_effect(self, effect: str, values: Mapping[str, float]) -> dict[str, float]:
        """Return how an effect with these parameters (SI) moves the residuals."""
        key = (effect, *values.items())
        if key not in self._by_effect:
            moved = self._model.with_effect(effect, values)
            known = self._told(moved, self._channels)
            self._by_effect[key] = {
                name: before - self._residual(name, moved, self._channels, known)
                for name, before in self.residuals.items()}
        return self._by_effect[key]


class Block(NamedTuple):
    """Balances of one block (ns), the means of what is known, and the samples."""

    start: int
    end: int
    residuals: dict[str, Residual]
    known: dict[str, float]
    samples: Samples


class Balances:
    """
    The balances that some signals close.

    Parameters
    ----------
    rig : Rig
        Adopted effects and calibration count.
    signals : tuple of str
        Channels at hand.
    accuracy : Accuracy
        Of the sensors.

    """

    def __init__(self, rig: Rig, signals: tuple[str, ...], accuracy: Accuracy = Accuracy()):
        self.rig, self.model = rig, PartModel(rig)
        self._signals, self._accuracy = signals, accuracy
        self.closed = watched(signals, rig)
        self.correlation = rig.fingerprint.correlation if rig.fingerprint else {}
        self._noise = {name: noise_of(rig, name) for name in signals}
        self._creeping = max(_CREEPING * rig.full_speed, _SCATTER * self._noise.get(SPEED, 0.0))

    @cached_property
    def needed(self) -> tuple[str, ...]:
        """The signals that the balances need, the speed first."""
        return tuple(dict.fromkeys((SPEED, *(
            name for entry in self.closed.values() for name in entry.channels(self._signals)))))

    @cached_property
    def spread(self) -> dict[str, float]:
        """What may be off without any physics missing: name to standard deviation."""
        return {**self.rig.scatter, **{
            _SENSOR + name: self._accuracy.of(CHANNELS[name].unit, 1.0)[0]
            for name in self.needed}}

    def of(self, window: Window, start: int, end: int) -> Block | str:
        """
        Return the balances between two times, or why they cannot be told.

        Parameters
        ----------
        window : Window
            Samples from ``LEAD`` before the block to its end.
        start, end : int
            ns.

        """
        first = (start - window.start) * 1e-9
        inside = window.time >= first - 1e-9
        weights = bell(window.time[inside], first + (end - start) * 0.5e-9)
        if weights is None:
            return 'too few samples'
        reason = self._reason({name: values[inside] for name, values in window.values.items()})
        if reason:
            return reason
        level, rate = np.zeros((2, len(window.time)))
        level[inside], rate[inside] = weights
        samples = Samples(self.model, self.closed, window, level, rate, self._creeping)
        left = float(np.sqrt(level @ level))
        parts: dict[str, dict[str, float]] = {name: {} for name in self.closed}
        noise = dict.fromkeys(self.closed, 0.0)
        for channel in self.needed:
            values = window.values[channel]
            mean = samples.mean(values)
            # Noise, and what comes too early or too late.
            unsure = float(np.hypot(left * self._noise[channel], _STAMPS * (rate @ values)))
            per = self._accuracy.of(CHANNELS[channel].unit, mean)[1]
            for name, slope in samples.by_channel(channel, _STEP * (abs(mean) or 1.0)).items():
                parts[name][_SENSOR + channel] = slope * per
                noise[name] = float(np.hypot(noise[name], slope * unsure))
        for key in self.rig.scatter:
            for name, slope in samples.by_factor(key).items():
                parts[name][key] = slope
        residuals = {name: Residual(
            samples.residuals[name], noise[name], _FLOOR * float(np.sqrt(sum(
                (slope * self.spread[key])**2 for key, slope in parts[name].items()))),
            parts[name]) for name in self.closed}
        return Block(start, end, residuals, {
            name: samples.mean(value)
            for name, value in {**window.values, **samples.known}.items()}, samples)

    def _reason(self, cut: dict[str, np.ndarray]) -> str:
        speed = cut[SPEED]
        if min(speed.max(), -speed.min(), key=abs) < 0 and speed.min() < self._creeping:
            return 'reversal' if speed.max() > self._creeping else 'turns backwards'
        if speed.min() < self._creeping:
            return 'standstill'
        pressure = cut.get(PRESSURE)
        if pressure is not None:
            valve, sensor = self.rig.relief_valve, self.rig.sensors.get(PRESSURE)
            top = min(_NEAR_RELIEF * valve.set_pressure if valve else np.inf,
                      sensor.range[1] if sensor and sensor.range else np.inf)
            if pressure.max() >= top:
                return 'pressure at the relief valve or the end of the sensor'
            if pressure.min() < _LOWEST:
                return 'no pressure'
        return ''
