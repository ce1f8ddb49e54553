# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a torque sensor on a flexible shaft tells of the load behind it.

The sensor reads ``G*(load + J2*dw1/dt)``: the shaft with the inertia J2 behind it swings between
them, ``G = (1 + d*s)/(c*J2*s^2 + (d + c*k)*s + 1)`` with compliance c, damping time d and the
load's own rise with speed k (two-inertia drive, linearised where the shaft stands). What is sought
is the load; where G or the load's own spectrum leave nothing but noise it is taken as none
(N. Wiener, Extrapolation, Interpolation, and Smoothing of Stationary Time Series, MIT Press 1949).
"""
from __future__ import annotations

from typing import Callable, NamedTuple

from hst_drive.effects.base import USUAL_DAMPING_TIME, USUAL_SHARE
from hst_drive.measure.noise import Coloured
from hst_drive.model import Drive
from hst_drive.model.parameters import INDEX
import numpy as np
from scipy.optimize import brentq

_ENDS = 0.1     # of a record, mirrored at either end
_FASTER = 0.1   # rad/s, for the slope of the load


class LoadSide(NamedTuple):
    """
    A flexible shaft and what is behind it.

    Compliance (rad/(N.m)), inertia (kg.m^2), damping time (s), and by how much the load rises with
    speed (N.m.s/rad).
    """

    compliance: float
    inertia: float
    damping_time: float
    slope: float

    def response(self, frequency: np.ndarray) -> np.ndarray:
        """Return G at frequencies in rad/s."""
        s = 1j * frequency
        top = 1.0 + self.damping_time * s
        return top / (self.compliance * (self.inertia * s + self.slope) * s + top)


def twist_at(drive: Drive, torque: float) -> float:
    """Return the twist (rad) at which a shaft that may harden carries a torque (N.m)."""
    def missing(twist: float) -> float:
        return twist - torque * drive.slot('shaft_compliance', twist=twist)

    most = torque * drive.slot('shaft_compliance', twist=0.0)
    return float(brentq(missing, 0.0, most)) if most > 0.0 and missing(most) > 0.0 else most


def load_side(drive: Drive, torque: np.ndarray,
              load_at: Callable[[float], np.ndarray]) -> LoadSide | None:
    """
    Return what is behind a drive's flexible shaft; None if that is stiff.

    Parameters
    ----------
    drive : Drive
        The model.
    torque : ndarray
        What the sensor reads, N.m; its median is where the shaft stands.
    load_at : callable
        Load (N.m) at a speed (rad/s) that is added to the recorded one.

    """
    twist = twist_at(drive, float(np.median(np.abs(torque))))
    secant = drive.slot('shaft_compliance', twist=twist)
    if secant <= 0.0:
        return None
    near = max(1e-3 * twist, 1e-6)
    low, high = (at / drive.slot('shaft_compliance', twist=at) for at in (
        twist - near, twist + near))
    compliance = 2.0 * near / (high - low)      # of small swings; a hard shaft's is below secant
    damping_time = USUAL_DAMPING_TIME + drive.slot('shaft_damping_time')
    share = USUAL_SHARE + drive.slot('shaft_load_share')
    return LoadSide(compliance, share * float(drive.parameters[INDEX['inertia']]),
                    damping_time * compliance / secant,
                    float(np.median(load_at(_FASTER) - load_at(0.0))) / _FASTER)


def read(side: LoadSide, step: float, load: np.ndarray) -> np.ndarray:
    """Return what the sensor reads of a load (N.m), sampled every ``step`` s."""
    return _filtered(step, load, side.response)


def behind(side: LoadSide, step: float, reading: np.ndarray, rough: Coloured) -> np.ndarray:
    """Return the load (N.m) of which a sensor with noise reads this, if it is of that kind."""
    def inverse(frequency: np.ndarray) -> np.ndarray:
        response = side.response(frequency)
        power = 2.0 * rough.std**2 * rough.time_constant / (
            1.0 + (frequency * rough.time_constant)**2)
        noise = max(rough.noise_std**2, 1e-12) * step
        return np.conj(response) * power / (np.abs(response)**2 * power + noise)

    return _filtered(step, reading, inverse)


def _filtered(step: float, values: np.ndarray, response) -> np.ndarray:
    """Filter a record, mirrored at its ends, by a response to frequencies in rad/s."""
    width = max(int(_ENDS * len(values)), 1)
    padded = np.pad(values, width, mode='reflect')
    frequency = 2.0 * np.pi * np.fft.rfftfreq(len(padded), step)
    return np.fft.irfft(np.fft.rfft(padded) * response(frequency), len(padded))[width:-width]
