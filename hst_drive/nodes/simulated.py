# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The drive of the plant's node, by circuit: what it takes, and what it gives at each step."""
from __future__ import annotations

from collections.abc import Mapping
import math

from hst_drive.effects import effect_of
from hst_drive.errors import InputError
from hst_drive.measure.circuit_balances import misread
from hst_drive.model import Drive
from hst_drive.model.circuit_model import CircuitModel
from hst_drive.model.compose import CONSTANTS, STATES
from hst_drive.model.steady import operating_point
from hst_drive.rig import Rig
import numpy as np

_ANGLE = STATES.index('motor_angle')
Effects = Mapping[str, Mapping[str, float]] | None


class OpenDrive:
    """
    The open circuit with its loading unit.

    Attributes
    ----------
    takes : dict of str to str
        Input by topic.
    bounded : tuple of str
        Quantities that are finite as long as the motion is.

    """

    takes = {'pump_command': 'pump_command', 'pprv_command': 'pprv_command',
             'oil_temperature_command': 'oil_temperature'}
    bounded = ('motor_speed', 'pump_outlet_pressure')

    def __init__(self, rig: Rig, effects: Effects):
        self._drive = Drive(rig, effects)

    def start(self, speed: float, pprv_command: float) -> np.ndarray:
        """Return the state at rest, or of a steady run at a speed (rad/s) and a load (V)."""
        return (operating_point(self._drive, speed, pprv_command=pprv_command).state if speed
                else self._drive.initial_state())

    def simulate(self, times: np.ndarray, inputs: Mapping[str, np.ndarray], state: np.ndarray
                 ) -> dict[str, np.ndarray]:
        """Return all quantities (SI) at both ends of a step; ``state`` then is that of its end."""
        found = self._drive.simulate(times, inputs, state)
        return {**found, 'motor_angle': np.full(len(times), state[_ANGLE])}


class ClosedDrive:
    """The closed circuit; what turns against it is a torque that opposes the motion."""

    takes = {'pump_command': 'pump_command', 'load_torque_command': 'opposing_torque',
             'oil_temperature_command': 'oil_temperature'}
    bounded = ('motor_speed', 'line_a_pressure', 'line_b_pressure')

    def __init__(self, rig: Rig, effects: Effects):
        self._model = model = CircuitModel(rig, effects)
        for name in model.effects:
            why = 'does not enter' if not model.enters(name) else 'cannot be played with' if (
                effect_of(name).slot == 'speed_reading_lag') else ''
            if why:
                raise InputError(f"effect '{name}': {why} 'circuit: {rig.circuit}'; leave it out")
        self._states = len(model.circuit.states)
        self._turns = CONSTANTS['SIGN_WIDTH'] / model.parameter('sign_scale')    # rad/s

    def start(self, speed: float, pprv_command: float) -> np.ndarray:
        """Return the state at rest, behind it what the actuator remembers."""
        if speed:
            raise InputError('a closed circuit starts at rest: leave start_speed at 0')
        return np.concatenate([self._model.at_rest(),
                               np.full(self._model.circuit.memory, math.nan)])

    def simulate(self, times: np.ndarray, inputs: Mapping[str, np.ndarray], state: np.ndarray
                 ) -> dict[str, np.ndarray]:
        """As of ``OpenDrive``; the torque is the one that the load takes."""
        found = self._model.run(times, inputs, {}, state[:self._states],
                                memory=state[self._states:])
        taken = inputs['opposing_torque'] * np.tanh(found['motor_speed'] / self._turns)
        found['motor_torque'] = taken
        true = {**inputs, **found}
        return {name: values + misread(self._model, true, name, values)
                for name, values in found.items()}


_BY_CIRCUIT = {'open': OpenDrive, 'closed': ClosedDrive}


def simulated(rig: Rig, effects: Effects) -> OpenDrive | ClosedDrive:
    """Return the drive of a rig with these effects."""
    if rig.circuit not in _BY_CIRCUIT:
        raise InputError(f"{rig.source}: 'circuit: {rig.circuit}' cannot be played yet, only "
                         f'{" and ".join(_BY_CIRCUIT)}; compare and diagnose read its logs')
    return _BY_CIRCUIT[rig.circuit](rig, effects)
