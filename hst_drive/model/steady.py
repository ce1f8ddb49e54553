# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Operating points of the drive, and its linearised motion about them."""
from __future__ import annotations

import math
from typing import Callable, NamedTuple

from hst_drive.errors import InputError
from hst_drive.model.compose import CONSTANTS
from hst_drive.model.drive import Drive
from hst_drive.model.parameters import INDEX
import numpy as np

_SCALES = np.array([1e-7, 1e5, 0.1, 1e5])
_MOMENT = 1e-4      # s: the state's rate is the change over so short a time


class OperatingPoint(NamedTuple):
    """A steady state: inputs (V, V, K), state vector and readings (SI)."""

    pump_command: float
    pprv_command: float
    oil_temperature: float
    state: np.ndarray
    readings: dict[str, float]


class LinearModel(NamedTuple):
    """
    Motion about an operating point, ``dx/dt = A x + B u``, ``y = C x``.

    States: the first four of ``STATES``; inputs pump command (V) and PPRV command (V); output
    hydromotor speed (rad/s).
    """

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray


def root(function: Callable[[float], float], low: float, high: float,
         tolerance: float = 2e-12) -> float:
    """Return where a function is zero between two points, within a tolerance."""
    from scipy.optimize import brentq   # here, so that nodes start in half the time

    return float(brentq(function, low, high, xtol=tolerance))


def operating_point(drive: Drive, speed: float, load_torque: float | None = None, *,
                    pprv_command: float | None = None,
                    oil_temperature: float | None = None) -> OperatingPoint:
    """
    Find the commands that hold a speed under a load.

    Parameters
    ----------
    drive : Drive
        The model.
    speed : float
        Hydromotor, rad/s, above standstill.
    load_torque : float, optional
        N.m at the hydromotor shaft.
    pprv_command : float, optional
        V, instead of ``load_torque``.
    oil_temperature : float, optional
        K; by default that of the tables.

    Raises
    ------
    InputError
        If the rig cannot reach the speed or the load.

    """
    temperature = drive.rig.characterised_at if oil_temperature is None else oil_temperature
    if pprv_command is None:
        if load_torque is None:
            raise ValueError('give load_torque or pprv_command')
        pprv_command = _pprv_command(drive, speed, load_torque, temperature)
    pressure = _steady_pressure(drive, speed, pprv_command, temperature)

    def flow_missing(command: float) -> float:
        return _flow_rate(drive, command, pprv_command, temperature, speed, pressure)

    table = drive.rig.pump.displacement
    low, high = table.x[0], table.x[-1]
    if flow_missing(high) < 0 or flow_missing(low) > 0:
        raise InputError(f'{drive.rig.name}: {speed:.4g} rad/s under {pressure / 1e5:.4g} bar is '
                         'beyond what the pump gives; choose a lower speed or load')
    command = root(flow_missing, low, high, 1e-10)
    state = _state(drive, command, pprv_command, temperature, speed, pressure)
    readings = drive.outputs(state, pump_command=command, pprv_command=pprv_command,
                             oil_temperature=temperature)
    return OperatingPoint(command, pprv_command, temperature, state, readings)


def twist_at(drive: Drive, torque: float) -> float:
    """Return the twist (rad) at which a shaft that may harden carries a torque (N.m)."""
    rigid = CONSTANTS['SHAFT_RIGID'] / float(drive.parameters[INDEX['inertia']])

    def missing(twist: float) -> float:
        return twist - abs(torque) * max(drive.slot('shaft_compliance', twist=twist), rigid)

    most = -missing(0.0)
    twist = root(missing, 0.0, most) if missing(most) > 0.0 else most
    return math.copysign(twist, torque)


def _state(drive: Drive, command: float, pprv_command: float, temperature: float, speed: float,
           pressure: float) -> np.ndarray:
    state = drive.initial_state(pump_command=command, pprv_command=pprv_command,
                                pressure=pressure, speed=speed)
    if drive.has_flexible_shaft:
        bare = drive.without('torque_reading')      # what is read may be wrong
        state[6] = twist_at(drive, bare.load_at(pprv_command, speed, temperature))
    return state


def _pprv_command(drive: Drive, speed: float, load_torque: float, temperature: float) -> float:
    table = drive.rig.loading.pprv_pressure

    def missing(command: float) -> float:
        return drive.load_at(command, speed, temperature) - load_torque

    low, high = float(table.x[0]), float(table.x[-1])
    if missing(high) < 0:
        raise InputError(f'{drive.rig.name}: a load of {load_torque:.4g} N.m is more than the '
                         'loading unit brakes; choose a lower load')
    if missing(low) > 0:
        return low
    return root(missing, low, high, 1e-10)


def _readings(drive: Drive, command: float, pprv_command: float, temperature: float, speed: float,
              pressure: float) -> dict[str, float]:
    return drive.outputs(_state(drive, command, pprv_command, temperature, speed, pressure),
                         pump_command=command, pprv_command=pprv_command,
                         oil_temperature=temperature)


def _steady_pressure(drive: Drive, speed: float, pprv_command: float,
                     temperature: float) -> float:
    def torque_missing(pressure: float) -> float:
        found = _readings(drive, 5.0, pprv_command, temperature, speed, pressure)
        return found['motor_torque_hydraulic'] - found['load_torque']

    top = 2 * drive.parameters[INDEX['relief_set_pressure']]
    if torque_missing(top) < 0:
        raise InputError(f'{drive.rig.name}: the load needs more pressure than the relief valve '
                         'allows; choose a lower load')
    return root(torque_missing, 0.0, top, 1e-3) if torque_missing(0.0) < 0 else 0.0


def _flow_rate(drive: Drive, command: float, pprv_command: float, temperature: float,
               speed: float, pressure: float) -> float:
    found = _readings(drive, command, pprv_command, temperature, speed, pressure)
    return found['pump_flow'] - found['relief_flow'] - found['motor_inlet_flow']


def linearise(drive: Drive, point: OperatingPoint) -> LinearModel:
    """Return the linear model about an operating point, by central differences."""
    from scipy.linalg import logm

    def rate(state: np.ndarray, pump_command: float, pprv_command: float) -> np.ndarray:
        full = drive.initial_state(pump_command=pump_command, speed=state[2])
        full[:4], full[6] = state, point.state[6]
        after = drive.advance(full, _MOMENT, pump_command=pump_command, pprv_command=pprv_command,
                              oil_temperature=point.oil_temperature)
        return after[:4] - state

    state = point.state[:4]
    commands = np.array([point.pump_command, point.pprv_command])
    # The change over a short time is (expm(A*h) - 1): its logarithm gives A without bias.
    transition = np.eye(6)
    for k, step in enumerate([*_SCALES, 1e-3, 1e-3]):
        shift = np.zeros(6)
        shift[k] = step
        moved = [rate(state + sign * shift[:4], *(commands + sign * shift[4:]))
                 + sign * shift[:4] for sign in (1, -1)]
        transition[:4, k] = (moved[0] - moved[1]) / (2 * step)
    scales = np.concatenate([_SCALES, [1.0, 1.0]])
    scaled = transition * scales[None, :] / scales[:, None]
    generator = np.real(logm(scaled)) / _MOMENT * scales[:, None] / scales[None, :]
    return LinearModel(generator[:4, :4], generator[:4, 4:], np.array([[0.0, 0.0, 1.0, 0.0]]))
