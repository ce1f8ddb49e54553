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

from typing import NamedTuple

from hst_drive.effects.base import USUAL_DAMPING_TIME, USUAL_SHARE
from hst_drive.measure.noise import Coloured
from hst_drive.model import Drive
from hst_drive.model.parameters import INDEX
import numpy as np

_ENDS = 0.1     # of a record, mirrored at either end


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


def compliance_at(drive: Drive, torque: float) -> float:
    """Return the twist per torque (rad/(N.m)) of a drive's shaft that may harden."""
    twist = drive.slot('shaft_compliance', twist=0.0) * torque
    return drive.slot('shaft_compliance', twist=twist)


def load_side(drive: Drive, torque: np.ndarray, slope: float) -> LoadSide | None:
    """Return what is behind a drive's flexible shaft at a torque (N.m); None if it is stiff."""
    compliance = compliance_at(drive, float(np.median(np.abs(torque))))
    if compliance <= 0.0:
        return None
    share = USUAL_SHARE + drive.slot('shaft_load_share')
    return LoadSide(compliance, share * float(drive.parameters[INDEX['inertia']]),
                    USUAL_DAMPING_TIME + drive.slot('shaft_damping_time'), slope)


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
