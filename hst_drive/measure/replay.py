# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Replay of a recording: the measured inputs through the model.

The load is the model's, from the recorded PPRV command, plus what the torque sensor reads beyond
it, smoothed: feeding the raw torque would take away the damping that the PPRV's override gives
and let the sensor's noise ring the lightly damped hydraulic resonance. So even a perfect model
does not reach the sensor noise; ``replay_floor`` is what it would reach.
"""
from __future__ import annotations

import copy
from dataclasses import replace
import operator
from typing import Mapping

from hst_drive.channels import COMMANDS, TORQUES
from hst_drive.errors import InputError
from hst_drive.measure.commands import Between, controller_steps, HELD
from hst_drive.measure.floor import replay_floor
from hst_drive.measure.noise import Coloured, estimate_coloured, Smoother, variance_ratio
from hst_drive.measure.readings import bridged, earlier, filled, later, Readings
from hst_drive.measure.recorded_load import RecordedLoad
from hst_drive.measure.run import Run, shifted
from hst_drive.measure.start import Beginning, first_state
from hst_drive.measure.turns import into_step
from hst_drive.model import Drive, usual_sensors
from hst_drive.model.drive import turned
from hst_drive.rig.rig import STANDSTILL
import numpy as np

SIGNALS: tuple[str, ...] = (
    'pump_outlet_pressure', 'motor_inlet_pressure', 'motor_outlet_pressure', 'motor_inlet_flow',
    'case_drain_flow', 'motor_speed', 'load_torque', 'motor_torque', 'pump_displacement',
    'pump_speed')
STAMPS = 1e-3   # s, to which time stamps are known
_CLEARLY = 0.8      # of the load's roughness: less shows that the speed is read late


class Replay(RecordedLoad):
    """
    A recording, ready to be replayed through models again and again; its load: ``RecordedLoad``.

    The noise of the load and the floor are judged with the drive that is given. InputError is
    raised if the run lacks 'pump_command' or 'pprv_command', or has no signal of ``SIGNALS``.

    Attributes
    ----------
    signals : tuple of str
        Measured signals that the model gives, too.
    stamp_std : float
        How well time stamps and steps of the load are known, s.
    command_time_std : ndarray
        The same of the commands, row by row, s (``Steps.time_std``).
    steps : dict of str to Steps
        Commands as the controller gave them, as far as the rows tell, V.

    """

    extra_std: dict[str, np.ndarray] = {}      # rows that are rougher than usual, SI
    static = False      # rows are of a motion, not operating points

    def __init__(self, run: Run, drive: Drive):
        missing = [name for name in COMMANDS if name not in run]
        if missing:
            raise InputError(f"{run.source}: channel '{missing[0]}' is missing; a replay of the "
                             'whole drive needs pump_command and pprv_command; name the foreign '
                             'column with --channels')
        self.run = run
        self.readings = Readings(run, {**drive.rig.sensors, **usual_sensors(drive.rig)})
        self.signals = tuple(name for name in SIGNALS if name in run)
        if not self.signals:
            raise InputError(f'{run.source}: nothing to compare; expected at least one of '
                             f'{", ".join(SIGNALS)}')
        time = run.time
        self.steps = controller_steps(time, {name: filled(run[name], hold=True)
                                             for name in COMMANDS})
        steps = self.steps.values()
        self.stamp_std = float(np.hypot(STAMPS, max(entry.jitter for entry in steps)))
        self.command_time_std = np.max([entry.time_std(run.sample_time) for entry in steps],
                                       axis=0)
        self.inputs = {name: entry.values for name, entry in self.steps.items()}
        if 'motor_speed' in run:
            self.inputs['motor_angle'] = turned(time, filled(run['motor_speed']))
        self.between = Between.rows(drive.rig, run.sample_time)
        temperature = run.channels.get('oil_temperature')
        if temperature is None:
            temperature = np.full(len(time), drive.rig.characterised_at)
        temperature = bridged('oil_temperature', temperature, run.sample_time)
        self.inputs |= {'oil_temperature': temperature,
                        'viscosity_ratio': drive.rig.viscosity_ratio(temperature)}
        self.noise = {name: self.readings.noise(name, run[name]) for name in self.signals}
        self.torque = next((name for name in TORQUES[::-1] if name in run), None)
        self._creeping = drive.rig.creeping
        self._smoothed: tuple[np.ndarray, np.ndarray] | None = None
        self._early: list[tuple[np.ndarray, dict[str, np.ndarray]]] = []
        self._early_of: tuple = b'', None     # of which drive, and which inputs
        self._predicted: tuple[tuple, tuple, dict[str, np.ndarray]] | None = None
        self._beginning = Beginning.of(
            time, {name: filled(run[name]) for name in self.signals}, self.inputs['pump_command'])
        if self.between.steps > 1:
            # A slow record does not show each command: a straight line between the recorded ones
            # may be nearer to what the drive got than holding the older one. The data decide.
            line, held = (self._misfit(drive, choice) for choice in (False, True))
            self.between = self.between._replace(held=held < HELD * line)
            self.stamp_std = 0.3 * run.sample_time
        self._prepare(drive)
        if 'motor_speed' in run:
            into_step(self, drive)

    def _misfit(self, drive: Drive, held: bool) -> float:
        """Return the squared error over the noise with one way to fill in the commands."""
        self.between = self.between._replace(held=held)
        noise = dict(self.noise)
        self._prepare(drive)
        model = self.predict(drive)
        # Slow errors are the model's; the way to fill in shows in the fast ones.
        misfit = 0.0
        for name in self.signals:
            if name != self.torque:
                rest = filled(model[name] - self.run[name])
                misfit += float(np.median((rest - self.readings.slow(rest))**2)) / noise[name]**2
        self.noise = noise
        return misfit

    def _prepare(self, drive: Drive) -> None:
        """Find the noise, and the part of the load that the model does not explain."""
        self.can_correct = False
        self.simulated = True
        self.roughness = Coloured.white(0.0)
        run = self.run
        if self.torque:
            self._measured = filled(run[self.torque])
            if 'motor_speed' in run or 'motor_inlet_flow' in run:
                self._speed = self._read_speed(drive)
                self._correct(drive)
            else:
                # The load hardly depends on speed: two rounds with the model's own will do.
                for _ in range(2):
                    self._speed = self._simulate(drive, self.disturbance(drive))['motor_speed']
                    self._correct(drive)
        self._refine_noise(drive)

    def _simulate(self, drive: Drive, disturbance: np.ndarray,
                  commands: Mapping[str, np.ndarray] = {},
                  extra: np.ndarray | None = None) -> dict[str, np.ndarray]:
        inputs = {**self.inputs, **commands, 'load_disturbance': disturbance}
        finer = {name: self.between.finer(values, name in COMMANDS)
                 for name, values in inputs.items()}
        if extra is not None:
            finer['load_disturbance'] = finer['load_disturbance'] + extra
        signals = drive.simulate(self.between.finer(self.run.time), finer, self.start(drive))
        return {name: values[::self.between.steps] for name, values in signals.items()}

    def _correct(self, drive: Drive) -> None:
        """Find the coloured part of the unexplained torque, and the sensor's noise in it."""
        self._turning = np.abs(self._speed) > STANDSTILL * drive.rig.full_speed
        load = self._load_model(drive)
        rest = self._unexplained(drive, load)
        if 'motor_speed' in self.run:
            # A late reading of the speed would pass for a rough load.
            speed = self._simulate(drive, self.readings.slow(rest))['motor_speed']
            moved = self._unexplained(drive, self._load_model(
                drive, self._true_speed(drive, speed)))
            late, prompt = (np.std(left - self.readings.slow(left)) for left in (rest, moved))
            if np.isfinite(speed).all() and prompt < _CLEARLY * late:
                rest = moved
        self._smoothed = None
        name = self.torque
        noise = min(self.readings.noise(name, self.run[name]), self.readings.noise(
            name, np.where(self.at_rest, np.nan, rest)), self._stated_noise(drive, name))
        shaft = self._behind(drive, rest)
        # A shaft that stands feels no rough rock.
        fast = np.where(self.at_rest, np.nan, rest - self.readings.slow(rest))
        self.roughness = shaft.rough if shaft else estimate_coloured(self.run.time, fast, noise)
        self.noise[name] = max(self.roughness.noise_std, self.readings.step(name))
        self._smoother = Smoother(self.run.time, self.roughness, np.isfinite(self.run[name]))
        more = variance_ratio(self.run.time, fast, load, self.noise[name],
                              self._turning & np.isfinite(self.run[name]))
        usual = shaft.swings() if shaft else self.roughness.std
        self.extra_std = {name: usual * np.sqrt(np.maximum(more - 1.0, 0.0))}
        self.can_correct = True

    def _refine_noise(self, drive: Drive) -> None:
        """
        Let the model take the motion away that a slow record cannot tell from noise.

        The drive's ringing to the load is not in the model: there the stated noise is the most.
        """
        model = self.predict(drive)
        for name in self.signals:
            if name != self.torque:
                rest = self.run[name] - model[name]
                self.noise[name] = min(self.noise[name], self.readings.noise(name, rest),
                                       self._stated_noise(drive, name))

    def floor(self, drive: Drive, count: np.ndarray | None = None) -> dict[str, float]:
        """Return the rmse, by signal, that a perfect model would still show (``floor``)."""
        return replay_floor(self, drive, count)

    @property
    def sensor_noise(self) -> dict[str, float]:
        """White noise of each sensor, SI."""
        return self.noise

    def counted(self, name: str) -> np.ndarray:
        """Return the rows in which a signal can be judged."""
        valid = np.isfinite(self.run[name])
        return valid & ~self.at_rest if self.can_correct and name == self.torque else valid

    def apart(self, name: str) -> int:
        """Return from how many rows on errors share no noise."""
        return 1

    def of_load(self) -> Replay:
        """Return a replay of the load alone: it meets the measured speed, nothing is simulated."""
        alone = copy.copy(self)
        alone.simulated = False
        alone.signals = (self.torque,) if self.can_correct else ()
        return alone

    def read_earlier(self, signal: str, delay: float) -> None:
        """Move the readings of a signal to an earlier time, s."""
        read = self.run[signal]
        moved = earlier(self.run.time, filled(read), delay)
        self.run = replace(self.run, channels={
            **self.run.channels, signal: np.where(np.isfinite(read), moved, np.nan)})
        self.readings = copy.copy(self.readings)
        self.readings.run = self.run
        if signal == self.torque:
            self._measured = moved

    def command(self, values: np.ndarray) -> None:
        """Take another command of the pump in the place of the recorded one."""
        self.inputs = {**self.inputs, 'pump_command': values}

    def start(self, drive: Drive) -> np.ndarray:
        """Return the state at the first sample, as far as the signals tell it."""
        inputs = {name: float(values[0]) for name, values in self.inputs.items()}
        return first_state(drive, self._beginning, inputs, self.torque)

    def half_a_row_early(self, drive: Drive) -> list[tuple[np.ndarray, dict[str, np.ndarray]]]:
        """Return rows behind which each command steps, and what moves if it does so earlier."""
        key, inputs = self._early_of
        if key != drive.key() or inputs is not self.inputs:
            self._early, base = [], self.predict(drive)
            self._early_of = drive.key(), self.inputs
            for name, steps in self.steps.items():
                command, starts = self.inputs[name], steps.starts(self.run.sample_time)
                moved = self.predict(drive, commands={
                    name: 0.5 * (command + np.append(command[1:], command[-1:]))})
                self._early.append((starts, {
                    signal: moved[signal] - base[signal] for signal in self.signals}))
        return self._early

    def predict(self, drive: Drive, extra: np.ndarray | None = None,
                commands: Mapping[str, np.ndarray] = {}) -> dict[str, np.ndarray]:
        """
        Replay the recording; return the signals that the model gives, SI, by channel.

        ``extra`` is torque added to the load, N.m, at all steps: those between the rows, too.
        ``commands`` stand in place of the recorded ones, V.
        """
        if extra is not None or commands:
            return self._read(drive, self._predict(drive, extra, commands))
        # Noise, floor, zeros and delays of sensors, but of those that tell the load, ask for the
        # same model again.
        numbers, known = (drive.key(), drive.zeros.get(self.torque), *(
            drive.delays.get(name) for name in (self.torque, 'motor_speed'))), self._predicted
        objects = self.inputs, self.readings, self.between, self.roughness, self.signals
        if known is None or known[0] != numbers or any(map(operator.is_not, known[1], objects)):
            known = self._predicted = numbers, objects, self._predict(drive, None, {})
        return self._read(drive, known[2])

    def _read(self, drive: Drive, signals: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return what sensors read that are off at zero, and late."""
        return shifted({name: later(self.run.time, values, drive.delays.get(name, 0.0))
                        for name, values in signals.items()}, drive.zeros)

    def _predict(self, drive: Drive, extra: np.ndarray | None,
                 commands: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        load = self._load_model(drive) if self.can_correct else None
        signals = {}
        if self.simulated:
            disturbance = np.zeros(len(self.run)) if load is None else self._disturbance(
                drive, load)
            signals = self._simulate(drive, disturbance, commands, extra)
        if load is not None:
            # The corrected load holds the sensor itself: judge the load model, uncorrected.
            signals[self.torque] = load
        read = {name: self.readings.as_read(name, signals[name]) for name in self.signals}
        if load is not None:
            read[self.torque] = np.where(self.at_rest, self._measured, read[self.torque])
        return read
