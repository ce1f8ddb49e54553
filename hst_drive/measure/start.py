# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where a replay starts: the state of the drive at the first sample of a recording."""
from __future__ import annotations

from typing import Mapping

from hst_drive.measure.shaft import twist_at
from hst_drive.model import Drive
from hst_drive.model.parameters import INDEX
from hst_drive.model.part import PartModel
import numpy as np

_FIRST, _STILL = 5, 0.01    # rows that tell where the pump's plate rests, V that they may move


def first_state(drive: Drive, first: Mapping[str, float], inputs: Mapping[str, float],
                torque: str | None) -> np.ndarray:
    """
    Return the state at the first sample, as far as the signals tell it.

    What they do not tell is taken as settled: the speed that the first command gives, the
    pressure that the load needs.

    Parameters
    ----------
    drive : Drive
        The model.
    first : mapping of str to float
        First sample of the signals that there are, SI.
    inputs : mapping of str to float
        First 'pump_command', 'pprv_command' (V), 'oil_temperature' (K) and, by default 0,
        'motor_angle' (rad).
    torque : str, optional
        Name of the torque signal, if there is one.

    """
    commands = {name: inputs[name] for name in ('pump_command', 'pprv_command')}
    state = drive.initial_state(**commands, speed=first.get('motor_speed', 0.0))
    motor, pump = drive.rig.motor, drive.rig.pump
    for _ in range(3):
        if 'motor_speed' not in first:
            flow = first.get('motor_inlet_flow')
            if flow is None:
                flow = (state[0] * pump.shaft_speed
                        - pump.leakage(state[1], commands['pump_command']))
            leak = motor.leakage(state[1], abs(state[2]))
            state[2] = max(flow - leak, 0.0) / motor.displacement
        pressure = first.get('pump_outlet_pressure', first.get('motor_inlet_pressure'))
        if pressure is None:
            pressure = _first_torque(drive, first, inputs, torque, state[2]) / (
                motor.displacement * motor.mechanical_efficiency(state[1], abs(state[2])))
        state[1] = pressure
    if 'pump_displacement' in first:
        state[0] = first['pump_displacement']
    elif 'motor_speed' in first or 'motor_inlet_flow' in first:
        state[0] = 0.0
        if abs(state[2]) > 0.2:
            shown = drive.outputs(state, **commands,
                                  oil_temperature=inputs['oil_temperature'])
            flow = (drive.parameters[INDEX['motor_displacement']] * abs(state[2])
                    + shown['case_drain_flow'] - shown['pump_flow'])
            state[0] = np.clip(flow / shown['pump_speed'], 0.0, pump.max_displacement)
    state[4] = inputs.get('motor_angle', 0.0)
    state[5] = state[7] = state[13] = state[2]
    if drive.has_flexible_shaft:
        load = _first_torque(drive, first, inputs, torque, state[2])
        state[6] = twist_at(drive, load)
    # A plate with play rests where the flow says, not where the command says.
    state[9] = commands['pump_command']
    state[8] = state[11] = pump.command_of(
        state[0] / drive.parameters[INDEX['displacement_scale']])
    return state


def resting(model: PartModel, known: Mapping[str, np.ndarray],
            channels: Mapping[str, np.ndarray]) -> dict[str, float]:
    """
    Return where the pump's plate 'rests_at' before the command moves, m^3/rad; empty if unknown.

    A plate with play rests where the readings say, not where the command says.

    Parameters
    ----------
    model : PartModel
        The pump.
    known : mapping of str to ndarray
        What its flow depends on, and the true 'flow' (m^3/s) if that is known.
    channels : mapping of str to ndarray
        Readings, SI.

    """
    command = channels['pump_command']
    moves = int(np.argmax(np.abs(command - command[0]) > _STILL)) or len(command)
    rows = slice(max(moves - _FIRST, 0), max(moves, _FIRST))
    if 'pump_displacement' in channels:
        return {'rests_at': float(np.mean(channels['pump_displacement'][rows]))}
    if 'flow' not in known or 'pump_pressure' not in known:
        return {}
    first = {name: values[rows] if np.ndim(values) else values for name, values in known.items()}
    ends = 0.0, model.rig.pump.max_displacement
    flows = [float(np.mean(model.pump_flow({
        **first, 'displacement': np.full(len(command[rows]), end)}))) for end in ends]
    if flows[0] >= flows[1]:
        return {}
    return {'rests_at': float(np.interp(np.mean(first['flow']), flows, ends))}


def _first_torque(drive: Drive, first: Mapping[str, float], inputs: Mapping[str, float],
                  torque: str | None, speed: float) -> float:
    if torque:
        return max(first[torque], 0.0)
    model = drive.load_torque(*(np.full(2, value) for value in (
        0.0, inputs['pprv_command'], speed, inputs['oil_temperature'])))
    return max(float(model[0]), 0.0)
