# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Replay of a recording: the measured inputs through the model.

The load is the model's, from the recorded PPRV command, plus what the torque sensor reads beyond
it, smoothed: feeding the raw torque would take away the damping that the PPRV's override gives
and let the sensor's noise ring the lightly damped hydraulic resonance. So even a perfect model
does not reach the sensor noise; ``Replay.floor`` is what it would reach.
"""
from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from hst_drive.errors import InputError
from hst_drive.measure.noise import Coloured, estimate_coloured, noise_std, Smoother
from hst_drive.measure.run import Run
from hst_drive.model import Drive

SIGNALS: tuple[str, ...] = (
    'pump_outlet_pressure', 'motor_inlet_pressure', 'motor_inlet_flow', 'case_drain_flow',
    'motor_speed', 'load_torque', 'motor_torque', 'pump_displacement', 'pump_speed')
INPUTS: tuple[str, ...] = ('pump_command', 'pprv_command')
_SLOW = 1.0     # s: slower parts of the unexplained torque are taken as they are
_DRAWS = 3


class Prediction(NamedTuple):
    """Signals that the model gives, SI, by channel name, and the load that was added."""

    signals: dict[str, np.ndarray]
    load_disturbance: np.ndarray


class Replay:
    """
    A recording, ready to be replayed through models again and again.

    Parameters
    ----------
    run : Run
        Needs 'pump_command' and 'pprv_command' and at least one signal of ``SIGNALS``.
    drive : Drive
        Model that the noise of the load and the floor are judged with.

    Attributes
    ----------
    signals : tuple of str
        Measured signals that the model gives, too.
    noise : dict of str to float
        White noise of each signal, SI, estimated from the record.
    roughness : Coloured
        Coloured part of the unexplained load torque, N.m.

    Raises
    ------
    InputError
        If the inputs are not in the log.

    """

    def __init__(self, run: Run, drive: Drive):
        missing = [name for name in INPUTS if name not in run]
        if missing:
            raise InputError(f"{run.source}: channel '{missing[0]}' is missing; a replay of the "
                             'whole drive needs pump_command and pprv_command; name the foreign '
                             'column with --channels')
        self.run = run
        self.signals = tuple(name for name in SIGNALS if name in run)
        if not self.signals:
            raise InputError(f'{run.source}: nothing to compare; expected at least one of '
                             f'{", ".join(SIGNALS)}')
        time = run.time
        self.inputs = {name: _filled(run[name], hold=True) for name in INPUTS}
        temperature = run.channels.get('oil_temperature')
        if temperature is None:
            temperature = np.full(len(time), drive.rig.characterised_at)
        # The oil's temperature is slow: its sensor's noise is not part of the motion.
        width = max(1.0 / run.sample_time, 1.0)
        self.inputs['oil_temperature'] = gaussian_filter1d(_filled(temperature), width)
        self.noise = {name: self._signal_noise(name, drive) for name in self.signals}
        self.torque = next((name for name in ('load_torque', 'motor_torque') if name in run), None)
        self.can_correct = self.torque is not None and 'motor_speed' in run
        self.roughness = Coloured(0.0, 0.3, 0.0)
        if self.can_correct:
            self._speed = _filled(run['motor_speed'])
            self._measured = _filled(run[self.torque])
            self._valid = np.isfinite(run[self.torque])
            rest = self._unexplained(drive)
            noise = self.noise[self.torque]
            self.roughness = estimate_coloured(time, rest - self._slow(rest), noise)
            self._smoother = Smoother(time, self.roughness, self._valid)

    def _signal_noise(self, name: str, drive: Drive) -> float:
        noise = noise_std(self.run[name])
        sensor = drive.rig.sensors.get(name)
        step = sensor.resolution if sensor else 0.0
        return max(noise, step / np.sqrt(12.0), 1e-12)

    def _unexplained(self, drive: Drive) -> np.ndarray:
        model = drive.load_torque(self.run.time, self.inputs['pprv_command'], self._speed,
                                  self.inputs['oil_temperature'])
        return self._measured - model

    def _slow(self, values: np.ndarray) -> np.ndarray:
        # Three running means: as good as a Gaussian here, at a cost that does not grow with width.
        width = max(int(2 * _SLOW / self.run.sample_time), 1)
        for _ in range(3):
            values = uniform_filter1d(values, width, mode='nearest')
        return values

    def disturbance(self, drive: Drive) -> np.ndarray:
        """Return the load torque (N.m) that the sensor shows beyond the load model, smoothed."""
        if not self.can_correct:
            return np.zeros(len(self.run))
        rest = self._unexplained(drive)
        slow = self._slow(rest)
        return slow + self._smoother(rest - slow)

    def start(self, drive: Drive) -> np.ndarray:
        """Return the state at the first sample, as far as the signals tell it."""
        run = self.run
        first = {name: float(_filled(run[name])[0]) for name in self.signals}
        speed = first.get('motor_speed', 0.0)
        pressure = first.get('pump_outlet_pressure', first.get('motor_inlet_pressure'))
        state = drive.initial_state(
            pump_command=self.inputs['pump_command'][0],
            pprv_command=self.inputs['pprv_command'][0], pressure=pressure, speed=speed)
        motor, pump = drive.rig.motor, drive.rig.pump
        if 'pump_displacement' in first:
            state[0] = first['pump_displacement']
        elif 'motor_speed' in first:
            command = self.inputs['pump_command'][0]
            flow = motor.displacement * abs(speed) + motor.leakage(state[1], abs(speed))
            if abs(speed) < 0.2:
                flow = 0.0
            else:
                flow += pump.leakage(state[1], command)
            state[0] = np.clip(flow / pump.shaft_speed, 0.0, pump.max_displacement)
        return state

    def predict(self, drive: Drive, extra: np.ndarray | None = None) -> Prediction:
        """
        Replay the recording.

        Parameters
        ----------
        drive : Drive
            The model.
        extra : ndarray, shape (n,), optional
            Torque added to the load, N.m.

        """
        disturbance = self.disturbance(drive)
        total = disturbance if extra is None else disturbance + extra
        signals = drive.simulate(self.run.time, {**self.inputs, 'load_disturbance': total},
                                 self.start(drive))
        if self.can_correct:
            # The corrected load holds the sensor itself: judge the load model, uncorrected.
            signals[self.torque] = drive.load_torque(
                self.run.time, self.inputs['pprv_command'], self._speed,
                self.inputs['oil_temperature'])
        return Prediction({name: signals[name] for name in self.signals}, disturbance)

    def floor(self, drive: Drive, seed: int = 0) -> dict[str, float]:
        """
        Return the rmse, by signal, that a perfect model would still show.

        Sensor noise, and what the part of the load torque that the smoothing misses does to the
        replay: draws of that part are replayed. Where no torque is measured the roughness of the
        load is not known, and the floor is the sensor noise.

        """
        floor = {name: self.noise[name]**2 for name in self.signals}
        if self.can_correct and self.roughness.std > 0:
            base = self.predict(drive).signals
            random = np.random.default_rng(seed)
            for _ in range(_DRAWS):
                moved = self.predict(drive, self._smoother.draw_error(random)).signals
                for name in self.signals:
                    if name != self.torque:
                        shift = moved[name] - base[name]
                        floor[name] += float(np.nanmean(shift**2)) / _DRAWS
            floor[self.torque] += self.roughness.std**2
        return {name: float(np.sqrt(value)) for name, value in floor.items()}


def _filled(values: np.ndarray, hold: bool = False) -> np.ndarray:
    """Bridge NaN: the last value for commands, a straight line for signals."""
    bad = ~np.isfinite(values)
    if not bad.any():
        return np.ascontiguousarray(values, dtype=float)
    index = np.arange(len(values))
    if not hold:
        return np.interp(index, index[~bad], values[~bad])
    last = np.maximum.accumulate(np.where(bad, -1, index))
    first = int(np.argmax(~bad))
    return values[np.where(last < 0, first, last)]
