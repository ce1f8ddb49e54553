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

import math
from typing import NamedTuple

from hst_drive.losses.efficiency import Limits, Performance, performance, reason_not_valid
from hst_drive.measure.equations import told
from hst_drive.model.part import PartModel
from hst_drive.rig import Rig
from hst_drive.watch.stream import Window
import numpy as np

PRESSURE, FLOW, SPEED, TORQUE = (
    'pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque')
INLET, TEMPERATURE = 'motor_inlet_pressure', 'oil_temperature'
SIGNALS = (SPEED, TORQUE, PRESSURE, FLOW)
_LEAST = 5      # samples in a window


class Accuracy(NamedTuple):
    """
    How far a sensor may be off, noise apart: standard uncertainties.

    The defaults are the motor-loss paper's: pressure 0.25 % of its range, flow 0.5 % of the
    reading, torque 1 % of 100 N m. The speed is counted.
    """

    pressure: float = 5e4       # Pa
    flow: float = 0.005         # of the reading
    torque: float = 1.0         # N.m
    speed: float = 0.0          # of the reading

    def of(self, unit: str, reading: float) -> tuple[float, float]:
        """Return what a sensor of an SI unit may be off, and by how much that moves a reading."""
        return {'Pa': (self.pressure, 1.0), 'N.m': (self.torque, 1.0),
                'm^3/s': (self.flow, reading), 'rad/s': (self.speed, reading)}.get(
                    unit, (0.0, 1.0))


class Moment(NamedTuple):
    """
    The motor at one moment, SI, all signals of one time.

    ``torque`` is what the motor makes, that for its inertia included; ``model_leakage`` and
    ``model_torque`` are the loss model's. ``noise`` holds the standard deviations of pressure,
    flow, speed and torque.
    """

    stamp: int
    pressure: float
    flow: float
    speed: float
    torque: float
    model_leakage: float
    model_torque: float
    noise: tuple[float, float, float, float]


def noise_of(rig: Rig, name: str) -> float:
    """Return the noise of a sensor as the rig file states it, its resolution included, SI."""
    sensor = rig.sensors.get(name)
    return math.hypot(sensor.noise_std, sensor.resolution / math.sqrt(12)) if sensor else 0.0


def bell(time: np.ndarray, middle: float) -> tuple[np.ndarray, np.ndarray] | None:
    """
    Return weights whose sums are a smoothed signal and the equally smoothed rate of a signal.

    The rate is the weak form: the derivative falls on the weight, so that a balance with a rate
    in it holds of the smoothed signals as of the signals, across jumps, too (M. Shinbrot, On
    the analysis of linear and nonlinear dynamical systems, NACA TN 3288, 1954).

    Parameters
    ----------
    time : ndarray
        s.
    middle : float
        Where the weights are highest, s.

    Returns
    -------
    level, rate : ndarray
        None if the samples are too few or lie on one side.

    """
    if len(time) < _LEAST:
        return None
    at = time - middle
    half = max(-at[0], at[-1]) * (1 + 1 / len(at))
    if min(-at[0], at[-1]) < 0.5 * half:
        return None
    place = at / half
    level = (1 - place * place)**2
    level /= level.sum()
    rate = place * (1 - place * place)
    rate -= rate.mean()
    return level, rate / (rate @ at)


def _parabola(at: np.ndarray) -> np.ndarray:
    """Return the weights whose sum is the value at 0 of a parabola through the samples."""
    scaled = at / np.max(np.abs(at))
    powers = np.stack([np.ones(len(at)), scaled, scaled * scaled])
    return np.linalg.solve(powers @ powers.T, (1.0, 0.0, 0.0)) @ powers


def moment_of(window: Window, stamp: int, model: PartModel, narrow: float) -> Moment | None:
    """
    Return the motor at ``stamp``; None if samples are too few.

    Parameters
    ----------
    window : Window
        Of ``SIGNALS`` around the stamp, and of the motor's inlet pressure and the oil's
        temperature where they are measured.
    stamp : int
        ns.
    model : PartModel
        Loss model of the motor, adopted effects and calibration included.
    narrow : float
        Half the width of the smoothing of pressure and speed, s.

    """
    middle = (stamp - window.start) * 1e-9
    wide = bell(window.time, middle)
    if wide is None:
        return None
    from_middle = np.abs(window.time - middle)
    near = from_middle <= max(narrow, np.partition(from_middle, _LEAST - 1)[_LEAST - 1])
    short = _parabola(window.time[near] - middle)
    rig = model.rig
    # The moment itself goes last: one look at the tables for all.
    channels = {name: np.append(values, short @ values[near])
                for name, values in window.values.items()}
    known, speed = told(model, channels, 0.0), channels[SPEED]
    leak, made = model.motor_leakage(known), model.motor_torque(known)
    turned = model.motor_displacement * speed
    excess = float(wide[0] @ (known['flow'] - turned - leak)[:-1])
    missing = float(wide[0] @ (made - channels[TORQUE])[:-1]
                    - model.inertia * (wide[1] @ speed[:-1]))
    left, left_short, left_rate = (
        math.sqrt(float(weight @ weight)) for weight in (wide[0], short, wide[1]))
    noise = (left_short * noise_of(rig, PRESSURE), left * noise_of(rig, FLOW),
             left * noise_of(rig, SPEED),
             math.hypot(left * noise_of(rig, TORQUE),
                        left_rate * model.inertia * noise_of(rig, SPEED)))
    leak, made = float(leak[-1]), float(made[-1])
    return Moment(stamp, float(known['pressure'][-1]), float(turned[-1]) + leak + excess,
                  float(speed[-1]), made - missing, leak, made, noise)


def modelled(moment: Moment, displacement: float) -> Performance:
    """Return the figures of merit that the loss model gives at a moment."""
    return performance(moment.pressure, displacement * moment.speed + moment.model_leakage,
                       moment.speed, moment.model_torque, displacement)


def measured(moment: Moment, displacement: float,
             limits: Limits = Limits()) -> tuple[Performance | None, str]:
    """Return the figures of merit of a moment, or None and why there are none."""
    signals = (moment.pressure, moment.flow, moment.speed, moment.torque)
    reason = reason_not_valid(*signals, limits=limits)
    return (None, reason) if reason else (performance(*signals, displacement), '')


def uncertainty(moment: Moment, figures: Performance, displacement: float,
                accuracy: Accuracy) -> Performance:
    """
    Return the standard uncertainty of each figure of merit, from sensors alone.

    First-order propagation (JCGM 100:2008, 5.1.2) of noise and accuracy; displacement and
    inertia count as known.
    """
    noise = moment.noise
    pressure = math.hypot(noise[0], accuracy.pressure) / moment.pressure
    flow = math.hypot(noise[1] / abs(moment.flow), accuracy.flow)
    speed = math.hypot(noise[2] / abs(moment.speed), accuracy.speed)
    torque = math.hypot(noise[3], accuracy.torque) / abs(moment.torque)
    volumetric = figures.volumetric * math.hypot(flow, speed)
    mechanical = figures.hydromechanical * math.hypot(pressure, torque)
    ideal = abs(moment.pressure * displacement)
    return Performance(
        volumetric, mechanical, figures.overall * math.hypot(flow, speed, pressure, torque),
        volumetric, math.hypot(pressure * ideal, torque * abs(moment.torque)), mechanical)
