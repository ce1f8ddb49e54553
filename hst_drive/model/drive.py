# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole drive: a rig, the effects that are switched on, and its motion in time."""
from __future__ import annotations

import copy
from typing import Any, Mapping

from hst_drive.effects import catalogue, effect_of, flexible, unknown_effect
from hst_drive.effects.base import arguments
from hst_drive.errors import InputError
from hst_drive.model.compose import kernel, OUTPUTS, STATES
from hst_drive.model.parameters import baseline_parameters, baseline_tables, INDEX, SCALED
from hst_drive.rig import Rig
import numpy as np

MAX_STEP = 2.5e-3   # s; halving it moves no reading by more than 1e-4 of its range


def turned(time: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Return the angle (rad) that a shaft has turned since the first of its speeds (rad/s)."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])


def check_effect(rig: Rig, name: str, values: Mapping[str, float] | None) -> dict[str, float]:
    """
    Return all parameters of an effect; one that is left out has its typical value.

    Raises
    ------
    InputError
        If the effect or a parameter is not known.

    """
    effects = catalogue(everything=True)
    if name not in effects:
        raise InputError(f"{rig.source or 'effects'}: {unknown_effect(name)}")
    known = {entry.name: entry for entry in effects[name].sized(*rig.sizes).parameters}
    for key in values or {}:
        if key not in known:
            raise InputError(f"{rig.source or 'effects'}: effect '{name}' has no parameter "
                             f"'{key}'; it has {', '.join(known)}")
    return {key: float((values or {}).get(key, parameter.typical))
            for key, parameter in known.items()}


class Drive:
    """
    Variable pump, oil volume, relief valve, hydromotor and loading unit.

    Parameters
    ----------
    rig : Rig
        All sections of the drive must be there. Effects that the rig has adopted are on.
    effects : mapping of str to mapping of str to float, optional
        More effects: id to parameters in SI; a parameter that is left out has its typical value.
    max_step : float
        Longest integration step, s.
    compiled : bool, optional
        Force numba (True) or plain Python (False).

    Raises
    ------
    InputError
        If a section of the rig is missing, or an effect or parameter is not known.

    """

    def __init__(self, rig: Rig, effects: Mapping[str, Mapping[str, float]] | None = None, *,
                 max_step: float = MAX_STEP, compiled: bool | None = None):
        self.rig, self.zeros, self.delays = rig, rig.zeros, rig.delays
        self.max_step = max_step
        self.kernel = kernel(compiled)
        self.effects: dict[str, dict[str, float]] = {}
        self.parameters, self.switches = self.kernel.vectors(baseline_parameters(rig), {})
        self.tables = baseline_tables(rig)
        for name, values in {**rig.effects, **(effects or {})}.items():
            self.switch_on(name, values)

    def switch_on(self, name: str, values: Mapping[str, float] | None = None) -> None:
        """Add an effect, or change its parameters (SI)."""
        self.effects[name] = check_effect(self.rig, name, values)
        self.kernel.switch_on(name, self.effects[name], self.parameters, self.switches)

    def with_effect(self, name: str, values: Mapping[str, float]) -> Drive:
        """Return a drive with one effect more, or with other parameters (SI) for it."""
        return self.changed({name: values}, {})

    def changed(self, effects: Mapping[str, Mapping[str, float]],
                factors: Mapping[str, float]) -> Drive:
        """Return a drive with these effects beside its own, and factors on this unit's."""
        changed = self.copied()
        changed.scale(factors)
        for name, values in effects.items():
            changed.switch_on(name, values)
        return changed

    def without(self, slot: str) -> Drive:
        """Return a drive whose equations pass a slot by; its list of effects stays."""
        changed = self.copied()
        changed.switches[self.kernel.slots[slot]] = 0
        return changed

    def copied(self) -> Drive:
        """Return a drive that can be changed while others use this one."""
        other = copy.copy(self)
        other.parameters, other.switches = self.parameters.copy(), self.switches.copy()
        other.effects = dict(self.effects)
        return other

    @property
    def resonance(self) -> float:
        """Hydraulic resonance of the oil between pump and hydromotor, rad/s."""
        motor, line = self.rig.motor, self.rig.line
        return motor.displacement * (line.bulk_modulus / (line.volume * motor.inertia))**0.5

    @property
    def has_flexible_shaft(self) -> bool:
        """Whether a part of the inertia lies behind a shaft that twists."""
        return flexible(self.effects)

    def slot(self, slot: str, **known: Any) -> Any:
        """
        Return the sum of the effects at a slot, but for those that read what is not given.

        ``known`` maps what they may read (``READABLE``, SI) to numbers, or to arrays of one shape
        where their functions are plain arithmetic.
        """
        total: Any = 0.0
        for name, values in self.effects.items():
            for place, function in effect_of(name).terms:
                given = {**known, **values}
                if place == slot and set(arguments(function)) <= set(given):
                    total += function(*(given[key] for key in arguments(function)))
        return total

    def pump_yield(self, pressure: float, displacement: float) -> float:
        """Return what a pressure (Pa) takes from the pump's displacement (m^3/rad)."""
        return float(self.slot('pump_yield', pump_pressure=pressure, displacement=displacement,
                               max_displacement=self.rig.pump.max_displacement))

    def scale(self, factors: Mapping[str, float]) -> None:
        """Multiply what a unit may differ in: ``{'motor.leakage': 1.05}`` and its kind."""
        for key, factor in factors.items():
            self.parameters[INDEX[SCALED[key]]] *= factor

    def load_torque(self, time: np.ndarray, pprv_command: np.ndarray, motor_speed: np.ndarray,
                    oil_temperature: np.ndarray,
                    motor_angle: np.ndarray | None = None) -> np.ndarray:
        """
        Return the torque reading (N.m) that the load model gives at a recorded speed.

        All arrays have shape (n,): s, V, rad/s, K, and rad, by default as the speed has turned it.
        """
        out = np.empty(len(time))
        if motor_angle is None:
            motor_angle = turned(time, motor_speed)
        self.kernel.module.load_record(
            *(np.ascontiguousarray(values, dtype=float)
              for values in (time, pprv_command, motor_speed, oil_temperature, motor_angle)),
            self.parameters, self.switches, *self._fresh_tables(), out)
        return out

    def load_at(self, pprv_command: float, motor_speed: float, oil_temperature: float) -> float:
        """Return the torque reading (N.m) of a load that has settled: V, rad/s, K."""
        return float(self.load_torque(np.zeros(1), *(np.full(1, value) for value in (
            pprv_command, motor_speed, oil_temperature)))[0])

    def key(self) -> bytes:
        """Return the numbers that its motion hangs on: the same, the same drive."""
        return b''.join([self.parameters.tobytes(), self.switches.tobytes(),
                         self.tables[0].tobytes()])

    def initial_state(self, *, pump_command: float = 0.0, pprv_command: float = 0.0,
                      pressure: float | None = None, speed: float = 0.0) -> np.ndarray:
        """
        Return a state of the drive, at rest unless told otherwise.

        Parameters
        ----------
        pump_command, pprv_command : float
            V; the swash plate and the PPRV have settled on them.
        pressure : float, optional
            Pa; by default the PPRV's.
        speed : float
            Hydromotor, rad/s.

        """
        pprv_pressure = self.rig.loading.pprv_pressure(pprv_command)
        scale = self.parameters[INDEX['displacement_scale']]
        pressure = pprv_pressure if pressure is None else pressure
        state = np.zeros(len(STATES))
        asked = scale * self.rig.pump.displacement(pump_command)
        state[:4] = (max(asked - self.pump_yield(pressure, asked), 0.0), pressure, speed,
                     self.parameters[INDEX['pprv_pressure_scale']] * pprv_pressure)
        state[5] = state[7] = state[13] = speed
        state[8] = state[9] = state[11] = pump_command
        state[10] = np.nan      # the pump shaft has settled on what the load asks
        state[12] = np.nan      # and the pump's control on the command
        state[14:] = np.nan     # and the line on what flows through it
        return state

    def simulate(self, time: np.ndarray, inputs: Mapping[str, np.ndarray],
                 state: np.ndarray | None = None) -> dict[str, np.ndarray]:
        """
        Run the drive over a record.

        Parameters
        ----------
        time : ndarray, shape (n,)
            s, strictly rising.
        inputs : mapping of str to ndarray, shape (n,)
            'pump_command', 'pprv_command' (V), 'oil_temperature' (K, by default that of the
            tables), its 'viscosity_ratio' where that is known, 'load_disturbance' (N.m, by
            default none) and 'motor_angle' (rad, by default integrated). Commands hold until the
            next sample; the disturbance moves on a straight line.
        state : ndarray, optional
            Where to start; at the end it holds the last state. By default at rest.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            Readings without noise by channel name, SI, and inner quantities (``OUTPUTS``). NaN
            from where the motion left all bounds.

        """
        time = np.ascontiguousarray(time, dtype=float)
        n = len(time)
        commands = [np.ascontiguousarray(inputs[name], dtype=float)
                    for name in ('pump_command', 'pprv_command')]
        known = {'oil_temperature': np.full(n, self.rig.characterised_at),
                 'load_disturbance': np.zeros(n), 'motor_angle': np.full(n, np.nan), **inputs}
        if 'viscosity_ratio' not in known:
            known['viscosity_ratio'] = self.rig.viscosity_ratio(known['oil_temperature'])
        others = [np.ascontiguousarray(known[name], dtype=float) for name in (
            'oil_temperature', 'viscosity_ratio', 'load_disturbance', 'motor_angle')]
        if state is None:
            state = self.initial_state(pump_command=commands[0][0], pprv_command=commands[1][0])
        out = np.empty((n, len(OUTPUTS)))
        self.kernel.module.simulate(
            time, *commands, *others, state, self.parameters, self.switches,
            *self._fresh_tables(), self.max_step, out)
        readings = {name: out[:, index] for index, name in enumerate(OUTPUTS)}
        readings['motor_torque'] = readings['load_torque']
        return readings

    def _fresh_tables(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the tables for one call, which notes there in which cells it looked last."""
        cells, layout = self.tables
        return cells, layout.copy()

    def advance(self, state: np.ndarray, duration: float, *, pump_command: float,
                pprv_command: float, oil_temperature: float | None = None,
                load_disturbance: float = 0.0) -> np.ndarray:
        """Return the state after ``duration`` (s) with the inputs (V, V, K, N.m) held."""
        state = state.copy()
        self._two(state, duration, pump_command, pprv_command, oil_temperature, load_disturbance)
        return state

    def outputs(self, state: np.ndarray, *, pump_command: float, pprv_command: float,
                oil_temperature: float | None = None,
                load_disturbance: float = 0.0) -> dict[str, float]:
        """Return the readings without noise in a state, SI, by the names of ``simulate``."""
        readings = self._two(state.copy(), 1e-9, pump_command, pprv_command, oil_temperature,
                             load_disturbance)
        return {name: float(values[0]) for name, values in readings.items()}

    def _two(self, state, duration, pump_command, pprv_command, oil_temperature, disturbance):
        if oil_temperature is None:
            oil_temperature = self.rig.characterised_at
        inputs = {'pump_command': pump_command, 'pprv_command': pprv_command,
                  'oil_temperature': oil_temperature, 'load_disturbance': disturbance,
                  'viscosity_ratio': self.rig.viscosity_ratio(oil_temperature)}
        return self.simulate(np.array([0.0, duration]),
                             {name: np.full(2, value) for name, value in inputs.items()}, state)
