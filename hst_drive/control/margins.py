# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Margins of the sampled PI loop around a linearised drive, and gains that meet stated ones.

The plant is held between samples (zero-order hold, discretised exactly), the PI is the forward
rule of ``PiController``, so sampling and hold delay are in the margins without approximation.
"""
from __future__ import annotations

from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm


class Plant(NamedTuple):
    """Linear drive from pump command (V) to speed (rad/s): ``x' = A x + B u``, ``y = C x``."""

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    title: str = ''


@dataclass(frozen=True)
class Margins:
    """
    How far the loop is from instability.

    Attributes
    ----------
    stable : bool
        Whether all poles of the closed loop lie inside the unit circle.
    phase_margin : float
        Smallest at any gain crossover, rad; inf without one.
    gain_margin : float
        Smallest factor above 1 at any phase crossover; inf without one.
    crossover : float
        Highest frequency at which the loop gain is 1, rad/s; 0 without one.
    phase_crossover : float
        Frequency of ``gain_margin``, rad/s; 0 without one.
    delay_margin : float
        Extra delay that takes the phase margin up, s.
    sensitivity_peak : float
        Largest ``|1 / (1 + L)|``.
    resonance : float
        Natural frequency of the least damped oscillatory pole pair of the plant, rad/s; 0 if
        there is none.
    resonance_damping : float
        Its damping ratio.
    resonance_gain : float
        Largest loop gain ``|L|`` within a fifth of that frequency; the margin in gain
        there, whatever the phase, is its inverse.

    """

    stable: bool
    phase_margin: float
    gain_margin: float
    crossover: float
    phase_crossover: float
    delay_margin: float
    sensitivity_peak: float
    resonance: float
    resonance_damping: float
    resonance_gain: float


