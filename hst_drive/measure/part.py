# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Replay of a log of a part of the drive: one predicted signal per balance that the log closes.

A balance with a rate in it (inertia times acceleration, oil that the line takes) is compared in
its weak form: both sides are smoothed with one Gaussian, and the derivative falls on that (M.
Shinbrot, On the analysis of linear and nonlinear dynamical systems, NACA TN 3288, 1954). So no
noise is differentiated, and what is faster than the Gaussian is lost on both sides alike.
"""
from __future__ import annotations

from dataclasses import replace
from functools import cached_property, partial
from typing import Any, Callable, Mapping

from hst_drive.channels import CHANNELS, PRESSURES, TORQUES
from hst_drive.effects.entrained_air import ATMOSPHERE
from hst_drive.errors import InputError
from hst_drive.measure.balances import closed, is_table, what_would_close
from hst_drive.measure.circuit_balances import predicted
from hst_drive.measure.equations import measured_state, source_of, Weak
from hst_drive.measure.floor import part_floor
from hst_drive.measure.judged import CAVITATING
from hst_drive.measure.noise import steady_noise, surface_noise
from hst_drive.measure.readings import bridged, earlier, gaps, later
from hst_drive.measure.run import Run, shifted, usual_size, zeroed
from hst_drive.measure.turns import into_step
from hst_drive.model.circuits import Balance
from hst_drive.model.drive import turned
from hst_drive.model.part import PartModel
from hst_drive.rig.rig import NO_SIGN, Sensor
import numpy as np
from scipy.ndimage import gaussian_filter1d

NARROW, _WIDE = 1.5, 0.2    # the Gaussian's deviation: in samples at least, in s at most
_LEAST_ROWS = 12
# Of the usual speed: below it friction hangs on how it changes its sign. Operating points stand.
_CREEPING = 0.05        # as ``useful.refuse_unjudged`` says
_BOTH = 0.05            # of the rows: so many in either direction tell it from the other
_UNKNOWN = 0.05         # of what a smoothed row is made of
_APART = 5.0            # deviations of the Gaussian, from which on rows share no noise


class PartReplay:
    """
    A log of a part, ready to be predicted by models again and again.

    Noise and floor are judged with the model that is given. InputError is raised if the channels
    close no balance (``balances.BALANCES``), or there are too few rows.

    Attributes
    ----------
    run : Run
        The log; signals of balances with a rate are smoothed as the prediction is.
    balances : dict of str to Balance
        The balance that predicts each signal.
    static : bool
        Whether the rows are operating points; then ``run.time`` counts them.
    noise : dict of str to float
        White noise of each predicted signal before smoothing, SI.
    stamp_std : float
        How well time stamps and steps between samples are known, s.
    command_time_std : float
        How much less well the times of the commands are, s.
    extra_std : dict of str to ndarray
        Standard deviation beyond the floor, row by row, SI: what a formula or rough rock adds.

    """

    extra_std: dict[str, np.ndarray] = {}

    def __init__(self, run: Run, model: PartModel):
        self.balances = self._closed(run, model)
        if len(run) < _LEAST_ROWS:
            raise InputError(f'{run.source}: {len(run)} rows, expected at least {_LEAST_ROWS} to '
                             'judge a balance; record more operating points')
        self.static = is_table(run)
        if self.static:
            run = replace(run, time=np.arange(len(run), dtype=float))
        self.run = run
        self.signals = tuple(self.balances)
        self.stamp_std = 0.0 if self.static else max(1e-3, 0.1 * run.sample_time)
        self.command_time_std = 0.0
        self._missing = np.zeros(len(run), dtype=bool)
        used = sorted(name for name in run.channels if name in CHANNELS)
        for name in used:
            if np.isfinite(run[name]).sum() < 2:
                raise InputError(f"{run.source}: channel '{name}' has no readings; leave the "
                                 'column out')
            if self.static:
                self._missing |= ~np.isfinite(run[name])
            elif not CHANNELS[name].slow:
                self._missing |= gaps(run[name])
        self._channels = {name: bridged(
            name, run[name], np.inf if self.static else run.sample_time) for name in used}
        self.inputs = {name: self._channels[name] for name in (
            'pump_command', 'pprv_command', 'oil_temperature') if name in used}
        if 'motor_speed' in used and not self.static:
            self.inputs['motor_angle'] = turned(run.time, self._channels['motor_speed'])
        self._creeping = max(
            0.0 if self.static else _CREEPING * self.usual('motor_speed'),
            NO_SIGN * self._noise_of('motor_speed', model)) if 'motor_speed' in used else 0.0
        self._widths = dict.fromkeys(self.signals, 0.0)
        self._input_noise = {name: self._noise_of(name, model) for name in used}
        self.noise = {name: self._signal_noise(name, model) for name in self.signals}
        self._widths = {name: self._width(name, model) for name in self.signals}
        self.run = replace(run, channels={
            **run.channels, **{name: self._measured(name) for name in self.signals}})
        if 'motor_angle' in self.inputs:
            into_step(self, model)

    def _closed(self, run: Run, model: PartModel) -> dict[str, Balance]:
        """Return which balance predicts each signal; raise InputError if none does."""
        found = closed(run, model.rig)
        if not found:
            raise InputError(what_would_close(run, model.rig))
        return found

    def usual(self, *names: str) -> float:
        """Return the size, SI, that the first of some channels usually has; 0 without one."""
        return next((usual_size(self._channels[name])
                     for name in names if name in self._channels), 0.0)

    def counted(self, name: str) -> np.ndarray:
        """Return the rows in which a signal can be judged."""
        return np.isfinite(self.run[name])

    @property
    def sensor_noise(self) -> dict[str, float]:
        """White noise of each sensor, SI."""
        return {**self._input_noise, **self.noise}

    @cached_property
    def reverses(self) -> bool:
        """Whether the shaft turns both ways."""
        speed = self._channels.get('motor_speed', np.zeros(1))
        return all(float(np.mean(way > self._creeping)) > _BOTH for way in (speed, -speed))

    @property
    def ahead(self) -> bool:
        """Whether the shaft turns forwards, on the whole."""
        return bool(np.sum(self._channels.get('motor_speed', 0.0)) >= 0.0)

    def _noise_of(self, name: str, model: PartModel) -> float:
        """Return a sensor's noise: from the record, or as stated for a table."""
        sensor = model.rig.sensors.get(name, Sensor(0.0))
        if self.static:
            return sensor.std if sensor.noise_std > 0 else 0.0
        if CHANNELS[name].hold == 'zero' or CHANNELS[name].slow:
            return 0.0
        return max(steady_noise(self.run[name]), sensor.step_std)

    def _signal_noise(self, name: str, model: PartModel) -> float:
        rest = self._channels[name] - self.predict(model)[name]
        tiny = 1e-6 * float(np.max(np.abs(self._channels[name]))) + 1e-15
        if self.static:
            stated = self._noise_of(name, model)
            # A table whose sensor is not described: what a smooth surface leaves of the error.
            if not stated:
                self._input_noise = dict.fromkeys(self._input_noise, 0.0)
            return max(stated or surface_noise(rest, [self._channels[place] for place in (
                *PRESSURES, 'motor_speed', 'pump_speed', 'pump_command', 'oil_temperature')
                if place in self._channels]), tiny)
        return max(min(self._input_noise[name], steady_noise(rest) or np.inf), tiny)

    def _width(self, name: str, model: PartModel) -> float:
        """Return the Gaussian's deviation, samples, from which the rate adds little noise."""
        gain, source = (0.0, '') if self.static else self._rate_gain(name, model)
        if not gain:
            return 0.0
        noise = self._noise_of(source, model) if source in self._channels else 0.0
        seconds = min(gain * noise / (np.sqrt(2.0) * self.noise[name]), _WIDE)
        return max(seconds / self.run.sample_time, NARROW)

    def _rate_gain(self, name: str, model: PartModel) -> tuple[float, str]:
        """Return the usual factor on a rate in a balance, and the channel of that rate."""
        known = self._state(model, self._channels)
        source, found = '', []

        def rate(values: np.ndarray) -> float:
            nonlocal source
            source = 'motor_speed' if values is known.get('motor_speed') else source_of(
                self._channels)
            return float(len(found))

        for _ in range(2):
            found.append(predicted(self.balances[name], model, known, self._channels,
                                   Weak(self.run.time, np.asarray, rate)))
        return float(np.median(np.abs(found[1] - found[0]))), source

    def apart(self, name: str) -> int:
        """Return from how many rows on errors share no noise; 0: rows have no order."""
        return 0 if self.static else max(int(np.ceil(_APART * self._widths[name])), 1)

    def _smooth(self, values: Any, name: str) -> np.ndarray:
        values = np.broadcast_to(np.asarray(values, dtype=float), len(self.run)).copy()
        width = self._widths[name]
        return gaussian_filter1d(values, width, mode='nearest') if width else values

    def _rate(self, values: np.ndarray, name: str) -> np.ndarray:
        if self.static or not self._widths[name]:
            return np.zeros(len(values))
        width = self._widths[name]
        return (gaussian_filter1d(values, width, order=1, mode='nearest')
                / gaussian_filter1d(self.run.time, width, order=1, mode='nearest'))

    def _measured(self, name: str) -> np.ndarray:
        """Return what the prediction is compared with; NaN where it is not known."""
        values = self._smooth(self._channels[name], name)
        spread = int(np.ceil(3 * self._widths[name]))
        unknown = self._missing | self._unjudged(name)
        if not self._widths[name]:
            unknown |= ~np.isfinite(self.run[name])
        missing = unknown | (self._smooth(unknown, name) > _UNKNOWN)
        missing[:spread] = True
        missing[len(missing) - spread:] = True
        values[missing] = np.nan
        return values

    def _unjudged(self, name: str) -> np.ndarray | bool:
        """Say in which rows a signal cannot be predicted."""
        if name not in TORQUES:
            return False
        still = np.abs(self._channels['motor_speed']) <= self._creeping
        inlet = self._channels.get('motor_inlet_pressure', np.array(np.inf))
        low, vacuum = inlet < CAVITATING, inlet < -ATMOSPHERE
        # A cavitating inlet does not tell what its hydromotor does, but beside an outlet's gauge.
        # What goes on to fall is a difference of both ports.
        told = 'motor_outlet_pressure' in self._channels or 2 * vacuum.sum() >= low.sum()
        return still if told else still | low

    def predict(self, model: PartModel,
                extra: dict[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
        """Predict each signal from the others; ``extra`` is added to channels, SI."""
        true = zeroed(shifted(self._channels, extra or {}), model.zeros)
        late = {} if self.static else model.delays
        found = self._predicted(model, self.balances, {
            **true, **{name: earlier(self.run.time, true[name], delay)
                       for name, delay in late.items() if name in true}}, self._weak)
        return shifted({name: later(self.run.time, values, late.get(name, 0.0))
                        for name, values in found.items()}, model.zeros)

    def command(self, values: np.ndarray) -> None:
        """Take another command of the pump in the place of the recorded one."""
        self.inputs = {**self.inputs, 'pump_command': values}
        self._channels = {**self._channels, 'pump_command': values}

    def would_read(self, model: PartModel,
                   balances: Mapping[str, Balance]) -> dict[str, np.ndarray]:
        """Return what sensors that a log lacks would read, SI, by balances of their signals."""
        time = None if self.static else self.run.time
        weak = Weak(time, np.asarray, lambda values: (
            np.zeros(len(values)) if time is None else np.gradient(values, time)))
        true = zeroed(self._channels, model.zeros)
        return self._predicted(model, balances, true, lambda name: weak)

    def _predicted(self, model: PartModel, balances: Mapping[str, Balance],
                   channels: dict[str, np.ndarray], weak: Callable[[str], Weak]
                   ) -> dict[str, np.ndarray]:
        known = self._state(model, channels)
        return {name: np.broadcast_to(predicted(
            balance, model, known, channels, weak(name)), len(self.run))
            for name, balance in balances.items()}

    def _state(self, model: PartModel, channels: dict[str, np.ndarray]) -> dict[str, Any]:
        """Return what the equations may read."""
        return measured_state(model, channels, self._creeping, self.inputs.get('motor_angle'))

    def _weak(self, name: str) -> Weak:
        """Return the weak form in which a signal is compared."""
        return Weak(None if self.static else self.run.time, partial(self._smooth, name=name),
                    partial(self._rate, name=name))

    def floor(self, model: PartModel, count: np.ndarray | None = None) -> dict[str, float]:
        """Return the rmse, by signal, that the best model would show: of sensors and its sheet."""
        return part_floor(self, model)

    def draw_noise(self, random: np.random.Generator) -> tuple[
            dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Draw noise of what signals are predicted from, and of themselves as compared, SI."""
        def drawn(std: float) -> np.ndarray:
            return std * random.standard_normal(len(self.run))

        # A signal that is predicted reads other noise than the one it predicts from.
        return ({name: drawn(std) for name, std in self._input_noise.items()},
                {name: self._smooth(drawn(self.noise[name]), name) for name in self.signals})

    def sheet_error(self, name: str) -> float:
        """Return what a maker's sheet may be off on a signal beyond the unit's factors, SI."""
        balance = self.balances[name]
        return balance.untold * usual_size(self.run[name])
