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

from dataclasses import replace
from functools import cached_property
import math
from typing import NamedTuple

from hst_drive.channels import CHANNELS
from hst_drive.effects.leakage_temperature import OIL_LAW, POWER
from hst_drive.measure.circuit_balances import read_instead, watched
from hst_drive.measure.run import zeroed
from hst_drive.model.circuit_model import part_model
from hst_drive.rig import Rig
from hst_drive.rig.rig import NO_SIGN, OPEN
from hst_drive.watch.samples import Accuracy, accuracy_of, bell, noise_of, Samples, SPEED
from hst_drive.watch.stream import Window
import numpy as np

NEITHER = 'neither line is clearly under pressure'
LEAD = 1.0          # s before a block, in which lags settle
_STAMPS = 3e-3      # s: how well the time stamps of two signals agree
_FLOOR = 0.25       # of the scatter between units: how good a calibrated model is expected to be
_NEAR_RELIEF = 0.95  # of the relief valve's pressure
_LOWEST = 1e5       # Pa
_SENSOR = 'sensor.'
_POWER_SIGMA = 1.0 / 6.0     # of the power of the oil: any from 0 to 1 within three sigma
_LINES = frozenset({'pump_outlet_pressure', 'line_a_pressure', 'line_b_pressure'})


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
    """Balances of one block (ns) and the samples."""

    start: int
    end: int
    residuals: dict[str, Residual]
    samples: Samples


def following_oil(rig: Rig) -> tuple[Rig, float]:
    """
    Return a commissioned machine whose leakages follow its oil, and one sigma of the power.

    Where that was not learnt it is learnt while the machine drills. 0: it is taken as known.
    """
    if not rig.fingerprint or 'oil_temperature' not in rig.fingerprint.conditions:
        return rig, 0.0
    if OIL_LAW in rig.effects:
        return rig, rig.fingerprint.oil_law
    return replace(rig, effects={**rig.effects, OIL_LAW: {'exponent': POWER}}), _POWER_SIGMA


class Balances:
    """
    The balances that some signals close.

    Parameters
    ----------
    rig : Rig
        Adopted effects and calibration count; of a commissioned machine's oil see
        ``following_oil``.
    signals : tuple of str
        Channels at hand.
    accuracy : Accuracy, optional
        Of the sensors; None: what is usual on a machine of this size.

    """

    def __init__(self, rig: Rig, signals: tuple[str, ...], accuracy: Accuracy | None = None):
        self.rig, self._oil = following_oil(rig)
        self.model = part_model(self.rig)
        self._signals, self.accuracy = signals, accuracy or accuracy_of(rig)
        self.closed = watched(signals, rig)
        self.correlation = rig.fingerprint.correlation if rig.fingerprint else {}
        self._noise = {name: noise_of(rig, name) for name in signals}
        self._creeping = max(rig.creeping, NO_SIGN * self._noise.get(SPEED, 0.0))

    @cached_property
    def needed(self) -> tuple[str, ...]:
        """The signals that the balances need, the speed first."""
        return tuple(dict.fromkeys((SPEED, *(
            name for entry in self.closed.values() for name in entry.channels(self._signals)),
            *(name for name in read_instead(self.model) if name in self._signals))))

    @cached_property
    def spread(self) -> dict[str, float]:
        """What may be off without any physics missing: name to standard deviation."""
        return {**self.rig.scatter, OIL_LAW: self._oil, **{
            _SENSOR + name: self.accuracy.of(CHANNELS[name].unit, 1.0)[0]
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
        window = window._replace(values=zeroed(window.values, self.rig.zeros))
        first = (start - window.start) * 1e-9
        weights = bell(window.time, first + (end - start) * 0.5e-9, first)
        if weights is None:
            return 'too few samples'
        level, rate = weights
        inside = level > 0.0
        reason = self._reason({name: values[inside] for name, values in window.values.items()})
        if reason:
            return reason
        samples = Samples(self.model, self.closed, window, level, rate, self._creeping)
        if not samples.residuals:
            return NEITHER
        left = float(np.sqrt(level @ level / window.samples))
        parts: dict[str, dict[str, float]] = {name: {} for name in samples.residuals}
        noise = dict.fromkeys(parts, 0.0)
        for channel in self.needed:
            values = window.values[channel]
            mean = samples.mean(values)
            # Noise, and what comes too early or too late.
            unsure = float(np.hypot(left * self._noise[channel], _STAMPS * (rate @ values)))
            per = self.accuracy.of(CHANNELS[channel].unit, mean)[1]
            for name, slope in samples.by_channel(channel).items():
                parts[name][_SENSOR + channel] = slope * per
                noise[name] = float(np.hypot(noise[name], slope * unsure))
        for key in self.rig.scatter:
            for name, slope in samples.by_factor(key).items():
                parts[name][key] = slope
        if self._oil:
            for name, slope in self._by_oil(samples).items():
                parts[name][OIL_LAW] = slope
        return Block(start, end, {name: Residual(
            value, noise[name], float(np.hypot(samples.sheet(name), _FLOOR * np.sqrt(sum(
                (slope * self.spread[key])**2 for key, slope in parts[name].items())))),
            parts[name]) for name, value in samples.residuals.items()}, samples)

    def _by_oil(self, samples: Samples) -> dict[str, float]:
        """Return how the residuals move with the power of oil that commissioning has not seen."""
        warm = samples.mean(samples.temperature)
        there = np.clip(warm, *self.rig.fingerprint.conditions['oil_temperature'])
        thinner, seen = np.log(self.rig.viscosity_ratio(np.array([warm, there])))
        if abs(thinner) <= abs(seen):
            return {}
        # To the side on which leakages change most.
        step = math.copysign(POWER, warm - there)
        power = self.rig.effects[OIL_LAW]['exponent'] + step
        return {name: (1.0 - seen / thinner) * moved / step
                for name, moved in samples.by_effect(OIL_LAW, {'exponent': power}).items()}

    def _reason(self, cut: dict[str, np.ndarray]) -> str:
        speed = cut[SPEED]
        if self.rig.circuit == OPEN and speed.max() < -self._creeping:
            return 'turns backwards'
        if np.abs(speed).min() < self._creeping or speed.min() < 0.0 < speed.max():
            return 'reversal' if max(-speed.min(), 0.0) > self._creeping < speed.max() else (
                'standstill')
        valve = self.rig.relief_valve or self.rig.cross_port_relief
        for name in _LINES & cut.keys():
            sensor = self.rig.sensors.get(name)
            top = min(_NEAR_RELIEF * valve.set_pressure if valve else np.inf,
                      sensor.range[1] if sensor and sensor.range else np.inf)
            if cut[name].max() >= top:
                return 'pressure at the relief valve or the end of the sensor'
            if name == 'pump_outlet_pressure' and cut[name].min() < _LOWEST:
                return 'no pressure'
        return ''
