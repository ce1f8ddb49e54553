# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where a replay starts: the state of the drive at the first sample of a recording."""
from __future__ import annotations

from typing import Mapping, NamedTuple

from hst_drive.channels import COMMANDS, PRESSURES
from hst_drive.model import Drive
from hst_drive.model.parameters import INDEX
from hst_drive.model.part import PartModel
from hst_drive.model.steady import twist_at
import numpy as np

_FIRST, _STILL = 5, 0.01    # rows that tell where the pump's plate rests, V that they may move
_LINE, _LINE_ROWS = 0.05, 3     # s and rows at least, over which a reading moves on a line
_SWINGS = 2.0       # deviations of a reading's own swing: further off it is in motion
_NEAR = 1e3         # Pa to which a gauge reads at first what it read
_RESTS = 1.0        # s over which what flows tells where the plate rests


class Beginning(NamedTuple):
    """
    What the first rows of a recording tell: one row alone has a sensor's noise.

    ``first`` are signals at the first row, SI, on a straight line through the next ones;
    ``resting`` their means while the pump's command stands, or those where a reading drifts, and
    ``rise`` the pressure's slope, Pa/s.
    """

    first: dict[str, float]
    resting: dict[str, float]
    rise: float

    @classmethod
    def of(cls, time: np.ndarray, signals: Mapping[str, np.ndarray],
           command: np.ndarray) -> Beginning:
        """Return it for filled signals."""
        since = time - time[0]
        near = np.arange(len(time)) < max(np.count_nonzero(since <= _LINE), _LINE_ROWS)
        first = {name: float(np.polyval(np.polyfit(since[near], values[near], 1), 0.0))
                 for name, values in signals.items()}
        moves = np.flatnonzero((np.abs(command - command[0]) > _STILL) | (since > _RESTS))
        still = slice(int(moves[0])) if len(moves) and moves[0] > _FIRST else slice(_FIRST)
        moving = any(_drifts(since[still], values[still]) for values in signals.values())
        still = near if moving else still
        pressure = signals.get('pump_outlet_pressure', signals.get('motor_inlet_pressure'))
        return cls(first, first if moving else {
            name: float(values[still].mean()) for name, values in signals.items()},
            0.0 if pressure is None else float(np.polyfit(since[still], pressure[still], 1)[0]))


def _drifts(since: np.ndarray, values: np.ndarray) -> bool:
    """Say whether a reading begins elsewhere than where it goes on, by more than it swings."""
    late = values[since > 0.5 * since[-1]]
    return len(values) > 2 * _FIRST and bool(
        abs(values[:_FIRST].mean() - late.mean()) > _SWINGS * late.std())


def first_state(drive: Drive, beginning: Beginning, inputs: Mapping[str, float],
                torque: str | None) -> np.ndarray:
    """
    Return the state at the first sample, as far as the signals tell it.

    What they do not tell is taken as settled: the speed that the first command gives, the
    pressure that the load needs.

    Parameters
    ----------
    drive : Drive
        The model.
    beginning : Beginning
        What the first rows tell.
    inputs : mapping of str to float
        First 'pump_command', 'pprv_command' (V), 'oil_temperature' (K) and, by default 0,
        'motor_angle' (rad).
    torque : str, optional
        Name of the torque signal, if there is one.

    """
    first = beginning.first
    commands = {name: inputs[name] for name in COMMANDS}
    state = drive.initial_state(**commands, speed=first.get('motor_speed', 0.0))
    motor, pump = drive.rig.motor, drive.rig.pump
    gauge = next((name for name in PRESSURES[::-1] if name in first), '')
    for _ in range(3):
        if 'motor_speed' not in first:
            flow = first.get('motor_inlet_flow')
            if flow is None:
                flow = (state[0] * pump.shaft_speed
                        - pump.leakage(state[1], commands['pump_command']))
            leak = motor.leakage(state[1], abs(state[2]))
            state[2] = max(flow - leak, 0.0) / motor.displacement
        pressure = first.get(gauge)
        if pressure is None:
            pressure = _first_torque(drive, first, inputs, torque, state[2]) / (
                motor.displacement * motor.mechanical_efficiency(state[1], abs(state[2])))
        state[1] = pressure
    for _ in range(3):
        if 'pump_displacement' in first:
            state[0] = first['pump_displacement']
        elif 'motor_speed' in first or 'motor_inlet_flow' in first:
            state[0] = _resting_displacement(drive, state, beginning, commands, inputs)
        if not gauge:
            break
        # A gauge reads otherwise than the oil is on the whole where a line takes pressure.
        shown = drive.outputs(state, **commands, oil_temperature=inputs['oil_temperature'])
        state[1] += pressure - shown[gauge]
        if abs(pressure - shown[gauge]) < _NEAR:
            break
    state[4] = inputs.get('motor_angle', 0.0)
    state[5] = state[7] = state[13] = state[2]
    if drive.has_flexible_shaft:
        load = _first_torque(drive, first, inputs, torque, state[2])
        state[6] = twist_at(drive, load)
    # A plate with play rests where the flow says, not where the command says.
    state[9] = commands['pump_command']
    asked = state[0] + drive.pump_yield(state[1], state[0])
    state[8] = state[11] = pump.command_of(
        asked / drive.parameters[INDEX['displacement_scale']])
    return state


