# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The load of a recording: what its model gives at the measured speed, and what the sensor shows.

What the sensor shows beyond the model is smoothed; how rough it is tells what smoothing misses. On
a flexible shaft the sensor does not read the load: what lies behind swings (``shaft``).
"""
from __future__ import annotations

from typing import Iterator

from hst_drive.measure.commands import Between
from hst_drive.measure.noise import Coloured, Smoother
from hst_drive.measure.readings import earlier, filled, Readings
from hst_drive.measure.run import Run
from hst_drive.measure.shaft import Behind, behind, load_side
from hst_drive.model import Drive
import numpy as np

DRAWS = 3       # of noise, for what it does to a replay
_LONG = 600.0   # s: of so long a recording one will do


class RecordedLoad:
    """The load torque of a recording; a ``Replay`` sets what it goes by."""

    run: Run
    readings: Readings
    torque: str | None          # the torque signal, if there is one
    # Commands (V), 'oil_temperature' (K) and, if the speed was read, 'motor_angle' (rad), by row.
    inputs: dict[str, np.ndarray]
    between: Between            # the steps of the controller between the rows
    noise: dict[str, float]     # white, of each signal, SI, estimated from the record
    roughness: Coloured         # coloured part of the unexplained load torque, N.m
    can_correct: bool           # whether a torque was read, and how rough it is found
    _measured: np.ndarray       # torque, N.m, gaps bridged
    _speed: np.ndarray          # rad/s, as it was read, or as the model has it
    _turning: np.ndarray        # rows in which the shaft turns
    _creeping: float            # rad/s
    _smoother: Smoother
    _smoothed: tuple[np.ndarray, np.ndarray] | None     # what was smoothed last, and to what

    @property
    def at_rest(self) -> np.ndarray:
        """Where friction and load share the torque as no law tells, so that it is not judged."""
        return np.abs(self._speed) <= self._creeping

    def _load_model(self, drive: Drive, speed: np.ndarray | None = None) -> np.ndarray:
        command = self.between.finer(self.inputs['pprv_command'], command=True)
        time, speed, temperature = (self.between.finer(values) for values in (
            self.run.time, self._true_speed(drive) if speed is None else speed,
            self.inputs['oil_temperature']))
        angle = self.inputs.get('motor_angle')
        if angle is not None:
            angle = self.between.finer(angle)
        return drive.load_torque(time, command, speed, temperature, angle)[::self.between.steps]

    def _true_speed(self, drive: Drive, reading: np.ndarray | None = None) -> np.ndarray:
        """Return the speed (rad/s) behind a reading of it, by default what was measured."""
        if reading is None and 'motor_speed' not in self.run and 'motor_inlet_flow' in self.run:
            return self._speed      # which the flow meter gave
        if reading is None:
            reading = earlier(self.run.time, self._speed, drive.delays.get('motor_speed', 0.0))
        speed = reading - drive.slot('speed_reading', motor_speed=reading,
                                     oil_temperature=self.inputs['oil_temperature'])
        for slot in ('speed_reading_lag', 'speed_reading_series_lag'):
            speed = self.readings.ahead(speed, drive.slot(slot))
        return speed

    def _read_speed(self, drive: Drive) -> np.ndarray:
        """Return the speed (rad/s) as it was read; from flow meter and torque if need be."""
        if 'motor_speed' in self.run:
            return filled(self.run['motor_speed'])
        motor, flow = drive.rig.motor, filled(self.run['motor_inlet_flow'])
        pressure = np.maximum(self._measured, 0.0) / motor.displacement
        return (flow - motor.leakage(pressure, np.abs(flow) / motor.displacement)
                ) / motor.displacement

    def _stated_noise(self, drive: Drive, name: str) -> float:
        """
        Return the most noise (SI) that a sensor of the rig may have in a slow record.

        Below four samples in a period of the hydraulic resonance its ringing looks like noise.
        """
        sensor = drive.rig.sensors.get(name)
        if self.run.sample_time <= 0.5 * np.pi / drive.resonance or not (
                sensor and sensor.noise_std > 0):
            return np.inf
        return float(np.hypot(sensor.noise_std, self.readings.step(name)))

    def _unexplained(self, drive: Drive, load: np.ndarray) -> np.ndarray:
        measured = self.readings.ahead(self._measured, self.readings.lags.get(self.torque, 0.0))
        measured = measured - drive.zeros.get(self.torque, 0.0)
        measured = earlier(self.run.time, measured, drive.delays.get(self.torque, 0.0))
        rest = np.where(self._turning, measured - load, 0.0)
        # Where no torque was read the load model goes on, with what it missed beside the gap.
        return filled(np.where(np.isfinite(self.run[self.torque]), rest, np.nan))

    def _behind(self, drive: Drive, rest: np.ndarray) -> Behind | None:
        """Say what is behind a flexible shaft and how it is read; None where nothing is."""
        if not (drive.has_flexible_shaft and self._turning.any()):
            return None
        stiff, speed = drive.without('shaft_compliance'), self._true_speed(drive)
        side = load_side(drive, self._measured[self._turning],
                         lambda faster: self._load_model(stiff, speed + faster)[self._turning])
        if side is None:
            return None
        # Of the speed that the load is modelled with: the model's own has none.
        noise = (self.noise['motor_speed'] if 'motor_speed' in self.run else
                 self.noise.get('motor_inlet_flow', 0.0) / drive.rig.motor.displacement)
        rest = rest - self.readings.slow(rest)
        return behind(side, self.run.sample_time, rest, min(
            self.readings.noise(self.torque, rest), self._stated_noise(drive, self.torque)), noise)

    def _shaft(self, drive: Drive) -> Behind | None:
        # A stiff one, as most are, asks for no load model.
        return self._behind(drive, self._unexplained(drive, self._load_model(drive))) if (
            drive.has_flexible_shaft) else None

    def misread(self, drive: Drive) -> Coloured:
        """Return by how much (N.m) the torque reading is off the load model's if that is right."""
        shaft = self._shaft(drive)
        if shaft is None:
            return self.roughness._replace(noise_std=self.noise[self.torque])
        return shaft.rough._replace(std=shaft.swings(), noise_std=max(
            shaft.rough.noise_std, self.readings.step(self.torque)))

    def disturbance(self, drive: Drive) -> np.ndarray:
        """Return the load torque (N.m) that the sensor shows beyond the load model, smoothed."""
        if not self.can_correct:
            return np.zeros(len(self.run))
        return self._disturbance(drive, self._load_model(drive))

    def _disturbance(self, drive: Drive, load: np.ndarray) -> np.ndarray:
        rest = self._unexplained(drive, load)
        shaft = self._behind(drive, rest)
        if shaft:
            slow = self.readings.slow(rest)
            return slow + shaft.load(rest - slow)
        # Most effects leave the load as it is: then it need not be smoothed anew.
        known = self._smoothed
        if known is None or not np.array_equal(known[0], rest):
            slow = self.readings.slow(rest)
            known = self._smoothed = rest, slow + self._smoother(rest - slow)
        return known[1]

    def _finely(self) -> Smoother:
        """Return a smoother of the load at all steps: rock moves between rows as well."""
        steps = self.between.steps
        if steps == 1:
            return self._smoother
        time = self.between.finer(self.run.time)
        known = np.zeros(len(time), dtype=bool)
        known[::steps] = np.isfinite(self.run[self.torque])
        return Smoother(time, self.roughness, known)

    @property
    def draws(self) -> int:
        """How often noise is drawn, for what it does to the replay."""
        return DRAWS if self.run.time[-1] - self.run.time[0] < _LONG else 1

    def missed(self, drive: Drive, random: np.random.Generator) -> Iterator[np.ndarray]:
        """Yield draws (N.m) of what the smoothing misses of the load, at all steps."""
        shaft = self._shaft(drive)
        smoother, steps = self._finely(), self.between.steps
        for _ in range(self.draws):
            yield (smoother.draw_error(random) if shaft is None else shaft.draw_error(
                self.run.sample_time / steps, (len(self.run) - 1) * steps + 1, random))
