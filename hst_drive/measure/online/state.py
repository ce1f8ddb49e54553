# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the model makes of one block: each balance, and how terms of effects would move it."""
from __future__ import annotations

from typing import Any

from hst_drive.measure.online.figures import FLOW, INLET, PRESSURE, SPEED, TORQUE
from hst_drive.measure.online.stream import Window
from hst_drive.model.part import PartModel
import numpy as np

STROKE, DRAIN = 'pump_displacement', 'case_drain_flow'
Balanced = tuple[float, dict[str, float], float, float]


class State:
    """
    One block: its samples, weights and what the model makes of them.

    A method by the name of a balance returns the residual (measured minus model), how it moves
    with each tolerance and sensor offset, the white noise of a sample, and how fast the balance
    changes (per s); all SI.

    Parameters
    ----------
    model : PartModel
        The drive.
    names : tuple of str
        Balances that are asked for; each method leaves behind what later ones read.
    noise : dict of str to float
        White noise by signal, SI.
    window : Window
        The block and what comes before it.
    inside : ndarray of bool
        Samples of the block.
    cut : dict of str to ndarray
        Signals in the block.
    level, rate : ndarray
        Weights of a mean and of a mean rate.

    """

    def __init__(self, model: PartModel, names: tuple[str, ...], noise: dict[str, float],
                 window: Window, inside: np.ndarray, cut: dict[str, np.ndarray],
                 level: np.ndarray, rate: np.ndarray):
        self.rig, self.model, self.names, self._noise = model.rig, model, names, noise
        self.window, self.inside, self.cut = window, inside, cut
        self.level, self.rate = level, rate
        self.left = float(np.sqrt(level @ level))
        self.length = float(window.time[inside][-1] - window.time[inside][0])
        known: dict[str, Any] = {name: cut[name] for name in (
            SPEED, 'pump_command', 'pprv_command', 'oil_temperature', 'pump_speed')
            if name in cut}
        known.setdefault('oil_temperature', np.full(len(level), self.rig.characterised_at))
        if SPEED in cut:
            known['motor_angle'] = np.cumsum(cut[SPEED]) * self.length / max(len(level) - 1, 1)
        known = self.model.complete(known)
        if PRESSURE in cut:
            reading = cut[PRESSURE]
            known['pump_pressure'] = reading - self.model.terms(
                'pressure_reading', {**known, 'pressure': reading, 'pump_pressure': reading})
        if FLOW in cut:
            known['flow'] = cut[FLOW] - self.model.terms(
                'flow_reading', {**known, 'flow': cut[FLOW]})
        if INLET in cut:
            known['pressure'] = cut[INLET]
        elif PRESSURE in cut:
            known['pressure'] = known['pump_pressure'] - self.model.line_drop(
                {**known, 'pressure': known['pump_pressure']})
        self.known = known

    def mean(self, values) -> float:
        """Return the weighted mean."""
        return float(np.sum(self.level * values))

    def slope(self, values) -> float:
        """Return the weighted mean of the rate of change, per s."""
        return float(self.rate @ values)

    def change(self, values) -> float:
        """Return how fast something changes within the block, per s."""
        return float(np.ptp(values)) / max(self.length, 1e-9) if np.ndim(values) else 0.0

    def noise(self, name: str) -> float:
        """Return the white noise of a signal."""
        return self._noise.get(name, 0.0)

    def _stroke_of(self) -> np.ndarray:
        """Return the displacement that the model gives for the command."""
        if not hasattr(self, '_stroke'):
            command = self.window.values['pump_command']
            known = {name: value for name, value in self.known.items() if np.ndim(value) == 0}
            if PRESSURE in self.cut:
                known['pump_pressure'] = self.window.values[PRESSURE]
            self._stroke = self.model.stroke(self.window.time, command, known)[self.inside]
        return self._stroke

    def pump_flow(self) -> Balanced:
        """Return the balance of the oil that the pump delivers."""
        known = dict(self.known)
        measured = STROKE in self.cut
        displacement = self.cut[STROKE] if measured else self._stroke_of()
        known['displacement'] = displacement
        self.known['displacement'] = displacement
        speed = known.get('pump_speed', self.rig.pump.shaft_speed)
        flow = self.model.pump_flow(known)
        leak = self.model.factor('pump.leakage') * self.rig.pump.leakage(
            known['pump_pressure'], known['pump_command'])
        self.known['pump_leakage'] = leak
        squeezed = self.mean(self.model.capacity(known)) * self.slope(known['pump_pressure'])
        value = self.mean(known['flow'] - flow) + squeezed
        turned = self.mean(displacement * speed)
        parts = {'pump.leakage': -self.mean(leak), 'line.bulk_modulus': squeezed,
                 'sensor.flow': self.mean(known['flow'])}
        if not measured:
            lag = self.rig.pump.displacement_lag
            parts['pump.displacement_vs_command'] = turned
            parts['pump.displacement_lag'] = -lag * self.slope(displacement * speed)
        return value, parts, self.noise(FLOW), self.change(displacement * speed)

    def motor_flow(self) -> Balanced:
        """Return the balance of the oil that the hydromotor takes."""
        known, model = self.known, self.model
        leak = model.motor_leakage(known)
        turned = model.motor_displacement * known[SPEED]
        table = model.factor('motor.leakage') * self.rig.motor.leakage(
            known['pressure'], np.abs(known[SPEED]))
        known['motor_leakage'] = table
        noise = np.hypot(self.noise(FLOW), model.motor_displacement * self.noise(SPEED))
        return (self.mean(known['flow'] - turned - leak),
                {'motor.displacement': self.mean(turned), 'motor.leakage': self.mean(table),
                 'sensor.flow': self.mean(known['flow'])}, noise, self.change(turned))

    def motor_torque(self) -> Balanced:
        """Return the balance of torque at the hydromotor shaft."""
        known, model = self.known, self.model
        made = model.motor_torque(known)
        inertial = model.inertia * self.slope(known[SPEED])
        reading = made + model.terms('torque_reading', {**known, 'load_torque': self.cut[TORQUE]})
        per_pressure = self.mean(made) / max(self.mean(known['pressure']), 1.0)
        noise = np.hypot(self.noise(TORQUE), per_pressure * self.noise(PRESSURE))
        self.per_pressure = per_pressure
        return (self.mean(self.cut[TORQUE] - reading) + inertial,
                {'motor.displacement': self.mean(made),
                 'motor.mechanical_efficiency': self.mean(made), 'motor.inertia': -inertial,
                 'sensor.pressure': -per_pressure, 'sensor.torque': 1.0},
                noise, self.change(known[SPEED]) * model.inertia / max(self.length, 1e-9))

    def load_torque(self) -> Balanced:
        """Return what the torque sensor reads beyond the loading unit."""
        loading, model = self.rig.loading, self.model
        settled = model.factor('loading.pprv_pressure') * loading.pprv_pressure(
            self.window.values['pprv_command'])
        lag = model.factor('loading.pprv_lag') * loading.pprv_lag
        valve = _lagged(self.window.time, settled, lag)[self.inside]
        over = model.factor('loading.pprv_override') * loading.pprv_override * (
            loading.gear_ratio * loading.pump_displacement * np.abs(self.known[SPEED])
            - loading.pprv_reference_flow)
        pressure = np.maximum(valve + over, 0.0)
        torque = pressure * loading.pump_displacement * loading.gear_ratio / (
            model.factor('loading.pump_mechanical_efficiency')
            * loading.pump_mechanical_efficiency(pressure))
        known = {**self.known, 'load_torque': torque}
        torque = torque + model.terms('load_torque', known)
        known['load_torque'] = torque
        reading = torque + model.terms('torque_reading', known)
        per = torque / np.maximum(pressure, 1.0)
        return (self.mean(self.cut[TORQUE] - reading),
                {'loading.pprv_pressure': self.mean(per * valve),
                 'loading.pprv_override': self.mean(per * over),
                 'loading.pump_mechanical_efficiency': -self.mean(torque),
                 'loading.pprv_lag': -lag * self.slope(torque), 'sensor.torque': 1.0},
                self.noise(TORQUE), self.change(torque))

    def pump_displacement(self) -> Balanced:
        """Return the balance of the stroke."""
        stroke = self._stroke_of()
        self.known['displacement'] = stroke
        lag = self.rig.pump.displacement_lag
        return (self.mean(self.cut[STROKE] - stroke),
                {'pump.displacement_vs_command': self.mean(stroke),
                 'pump.displacement_lag': -lag * self.slope(stroke)},
                self.noise(STROKE), self.change(stroke))

    def case_drain_flow(self) -> Balanced:
        """Return the balance of the case drain."""
        leak = self.model.motor_leakage(self.known)
        return (self.mean(self.cut[DRAIN] - leak), {'motor.leakage': self.mean(leak)},
                self.noise(DRAIN), self.change(leak))

    def line_pressure(self) -> Balanced:
        """Return the pressure drop of the line beyond the model."""
        drop = self.known['pump_pressure'] - self.cut[INLET]
        return (self.mean(drop - self.model.line_drop(self.known)), {'sensor.pressure': 1.5},
                np.hypot(self.noise(PRESSURE), self.noise(INLET)), self.change(drop))

    def means(self) -> dict[str, float]:
        """Return the means of all that effects may read."""
        known = {name: self.mean(value) if np.ndim(value) else float(value)
                 for name, value in self.known.items()}
        known.setdefault('load_torque', self.mean(self.cut[TORQUE]) if TORQUE in self.cut else 0.0)
        known.setdefault('pump_speed', known.get('nominal_speed', 0.0))
        return known

    def slopes(self) -> dict[str, dict[str, float]]:
        """Return how a term at a slot of the effects moves each residual, per unit."""
        rig, known, names = self.rig, self.known, self.names
        found: dict[str, dict[str, float]] = {}

        def add(slot: str, balance: str, slope: float) -> None:
            if balance in names:
                found.setdefault(slot, {})[balance] = slope

        if 'pump_command' in known and rig.pump is not None:
            table = rig.pump.displacement
            steep = self.mean(table(known['pump_command'] + 0.05)
                              - table(known['pump_command'] - 0.05)) / 0.1
            speed = self.mean(known.get('pump_speed', rig.pump.shaft_speed))
            stroke = 'pump_displacement' if STROKE in self.cut else 'pump_flow'
            per_stroke = 1.0 if STROKE in self.cut else speed
            add('pump_command', stroke, steep * per_stroke)
            add('pump_yield', stroke, -per_stroke)
            add('pump_lag', stroke, -self.slope(known.get('displacement', 0.0 * self.level))
                * per_stroke)
            if 'pump_speed' not in self.cut and 'displacement' in known:
                add('pump_speed', 'pump_flow', self.mean(known['displacement']))
        add('pump_flow_loss', 'pump_flow', -1.0)
        if 'pump_flow' in names and rig.line is not None:
            add('compliance', 'pump_flow', -rig.line.volume * self.slope(known['pump_pressure']))
        add('motor_flow_loss', 'motor_flow', 1.0)
        add('motor_flow_loss', 'case_drain_flow', 1.0)
        per_pressure = getattr(self, 'per_pressure', 0.0)
        if INLET not in self.cut:
            add('line_drop', 'motor_torque', -per_pressure)
            add('pressure_reading', 'motor_torque', -per_pressure)
        add('line_drop', 'line_pressure', 1.0)
        add('pressure_reading', 'line_pressure', 1.0)
        add('back_pressure', 'motor_torque', -per_pressure)
        add('motor_torque_loss', 'motor_torque', -1.0)
        add('load_torque', 'load_torque', 1.0)
        for slot, balances in (('flow_reading', ('pump_flow', 'motor_flow')),
                               ('torque_reading', ('motor_torque', 'load_torque'))):
            for balance in balances:
                add(slot, balance, 1.0)
        return found


def _lagged(time: np.ndarray, target: np.ndarray, lag: float) -> np.ndarray:
    """Return a first-order lag of a command that is held between samples."""
    out, value = np.empty(len(time)), float(target[0])
    keep = np.exp(-np.append(np.diff(time), 0.0) / max(lag, 1e-6))
    for k, (goal, share) in enumerate(zip(target.tolist(), keep.tolist())):
        out[k] = value
        value = goal + (value - goal) * share
    return out