def _resting_displacement(drive: Drive, state: np.ndarray, beginning: Beginning,
                          commands: Mapping[str, float], inputs: Mapping[str, float]) -> float:
    """Return the displacement (m^3/rad) whose flow the hydromotor, leaks and oil volume take."""
    state, rise = state.copy(), 0.0
    if 'motor_speed' in beginning.resting:
        state[2], rise = beginning.resting['motor_speed'], beginning.rise
        if 'pump_outlet_pressure' in beginning.resting:
            state[1] += (beginning.resting['pump_outlet_pressure']
                         - beginning.first['pump_outlet_pressure'])
    state[0] = 0.0
    if abs(state[2]) <= 0.2:
        return 0.0
    shown = drive.outputs(state, **commands, oil_temperature=inputs['oil_temperature'])
    values = drive.parameters
    flow = (values[INDEX['motor_displacement']] * abs(state[2]) + shown['case_drain_flow']
            - shown['pump_flow'] + values[INDEX['volume']] / values[INDEX['bulk_modulus']] * rise)
    return float(np.clip(flow / shown['pump_speed'], 0.0, drive.rig.pump.max_displacement))


def resting(model: PartModel, known: Mapping[str, np.ndarray],
            channels: Mapping[str, np.ndarray]) -> dict[str, float]:
    """
    Return where the pump's plate 'starts_at', and 'rests_at' before the command moves, m^3/rad.

    A plate with play rests where the readings say, not where the command says (of one without it
    is not asked), and a slow one may be on its way. Empty if nothing tells. ``known`` is what the
    pump's flow depends on, and the true 'flow' (m^3/s) if that is known. ``channels`` are
    readings, SI.
    """
    command, places = channels['pump_command'], {'starts_at': slice(1)}
    if np.any(model.terms('pump_play', known)):
        moves = int(np.argmax(np.abs(command - command[0]) > _STILL)) or len(command)
        places['rests_at'] = slice(max(moves - _FIRST, 0), max(moves, _FIRST))
    if 'pump_displacement' in channels:
        return {place: float(np.mean(channels['pump_displacement'][rows]))
                for place, rows in places.items()}
    if 'flow' not in known or 'pump_pressure' not in known:
        return {}
    found, ends = {}, (0.0, model.rig.pump.max_displacement)
    for place, rows in places.items():
        first = {name: values[rows] if np.ndim(values) else values
                 for name, values in known.items()}
        flows = [float(np.mean(model.pump_flow({
            **first, 'displacement': np.full(len(command[rows]), end)}))) for end in ends]
        if flows[0] < flows[1]:
            found[place] = float(np.interp(np.mean(first['flow']), flows, ends))
    return found


def _first_torque(drive: Drive, first: Mapping[str, float], inputs: Mapping[str, float],
                  torque: str | None, speed: float) -> float:
    found = first[torque] if torque else drive.load_at(
        inputs['pprv_command'], speed, inputs['oil_temperature'])
    return max(found, 0.0)
