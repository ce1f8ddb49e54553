# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Figures of merit of a hydromotor at one moment, from noisy signals, with their uncertainty.

Eqs. (11) to (15) of the motor-loss paper are for a steady motor: in a transient the torque that
it makes is the torque sensor's plus that which the inertia takes. The flow meter sits at the
motor's inlet, behind the oil volume, so the flow that compresses oil does not pass it.

An efficiency changes with pressure as fast as the load jumps, too fast for any smoothing that
takes the noise away. So pressure and speed are smoothed shortly; smoothed for longer is what
the measured flow and torque have beyond the loss model: that hardly changes. Where the rig
has no loss model that is the whole loss.
"""
from __future__ import annotations

from itertools import chain
import math
from typing import Any, Mapping, NamedTuple

from hst_drive.channels import LINES
from hst_drive.losses.efficiency import braking, Limits, Performance, performance, reason_not_valid
from hst_drive.measure.circuit_balances import circuit_state
from hst_drive.model.circuit_model import CircuitModel
from hst_drive.model.circuits import Balance
from hst_drive.model.circuits.motor_text import SWITCHES_AT
from hst_drive.model.part import PartModel
from hst_drive.rig import Rig
from hst_drive.rig.rig import OPEN
from hst_drive.watch.samples import Accuracy, bell, LEAST, noise_of, Samples, SPEED
from hst_drive.watch.stream import Window
import numpy as np

PRESSURE, FLOW, TORQUE = 'pump_outlet_pressure', 'motor_inlet_flow', 'load_torque'
INLET, TEMPERATURE = 'motor_inlet_pressure', 'oil_temperature'
SIGNALS = (SPEED, TORQUE, PRESSURE, FLOW)


class Moment(NamedTuple):
    """
    The motor at one moment, SI, all signals of one time, signs as if it turned forwards.

    ``torque`` is what the motor makes, that for its inertia included; ``model_flow`` and
    ``model_torque`` are the loss model's. ``noise`` holds the standard deviations of pressure,
    flow, speed and torque, ``unsure`` that of a flow that no meter tells, of the flow. ``gauges``
    counts the sensors of the pressure.
    """

    stamp: int
    pressure: float
    flow: float
    speed: float
    torque: float
    model_flow: float
    model_torque: float
    noise: tuple[float, float, float, float]
    unsure: float | None = None
    gauges: int = 1


class Losses(NamedTuple):
    """
    What the loss model says of the hydromotor: pressure across it, leakage, torque.

    Of a circuit with two lines the ``leakage`` is that of the line under pressure, ``rest`` that
    of the other one. ``way`` is -1 where it turns backwards and all else but the leakage is told
    as if it turned forwards, ``side`` is -1 where line B is under pressure.
    """

    pressure: Any
    leakage: Any
    torque: Any
    rest: Any = 0.0
    way: float = 1.0
    side: float = 1.0


def losses(model: PartModel, known: dict[str, Any], speed: float) -> Losses:
    """
    Return what the loss model says of a state that is known (``circuit_state``).

    ``speed`` (rad/s) says which way it turns.
    """
    if not isinstance(model, CircuitModel):
        return Losses(known['pressure'], model.motor_leakage(known), model.motor_torque(known))
    line_a, line_b = (known['true'][name] for name in LINES)
    way, side = math.copysign(1.0, speed), math.copysign(1.0, float(np.mean(line_a - line_b)))
    into_a = known[FLOW] - model.motor_displacement * known['true'][SPEED]
    ports = into_a, known['case_drain_flow'] - into_a
    high, low = ports if side > 0.0 else ports[::-1]
    return Losses(way * (line_a - line_b), high, way * known['motor_torque'], low, way, side)


def lost(found: dict[str, float], at: Losses) -> tuple[float, float]:
    """
    Return leakage and torque that are lost beyond the model, from the residuals of balances.

    Where no meter tells the flow, the pump's delivery stands in its place.
    """
    missing = -at.way * found.get('motor_torque', math.nan)
    if 'motor_flow' in found and at.side > 0.0:
        return found['motor_flow'], missing
    return -at.side * found.get('pump_flow', math.nan), missing


def switched(values: dict[str, np.ndarray]) -> bool:
    """Say whether the hydromotor stands on its second displacement, which no figure knows."""
    return bool(np.any(values.get('motor_displacement_command', 0.0) > SWITCHES_AT))


def limits_of(rig: Rig, speed: float = 0.0, pressure: float = Limits().pressure) -> Limits:
    """Return the smallest signals for figures; a speed of 0: where the machine creeps."""
    speed = speed or rig.creeping or Limits().speed
    return Limits(speed, pressure, rig.motor.displacement * speed)


def judged(closed: Mapping[str, Balance], circuit: str) -> dict[str, Balance]:
    """Return those of the balances that tell what the hydromotor loses."""
    # The open circuit has its flow meter at the hydromotor.
    names = ('motor_torque', 'motor_flow', *['pump_flow'] * (circuit != OPEN))
    return {name: closed[name] for name in names if name in closed}


def signals_for(balances: Mapping[str, Balance], circuit: str, signals: tuple[str, ...]
                ) -> tuple[str, ...]:
    """Return the signals that the figures need by these balances, the speed first."""
    if circuit == OPEN:
        return SIGNALS
    return tuple(dict.fromkeys((SPEED, 'motor_torque', *LINES, *chain(*(
        entry.channels(signals) for entry in balances.values())))))


def _parabola(at: np.ndarray) -> np.ndarray:
    """Return the weights whose sum is the value at 0 of a parabola through the samples."""
    scaled = at / np.max(np.abs(at))
    powers = np.stack([np.ones(len(at)), scaled, scaled * scaled])
    return np.linalg.solve(powers @ powers.T, (1.0, 0.0, 0.0)) @ powers


def moment_of(window: Window, stamp: int, model: PartModel, balances: Mapping[str, Balance],
              narrow: float, lead: float = 0.0, doubt: float = 0.0) -> Moment | None:
    """
    Return the motor at ``stamp``; None if samples are too few.

    Parameters
    ----------
    window : Window
        Of the figures' signals around the stamp, and of the motor's inlet pressure and the oil's
        temperature where they are measured.
    stamp : int
        ns.
    model : PartModel
        Loss model of the motor, adopted effects and calibration included.
    balances : mapping of str to Balance
        As of ``judged``.
    narrow : float
        Half the width of the smoothing of pressure and speed, s.
    lead : float
        From the window's start on in which lags settle, s.
    doubt : float
        Standard uncertainty of the pump's delivery where it stands for a flow meter, m^3/s.

    """
    middle = (stamp - window.start) * 1e-9
    wide = bell(window.time, middle, lead)
    if wide is None:
        return None
    level, rate = wide
    from_middle = np.abs(window.time - middle)
    near = from_middle <= max(narrow, np.partition(from_middle, LEAST - 1)[LEAST - 1])
    short = _parabola(window.time[near] - middle)
    rig, displacement = model.rig, model.motor_displacement
    channels = {name: np.array([short @ values[near]]) for name, values in window.values.items()}
    speed = float(channels[SPEED][0])
    at = losses(model, circuit_state(model, channels, np.zeros(1), 0.0, None), speed)
    samples = Samples(model, balances, window, level, rate, 0.0)
    excess, missing = lost(samples.residuals, at)
    pressure, leak, made = (float(value[0]) for value in at[:3])
    speed *= at.way
    # A braking motor is a pump: what leaks does not leave it.
    into = math.copysign(1.0, pressure)
    flow = displacement * speed + into * (leak + excess)
    left, left_short, left_rate = (
        math.sqrt(float(weight @ weight) / window.samples) for weight in (level, short, rate))
    gauges = [name for name in (PRESSURE, *LINES) if name in window.values]
    torque = next(name for name in ('motor_torque', TORQUE) if name in window.values)
    noise = (left_short * math.hypot(*(noise_of(rig, name) for name in gauges)),
             left * noise_of(rig, FLOW), left * noise_of(rig, SPEED),
             math.hypot(left * noise_of(rig, torque),
                        left_rate * model.inertia * noise_of(rig, SPEED)))
    unsure = None if 'motor_flow' in samples.residuals and at.side > 0.0 else doubt / abs(flow)
    return Moment(stamp, pressure, flow, speed, made - missing, displacement * speed + into * leak,
                  made, noise, unsure, len(gauges))


def _performance(pressure: float, *others: float) -> Performance:
    return (performance if pressure > 0.0 else braking)(pressure, *others)


def modelled(moment: Moment, displacement: float) -> Performance:
    """Return the figures of merit that the loss model gives at a moment."""
    return _performance(moment.pressure, moment.model_flow, moment.speed, moment.model_torque,
                        displacement)


def measured(moment: Moment, displacement: float,
             limits: Limits = Limits()) -> tuple[Performance | None, str]:
    """Return the figures of merit of a moment, or None and why there are none."""
    signals = (moment.pressure, moment.flow, moment.speed, moment.torque)
    reason = reason_not_valid(*signals, limits=limits)
    return (None, reason) if reason else (_performance(*signals, displacement), '')


def uncertainty(moment: Moment, figures: Performance, displacement: float,
                accuracy: Accuracy) -> Performance:
    """
    Return the standard uncertainty of each figure of merit, from sensors alone.

    First-order propagation (JCGM 100:2008, 5.1.2) of noise and accuracy; displacement and
    inertia count as known.
    """
    noise = moment.noise
    pressure = math.hypot(noise[0], math.sqrt(moment.gauges) * accuracy.pressure) / abs(
        moment.pressure)
    flow = math.hypot(noise[1] / abs(moment.flow),
                      accuracy.flow if moment.unsure is None else moment.unsure)
    speed = math.hypot(noise[2] / abs(moment.speed), accuracy.speed)
    torque = math.hypot(noise[3], accuracy.torque) / abs(moment.torque)
    volumetric = figures.volumetric * math.hypot(flow, speed)
    mechanical = figures.hydromechanical * math.hypot(pressure, torque)
    ideal = abs(moment.pressure * displacement)
    return Performance(
        volumetric, mechanical, figures.overall * math.hypot(flow, speed, pressure, torque),
        volumetric, math.hypot(pressure * ideal, torque * abs(moment.torque)), mechanical)
