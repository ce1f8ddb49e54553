# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The balances of a part of the drive, over whole records at once.

Each balance predicts one signal from the other measured ones: the torque of a hydromotor from
pressure and speed, the flow of a pump from command and pressure. Effects enter through the same
declarations as in the whole drive. What the rig file of a part leaves out is ideal: no leakage,
an efficiency of 1. All values are SI.
"""
from __future__ import annotations

import copy
import math
from typing import Any, Callable, Mapping

from hst_drive.effects import Effect, effect_of, READABLE
from hst_drive.effects.oil import BULK_MODULUS, DENSITY
from hst_drive.effects.slots import OF_OTHER_CIRCUITS
from hst_drive.model.arrays import evaluate
from hst_drive.model.compose import CONSTANTS
from hst_drive.model.drive import check_effect
from hst_drive.model.kernel_template import of_unit, waved
from hst_drive.model.lags import behind_play, follow, held_share
from hst_drive.model.parameters import actuator_numbers, LOST, WAVED
from hst_drive.rig import Rig
from hst_drive.rig.rig import Line
import numpy as np

Known = Mapping[str, Any]
_STEEP = 3.0    # friction has its sign but for 0.5 % where the speed is no longer creeping


class PartModel:
    """
    A part of the drive: a rig's numbers, effects that are on, factors of this unit.

    Parameters
    ----------
    rig : Rig
        Adopted effects and calibration count.
    effects : mapping of str to mapping of str to float, optional
        More effects, parameters in SI; one that is left out has its typical value.
    factors : mapping of str to float, optional
        Factors by the names of ``rig.tolerances``.

    Raises
    ------
    InputError
        If an effect or a parameter is not known.

    """

    def __init__(self, rig: Rig, effects: Mapping[str, Mapping[str, float]] | None = None,
                 factors: Mapping[str, float] | None = None):
        self.rig, self.zeros, self.delays = rig, rig.zeros, rig.delays
        chosen = self.changed(effects or {}, factors or {})
        self.effects, self.factors = chosen.effects, chosen.factors

    def with_effect(self, name: str, values: Mapping[str, float]) -> PartModel:
        """Return a part with one effect more, or with other parameters (SI) for it."""
        changed = copy.copy(self)
        changed.effects = {**self.effects, name: check_effect(self.rig, name, values)}
        return changed

    def changed(self, effects: Mapping[str, Mapping[str, float]],
                factors: Mapping[str, float]) -> PartModel:
        """Return a part with these effects beside those adopted, and factors on this unit's."""
        changed = copy.copy(self)
        changed.effects = {name: check_effect(self.rig, name, values)
                           for name, values in {**self.rig.effects, **effects}.items()}
        known = self.rig.calibration
        changed.factors = {**known, **{key: known.get(key, 1.0) * value
                                       for key, value in factors.items()}}
        return changed

    def enters(self, name: str) -> bool:
        """Say whether an effect has a place in the equations."""
        return effect_of(name).slot not in OF_OTHER_CIRCUITS

    def factor(self, key: str) -> float:
        """Return the factor of this unit on a quantity."""
        return self.factors.get(key, 1.0)

    @property
    def inertia(self) -> float:
        """Inertia (kg.m^2); 0 where the rig gives none."""
        motor = self.rig.motor
        return (motor.inertia if motor else 0.0) * self.factor('motor.inertia')

    @property
    def motor_displacement(self) -> float:
        """Displacement of the hydromotor (m^3/rad); 0 where the rig gives none."""
        motor = self.rig.motor
        return (motor.displacement if motor else 0.0) * self.factor('motor.displacement')

    def complete(self, known: Known) -> dict[str, Any]:
        """Add the rig's constants, and the viscosity, to what a log knows."""
        rig = self.rig
        found = {'viscosity_ratio': 1.0, **known, 'characterised_at': rig.characterised_at}
        if rig.motor is not None:
            found.update(motor_displacement=self.motor_displacement,
                         pistons=float(rig.motor.pistons))
        if rig.pump is not None:
            found.update(max_displacement=rig.pump.max_displacement,
                         nominal_speed=rig.pump.shaft_speed)
        oil = rig.line or Line()
        found.update(line_volume=oil.volume or math.inf,
                     bulk_modulus=(oil.bulk_modulus or BULK_MODULUS)
                     * self.factor('line.bulk_modulus'), oil_density=oil.oil_density or DENSITY)
        if 'oil_temperature' in known and 'viscosity_ratio' not in known:
            found['viscosity_ratio'] = rig.viscosity_ratio(known['oil_temperature'])
        if rig.relief_valve is not None:
            found['relief_pressure'] = found['rated_pressure'] = rig.rated_pressure
        return found

    def terms(self, slot: str, known: Known) -> Any:
        """Return the sum of the effects at a slot; one that reads what is not known gives 0."""
        total: Any = 0.0
        for name, values in self.effects.items():
            effect = effect_of(name)
            # A formula names all that it could read; what is not known has the power 0.
            spare = dict.fromkeys(READABLE, 0.0) if effect.searched == 'never' else {}
            for place, function in effect.terms:
                if place == slot:
                    total = total + evaluate(function, {**spare, **known, **values})
        return total

    def motor_leakage(self, known: Known) -> Any:
        """Return what the hydromotor leaks into its case from its inlet, m^3/s."""
        known = {**known, 'pressure': np.maximum(known['pressure'], 0.0)}
        table = self.factor('motor.leakage') * self.rig.motor.leakage(
            known['pressure'], np.abs(known['motor_speed']))
        flow = self.motor_displacement * known['motor_speed'] + table
        return table + self.terms('motor_flow_loss', {
            **known, 'motor_leakage': table, 'flow': flow})

    def case_drain(self, known: Known) -> Any:
        """Return what the hydromotor leaks into its case from both ports, m^3/s."""
        # What it takes along to its outlet is not drained.
        drained = self._with(lambda effect: not effect.kept)
        if 'outlet_pressure' not in known:
            # Of a difference of two ports the one under pressure counts.
            return drained.motor_leakage({**known, 'pressure': np.abs(known['pressure'])})
        # What a formula takes it takes once.
        listed = drained._with(lambda effect: effect.searched != 'never')
        return drained.motor_leakage(known) + listed.motor_leakage({
            **known, 'pressure': known['outlet_pressure']})

    def _with(self, wanted: Callable[[Effect], bool]) -> PartModel:
        """Return the model with the effects that are wanted."""
        other = copy.copy(self)
        other.effects = {name: values for name, values in self.effects.items()
                         if wanted(effect_of(name))}
        return other

    def line_drop(self, known: Known) -> Any:
        """Return the pressure lost between the pump and the hydromotor, Pa."""
        return self.terms('line_drop', known)

    def motor_torque(self, known: Known) -> Any:
        """Return the torque of the hydromotor without that of its inertia, N.m."""
        speed, pressure = known['motor_speed'], known.get('pressure', 0.0)
        hydraulic: Any = 0.0
        direction = _direction(known)
        if 'pressure' in known:
            outlet = known.get('outlet_pressure')
            if outlet is not None:
                known = {**known, 'pressure': pressure - outlet}
            back = self.terms('back_pressure', known) if outlet is None else 0.0
            # A cavitating inlet neither drives nor brakes.
            net = np.maximum(known['pressure'] - back, np.minimum(known['pressure'], 0.0))
            more = self.terms('loss_pressure', known)
            motor, under, ideal = self.rig.motor, np.abs(net) + more, net * self.motor_displacement
            coefficients = motor.torque_loss
            efficiency = evaluate(of_unit, {
                'efficiency': 1.0 - coefficients[2] if coefficients else
                motor.mechanical_efficiency(under, np.abs(speed)),
                'pressure': under, 'rated_pressure': self.rig.rated_pressure,
                'motor_efficiency_scale': self.factor('motor.mechanical_efficiency'),
                **{number: self.factor(key) for key, number in LOST.items()}})
            lost = (1.0 - efficiency) * under * self.motor_displacement
            if coefficients:
                # They tell what is lost without a pressure, too.
                coulomb, viscous, _ = coefficients
                lost = (1.0 - efficiency) * np.abs(ideal) + self.factor('motor.torque_loss') * (
                    coulomb + viscous * np.abs(speed))
            # What is lost brakes, whether oil drives the shaft or the shaft the oil.
            hydraulic = ideal - lost * np.where(speed == 0.0, np.sign(ideal), direction)
        return (hydraulic + self.terms('motor_torque', known)
                - self.terms('motor_torque_loss', known) * direction)

    def stroke(self, time: np.ndarray | None, command: np.ndarray, known: Known) -> np.ndarray:
        """
        Return the pump's displacement (m^3/rad) for a command.

        Parameters
        ----------
        time : ndarray or None
            s; None for operating points, where all has settled.
        command : ndarray
            V.
        known : mapping
            What effects of the actuator may read, and where the plate 'rests_at' first and
            'starts_at', m^3/rad.

        """
        pump = self.rig.pump
        command = command + self.terms('pump_command', {**known, 'pump_command': command})
        if time is None:
            return self._yielding(command, known)
        play = float(np.max(self.terms('pump_play', known)))
        if play > 0:
            softness, spread = (float(np.max(self.terms(slot, known))) for slot in (
                'pump_play_softness', 'pump_play_spread'))
            rests = command[0] if 'rests_at' not in known else float(pump.command_of(
                known['rests_at'] / self.factor('pump.displacement_vs_command')))
            command = np.mean([behind_play(command, 0.5 * play * (1.0 + side), softness, rests)
                               for side in ((-spread, spread) if spread else (0.0,))], axis=0)
        target = self._yielding(command, known)
        own = self.factor('pump.displacement_lag') * pump.displacement_lag
        lag = max(own + float(np.max(self.terms('pump_lag', known))), 1e-6)
        series = max(self.factor('pump.displacement_series_lag') - 1.0, 0.0) * own + float(
            np.max(self.terms('pump_series_lag', known)))
        if series > 0:
            # What follows holds its input between samples.
            target = target + (follow(time, target, series) - target) * evaluate(held_share, {
                'series_lag': series, 'lag': lag, 'interval': np.diff(time, append=np.inf)})
        full, asymmetry = (float(np.max(self.terms(slot, known)))
                           for slot in ('pump_stroke_time', 'pump_stroke_asymmetry'))
        mean = pump.max_displacement / full if full > 0 else np.inf
        return follow(time, target, lag, mean * (1 + asymmetry), mean * (1 - asymmetry),
                      start=known.get('starts_at'))

    def _yielding(self, command: np.ndarray, known: Known) -> np.ndarray:
        """Return the displacement (m^3/rad) on which the plate settles under pressure."""
        curve = self.rig.pump.displacement
        asked = self.factor('pump.displacement_vs_command') * evaluate(waved, {
            **actuator_numbers(curve), 'value': curve(command), 'command': command,
            **{number: self.factor(key) for key, number in WAVED.items()}})
        return np.maximum(asked - self.terms('pump_yield', {**known, 'displacement': asked}), 0.0)

    def pump_speed(self, known: Known) -> Any:
        """Return the speed of the pump's shaft, rad/s: as measured, or as the rig gives it."""
        speed = known.get('pump_speed')
        return self.rig.pump.shaft_speed + self.terms('pump_speed', known) if (
            speed is None) else speed

    def pump_torque(self, known: Known) -> Any:
        """Return the torque (N.m) that drives a pump of known stroke; ISO 4391's sign."""
        pressure, speed = known['pump_pressure'], self.pump_speed(known)
        ideal = known['displacement'] * pressure
        lost = (1.0 / self.rig.pump.mechanical_efficiency(np.abs(pressure), np.abs(speed)) - 1.0)
        return ideal + lost * np.abs(ideal) + self.terms('pump_torque_loss', {
            **known, 'pump_speed': speed})

    def pump_flow(self, known: Known) -> Any:
        """Return the oil that a pump of known stroke and speed delivers, m^3/s."""
        pump, pressure = self.rig.pump, known['pump_pressure']
        command = known.get('pump_command')
        if command is None and pump.displacement is None:
            command = pump.leakage.y[-1]
        elif command is None:
            command = pump.command_of(known['displacement'])
        leakage = self.factor('pump.leakage') * pump.leakage(pressure, command)
        known = {**known, 'pump_leakage': leakage}
        speed = self.pump_speed(known)
        relief: Any = 0.0
        valve = self.rig.relief_valve
        if valve is not None:
            # Eq. (2) of the drill-drive paper.
            head = np.maximum(pressure - valve.reference_pressure, 0.0) / known['oil_density']
            relief = np.where(
                pressure > valve.set_pressure,
                valve.discharge_coefficient * valve.area * np.sqrt(2 * head), 0.0)
        ideal = known['displacement'] * speed
        return ideal - leakage - relief - self.terms('pump_flow_loss', {
            **known, 'pump_speed': speed, 'flow': known.get('flow', ideal)})

    def braking_torque(self, time: np.ndarray | None, command: np.ndarray, known: Known) -> Any:
        """Return the torque (N.m) with which the loading unit brakes; ``time`` as of stroke."""
        loading = self.rig.loading
        valve = self.factor('loading.pprv_pressure') * loading.pprv_pressure(command)
        if time is not None:
            valve = follow(time, valve, self.factor('loading.pprv_lag') * loading.pprv_lag)
        displacement = loading.gear_ratio * loading.pump_displacement
        pressure = np.maximum(valve + self.factor(
            'loading.pprv_override') * loading.pprv_override * (
                displacement * np.abs(known['motor_speed']) - loading.pprv_reference_flow), 0.0)
        torque = pressure * displacement / (
            self.factor('loading.pump_mechanical_efficiency')
            * loading.pump_mechanical_efficiency(pressure))
        torque = torque + self.terms('load_torque', {**known, 'load_torque': torque})
        return torque * _direction(known)

    def capacity(self, known: Known) -> Any:
        """Return the oil that the line takes per rise of pressure, m^3/Pa; 0 without a line."""
        line = self.rig.line
        if line is None:
            return 0.0
        bend = self.factor('line.compressibility_under_pressure') - 1.0
        bent = 1.0 + bend * known.get('pump_pressure', 0.0) / CONSTANTS['OIL_BENDS_AT']
        return line.volume * (bent / known['bulk_modulus'] + self.terms('compliance', known))


def _direction(known: Known) -> Any:
    """Return the sense of rotation, smooth where the shaft creeps."""
    speed = known['motor_speed']
    creeping = known.get('creeping', _STEEP * CONSTANTS['SIGN_WIDTH'])
    return np.tanh(_STEEP * speed / creeping) if creeping else np.sign(speed)
