# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The balances of the running drive over short blocks of time: what the model leaves of each.

Each balance is fed with the other measured signals, as in ``measure.part``: so one that is
wrong does not spoil the next. Rates of change count in their weak form. With each residual
comes what would move it: the tolerances of the unit and the accuracies of the sensors, which
are no missing physics, and the effects of the catalogue.
"""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.measure.online.figures import (
    Accuracy, bell, FLOW, INLET, noise_of, PRESSURE, SPEED, TORQUE)
from hst_drive.measure.online.state import DRAIN, State, STROKE
from hst_drive.measure.online.stream import Window
from hst_drive.model.part import PartModel
from hst_drive.rig import Rig
import numpy as np

LEAD = 1.0          # s before a block, in which lags settle
_STAMPS = 3e-3      # s: how well the time stamps of two signals agree
_FLOOR = 0.25       # of the scatter between units: how good a calibrated model is expected to be
_CREEPING, _SCATTER = 0.023, 5.0     # of the full speed; deviations of the sensor's noise
_NEAR_RELIEF = 0.95  # of the relief valve's pressure
_LOWEST = 1e5       # Pa


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


class Block(NamedTuple):
    """Balances of one block, the means of what effects may read, and slopes for their slots."""

    start: int
    end: int
    residuals: dict[str, Residual]
    known: dict[str, float]
    slopes: dict[str, dict[str, float]]


BALANCES: dict[str, tuple[str, str]] = {
    'pump_flow': ('pump flow', 'm^3/s'), 'motor_flow': ('hydromotor flow', 'm^3/s'),
    'motor_torque': ('hydromotor torque', 'N.m'), 'load_torque': ('load torque', 'N.m'),
    'pump_displacement': ('pump stroke', 'm^3/rad'), 'case_drain_flow': ('case drain', 'm^3/s'),
    'line_pressure': ('line', 'Pa')}
"""Name for people and unit by balance."""
_NEEDS: dict[str, tuple[str, ...]] = {
    'pump_flow': ('pump_command', PRESSURE, FLOW), 'motor_flow': (SPEED, PRESSURE, FLOW),
    'motor_torque': (SPEED, PRESSURE, TORQUE), 'load_torque': ('pprv_command', SPEED, TORQUE),
    'pump_displacement': ('pump_command', STROKE), 'case_drain_flow': (SPEED, PRESSURE, DRAIN),
    'line_pressure': (PRESSURE, INLET)}
_SECTIONS: dict[str, tuple[str, ...]] = {
    'pump_flow': ('pump',), 'motor_flow': ('motor',), 'motor_torque': ('motor',),
    'load_torque': ('loading', 'motor'), 'pump_displacement': ('pump',),
    'case_drain_flow': ('motor',), 'line_pressure': ('line',)}


def closed(rig: Rig, signals: tuple[str, ...]) -> tuple[str, ...]:
    """Return the balances that a rig file and the signals close."""
    return tuple(name for name in BALANCES
                 if set(_NEEDS[name]) <= set(signals)
                 and all(getattr(rig, section) is not None for section in _SECTIONS[name]))


def needed(balances: tuple[str, ...]) -> tuple[str, ...]:
    """Return the signals that some balances need, the speed first."""
    found = dict.fromkeys((SPEED, *(name for entry in balances for name in _NEEDS[entry])))
    return tuple(found)


def nuisances(rig: Rig, accuracy: Accuracy) -> dict[str, float]:
    """Return what may be off without any physics missing: name to standard deviation."""
    return {**rig.scatter, 'sensor.pressure': accuracy.pressure, 'sensor.flow': accuracy.flow,
            'sensor.torque': accuracy.torque}


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
        self.names = closed(rig, signals)
        self.spread = nuisances(rig, accuracy)
        self.correlation = rig.fingerprint.correlation if rig.fingerprint else {}
        self._noise = {name: noise_of(rig, name) for name in signals}
        self._creeping = max(_CREEPING * rig.full_speed, _SCATTER * self._noise.get(SPEED, 0.0))

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
        time = window.time[inside]
        weights = bell(time, first + (end - start) * 0.5e-9)
        if weights is None:
            return 'too few samples'
        cut = {name: values[inside] for name, values in window.values.items()}
        reason = self._reason(cut)
        if reason:
            return reason
        state = State(self.model, self.names, self._noise, window, inside, cut, *weights)
        residuals = {}
        for name in self.names:
            value, parts, noise, change = getattr(state, name)()
            scatter = [parts[key] * self.spread.get(key, 0.0) for key in parts]
            residuals[name] = Residual(
                value, float(np.hypot(noise * state.left, _STAMPS * change)),
                _FLOOR * float(np.sqrt(np.square(scatter).sum())), parts)
        return Block(start, end, residuals, state.means(), state.slopes())

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