def discretise(plant: Plant, sample_time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return ``Ad, Bd`` of the plant behind a zero-order hold (exact, matrix exponential)."""
    n = len(plant.a)
    block = np.zeros((n + 1, n + 1))
    block[:n, :n] = plant.a
    block[:n, n] = np.ravel(plant.b)
    block = expm(block * sample_time)
    return block[:n, :n], block[:n, n]


def resonance(plant: Plant) -> tuple[float, float]:
    """Return natural frequency (rad/s) and damping of the least damped pair; (0, 1) if none."""
    poles = np.linalg.eigvals(plant.a)
    pairs = poles[poles.imag > 1e-9 * np.abs(poles)]
    if not len(pairs):
        return 0.0, 1.0
    damping = -pairs.real / np.abs(pairs)
    least = int(np.argmin(damping))
    return float(np.abs(pairs[least])), float(damping[least])


class Loop:
    """
    One plant seen by the sampled controller: its response on a frequency grid up to Nyquist.

    Parameters
    ----------
    plant : Plant
        Linear drive.
    sample_time : float
        Of the controller, s.
    delay : int
        Whole samples between reading and command, e.g. 1 for a command that takes effect one
        period late.
    points : int
        Frequencies of the grid, some more around the resonance apart.

    """

    def __init__(self, plant: Plant, sample_time: float, delay: int = 0, points: int = 1500):
        self.sample_time, self.delay = sample_time, delay
        self.a, self.b = discretise(plant, sample_time)
        self.c = np.ravel(plant.c)
        self.resonance, self.resonance_damping = resonance(plant)
        nyquist = math.pi / sample_time
        grid = np.geomspace(1e-3 * nyquist / math.pi, nyquist, points)
        if 0.0 < self.resonance < nyquist:
            width = self.resonance * max(self.resonance_damping, 1e-3)
            near = self.resonance + width * np.linspace(-6.0, 6.0, points // 3)
            grid = np.union1d(grid, near[(near > 0.0) & (near < nyquist)])
        self.frequency = grid
        self.z = np.exp(1j * grid * sample_time)
        shifted = self.z[:, None, None] * np.eye(len(self.a)) - self.a
        state = np.linalg.solve(shifted, np.broadcast_to(self.b[:, None], (*shifted.shape[:2], 1)))
        self.plant = (state[..., 0] @ self.c) * self.z**-delay

    def loop_gain(self, kp: float, ki: float) -> np.ndarray:
        """Return ``L`` on the grid."""
        return self.plant * (kp + ki * self.sample_time / (self.z - 1.0))

    def closed_loop_poles(self, kp: float, ki: float) -> np.ndarray:
        """Return the poles of the closed loop in z."""
        n, m = len(self.a), self.delay
        size = n + 1 + m
        step = np.zeros((size, size))
        command = np.concatenate((-kp * self.c, [1.0], np.zeros(m)))
        applied = command if m == 0 else np.eye(size)[size - 1]
        step[:n, :n] = self.a
        step[:n] += np.outer(self.b, applied)
        step[n, :n] = -ki * self.sample_time * self.c
        step[n, n] = 1.0
        if m:
            step[n + 1] = command
            for k in range(1, m):
                step[n + 1 + k, n + k] = 1.0
        if ki == 0.0:
            # Without integral action its state stands still, outside the loop.
            step = np.delete(np.delete(step, n, axis=0), n, axis=1)
        return np.linalg.eigvals(step)

    @np.errstate(divide='ignore')   # with gains of 0 there is no loop
    def margins(self, kp: float, ki: float) -> Margins:
        """Return the margins with these gains (V.s/rad, V/rad)."""
        loop = self.loop_gain(kp, ki)
        size = np.abs(loop)
        phase = np.unwrap(np.angle(loop))
        crossovers = _crossings(self.frequency, np.log(size))
        lead = [abs(_wrap(np.interp(w, self.frequency, phase) + math.pi)) for w in crossovers]
        gain_margin, phase_crossover = self._gain_margin(phase, size)
        near = np.abs(self.frequency - self.resonance) <= 0.2 * self.resonance
        return Margins(
            stable=bool(np.max(np.abs(self.closed_loop_poles(kp, ki))) < 1.0),
            phase_margin=min(lead, default=math.inf), gain_margin=gain_margin,
            crossover=crossovers[-1] if len(crossovers) else 0.0,
            phase_crossover=phase_crossover,
            delay_margin=min((p / w for p, w in zip(lead, crossovers)), default=math.inf),
            sensitivity_peak=float(np.max(1.0 / np.abs(1.0 + loop))),
            resonance=self.resonance, resonance_damping=self.resonance_damping,
            resonance_gain=float(size[near].max()) if near.any() else 0.0)

    def _gain_margin(self, phase: np.ndarray, size: np.ndarray) -> tuple[float, float]:
        best, at = math.inf, 0.0
        if math.cos(phase[-1]) < -0.999999 and size[-1] < 1.0:
            # A sampled loop is real at the Nyquist frequency and may touch -180 deg just there.
            best, at = float(1.0 / size[-1]), float(self.frequency[-1])
        turns = range(math.floor((phase.min() / math.pi - 1) / 2),
                      math.ceil((phase.max() / math.pi + 1) / 2) + 1)
        for turn in turns:
            for w in _crossings(self.frequency, phase - (2 * turn + 1) * math.pi):
                factor = 1.0 / np.interp(w, self.frequency, size)
                if 1.0 < factor < best:
                    best, at = float(factor), w
        return best, at


def _wrap(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


def _crossings(x: np.ndarray, y: np.ndarray) -> list[float]:
    """Return where ``y`` changes its sign, linear between points."""
    at = np.flatnonzero(np.signbit(y[:-1]) != np.signbit(y[1:]))
    return [float(x[i] - y[i] * (x[i + 1] - x[i]) / (y[i + 1] - y[i])) for i in at]


def margins(plant: Plant, kp: float, ki: float, sample_time: float, delay: int = 0) -> Margins:
    """Return the margins of one loop; see ``Loop``."""
    return Loop(plant, sample_time, delay).margins(kp, ki)


def meets(found: Margins, phase_margin: float, gain_margin: float,
          sensitivity_peak: float = math.inf) -> bool:
    """
    Tell whether margins are at least those wanted.

    The gain margin is asked of the resonance as well, whatever its phase is there: a phase
    that merely happens to be good does not survive a longer hose or air in the oil.
    """
    return (found.stable and found.phase_margin >= phase_margin
            and found.gain_margin >= gain_margin
            and found.resonance_gain * gain_margin <= 1.0
            and found.sensitivity_peak <= sensitivity_peak)


def choose_gains(plants: list[Plant], sample_time: float, *,
                 phase_margin: float = math.radians(60.0), gain_margin: float = 2.0,
                 sensitivity_peak: float = 2.0, delay: int = 0) -> tuple[float, float]:
    """
    Choose the gains with the largest ``ki`` that keeps the margins at every operating point.

    A load step costs an integrated speed error in proportion to ``1 / ki``, so the largest
    ``ki`` under a robustness constraint is the best disturbance rejection (Astrom,
    Panagopoulos and Hagglund, Automatica 34(5), 1998, pp. 585-601). Scans the ratio
    ``kp / ki`` and bisects ``ki``; of pairs within a tenth of the largest ``ki`` it takes the
    smallest ``kp``.

    Parameters
    ----------
    plants : list of Plant
        The linearised drive over its operating range.
    sample_time : float
        s.
    phase_margin, gain_margin, sensitivity_peak : float
        Wanted: rad, factor, factor.
    delay : int
        Samples between reading and command.

    Returns
    -------
    kp, ki : float
        V.s/rad and V/rad, rounded down to two figures.

    Raises
    ------
    ValueError
        If no gains meet the margins.

    """
    loops = [Loop(plant, sample_time, delay, points=300) for plant in plants]

    def good(kp: float, ki: float) -> bool:
        return all(meets(loop.margins(kp, ki), phase_margin, gain_margin, sensitivity_peak)
                   for loop in loops)

    found: list[tuple[float, float]] = []
    most = 0.0
    for ratio in np.concatenate(([0.0], np.geomspace(0.003, 1.0, 24))):
        low, high = 0.9 * most, max(4.0 * most, 0.01)
        if low and not good(ratio * low, low):
            continue
        while good(ratio * high, high) and high < 1e4:
            low, high = high, 4.0 * high
        for _ in range(9):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if good(ratio * middle, middle) else (low, middle)
        found.append((ratio * low, low))
        most = max(most, low)
    # Of gains that are nearly as fast, the smallest kp: it passes least noise to the pump.
    best = min((pair for pair in found if pair[1] >= 0.9 * most), default=(0.0, 0.0))
    if best[1] == 0.0:
        raise ValueError('no PI gains meet these margins at every operating point; '
                         'ask for less or narrow the operating range')
    return _two_figures(best[0]), _two_figures(best[1])


def _two_figures(value: float) -> float:
    if value == 0.0:
        return 0.0
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return round(math.floor(value / step + 1e-9) * step, 12)
