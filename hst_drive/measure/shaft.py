# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a torque sensor on a flexible shaft tells of the load behind it.

The sensor reads ``G*(load + J2*dw1/dt)``: the shaft with the inertia J2 behind it swings between
them, ``G = (1 + d*s)/(c*J2*s^2 + (d + c*k)*s + 1)`` with compliance c, damping time d and the
load's own rise with speed k (two-inertia drive, linearised where the shaft stands). What the model
of the load leaves of the reading is that of an unknown load, with the noise of the torque sensor
and, through G, of the speed's. How rough that load is its spectrum tells (P. Whittle, Estimation
and information in stationary time series, Arkiv for Matematik 2, 1953); where G or that spectrum
leave nothing but noise it is taken as none (N. Wiener, Extrapolation, Interpolation, and Smoothing
of Stationary Time Series, MIT Press 1949).
"""
from __future__ import annotations

import math
from typing import Callable, NamedTuple

from hst_drive.effects.slots import USUAL_DAMPING_TIME, USUAL_SHARE
from hst_drive.measure.noise import Coloured
from hst_drive.model import Drive
from hst_drive.model.parameters import INDEX
from hst_drive.model.steady import twist_at
import numpy as np

_ENDS = 0.1     # of a record, mirrored at either end
_FASTER = 0.1   # rad/s, for the slope of the load
_BLOCK = 2.5    # s: resolves a shaft's resonance, and most blocks are free of steps
_MEMORY = (0.03, 2.0)   # s, between which the correlation time of a rough load lies
_LEAST, _MOST = 1e-2, 10.0  # of the reading's noise, and of its variance: a load's roughness
_ROUNDS, _RIDGE = 20, 0.1   # of the search for it


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


class Behind(NamedTuple):
    """
    What a torque reading holds of the load behind a shaft, row by row.

    ``step`` (s) lies between rows; ``rough`` is the load's coloured part with the noise of the
    torque sensor, ``speed_noise`` (rad/s) that of the speed which the load was modelled with.
    """

    side: LoadSide
    step: float
    speed_noise: float
    rough: Coloured

    def _spectra(self, frequency: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return G, and spectral densities ((N.m)^2.s, two-sided) of load and noise."""
        response = self.side.response(frequency)
        return (response, self.rough.std**2 * _of_memory(frequency, self.rough.time_constant),
                max(self.rough.noise_std**2, 1e-12) * self.step
                + _of_speed(self.side, frequency) * self.speed_noise**2 * self.step)

    def load(self, reading: np.ndarray) -> np.ndarray:
        """Return that (N.m) of which the sensor reads this."""
        def inverse(frequency: np.ndarray) -> np.ndarray:
            response, load, noise = self._spectra(frequency)
            return np.conj(response) * load / (np.abs(response)**2 * load + noise)

        return _filtered(self.step, reading, inverse)

    def draw_error(self, step: float, count: int, random: np.random.Generator) -> np.ndarray:
        """Return one draw of what ``load`` misses, every ``step`` s, shape (count,)."""
        def missed(frequency: np.ndarray) -> np.ndarray:
            response, load, noise = self._spectra(frequency)
            read = np.abs(response)**2 * (frequency * self.step < np.pi)
            return np.sqrt(load * noise / (read * load + noise) / step)

        return _filtered(step, random.standard_normal(count), missed)

    def swings(self) -> float:
        """Return by how much (N.m) the load, and the speed's noise, shake the reading."""
        frequency = np.linspace(0.0, np.pi / self.step, 4096)
        response, load, noise = self._spectra(frequency)
        white = max(self.rough.noise_std**2, 1e-12) * self.step
        power = np.abs(response)**2 * load + noise - white
        return float(np.sqrt(power.mean() / self.step))


def _of_memory(frequency: np.ndarray, time_constant: float) -> np.ndarray:
    """Return the spectral density of an Ornstein-Uhlenbeck process over its variance, s."""
    return 2.0 * time_constant / (1.0 + (frequency * time_constant)**2)


def _of_speed(side: LoadSide, frequency: np.ndarray) -> np.ndarray:
    """Return by how much a speed shakes the reading, squared, (N.m.s/rad)^2."""
    return np.abs(side.response(frequency) * (side.slope + 1j * frequency * side.inertia))**2


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
    inertia = float(drive.parameters[INDEX['inertia']])
    # Beyond twice the root nothing oscillates any more (as in the kernel).
    damping_time = min(damping_time, 2.0 * math.sqrt(secant * inertia))
    return LoadSide(compliance, share * inertia, damping_time * compliance / secant,
                    float(np.median(load_at(_FASTER) - load_at(0.0))) / _FASTER)


def behind(side: LoadSide, step: float, reading: np.ndarray, noise: float,
           speed_noise: float) -> Behind:
    """
    Return what a reading holds of the load behind a shaft, from its spectrum.

    Medians over blocks: steps that the model misses are events, no roughness of the load.

    Parameters
    ----------
    side : LoadSide
        The shaft.
    step : float
        Between rows, s.
    reading : ndarray, shape (n,)
        What the modelled load leaves of it, N.m.
    noise : float
        The most noise that the torque sensor has, N.m.
    speed_noise : float
        Noise of the speed that the load was modelled with, rad/s.

    """
    size = max(min(int(_BLOCK / step), len(reading)), 8)
    window = np.hanning(size)
    blocks = np.lib.stride_tricks.sliding_window_view(reading, size)[::max(size // 2, 1)]
    blocks = (blocks - blocks.mean(axis=1, keepdims=True)) * window
    frequency = 2.0 * np.pi * np.fft.rfftfreq(size, step)[2:]
    # The power at one frequency has an exponential distribution: its median is ln 2 of its mean.
    power = np.median(np.abs(np.fft.rfft(blocks)[:, 2:])**2, axis=0) / np.log(2.0) * step / (
        window @ window)
    gain = np.abs(side.response(frequency))**2
    of_speed = _of_speed(side, frequency) * speed_noise**2 * step
    # Logarithms of the load's variance, its memory and the sensor's variance, by scoring.
    white = max(noise**2, 1e-18)
    low = np.log([_LEAST**2 * white, _MEMORY[0], _LEAST**2 * white])
    high = np.log([max(_MOST * reading.var(), white), _MEMORY[1], white])
    found = np.log([white, np.sqrt(_MEMORY[0] * _MEMORY[1]), white])
    for _ in range(_ROUNDS):
        variance, memory, white = np.exp(found)
        rough = gain * variance * _of_memory(frequency, memory)
        likely = rough + white * step + of_speed
        bend = (1.0 - (frequency * memory)**2) / (1.0 + (frequency * memory)**2)
        slopes = np.array([rough, rough * bend, np.full(len(rough), white * step)]) / likely
        move = np.linalg.solve(slopes @ slopes.T + _RIDGE * np.eye(3),
                               slopes @ (power / likely - 1.0))
        found = np.clip(found + np.clip(move, -1.0, 1.0), low, high)
    load, memory, white = np.exp(found * [0.5, 1.0, 0.5])
    return Behind(side, step, speed_noise, Coloured(float(load), float(memory), float(white)))


def _filtered(step: float, values: np.ndarray, response) -> np.ndarray:
    """Filter a record, mirrored at its ends, by a response to frequencies in rad/s."""
    width = max(int(_ENDS * len(values)), 1)
    padded = np.pad(values, width, mode='reflect')
    frequency = 2.0 * np.pi * np.fft.rfftfreq(len(padded), step)
    return np.fft.irfft(np.fft.rfft(padded) * response(frequency), len(padded))[width:-width]
