# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the head is told and what the rock does to it, on a grid of 1 ms."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from ..profiles import roughness, viscosity_factor

LOGS = ('drilling', 'reverse', 'sweep', 'holdout')


def _ramp(knots: list[float], levels: list[float], n: int, slope: float = 0.4) -> np.ndarray:
    """Return steps at `knots` (s) to `levels`, each over `slope` seconds."""
    t, y = [0.0], [levels[0]]
    for at, before, after in zip(knots, levels, levels[1:]):
        t += [at, at + slope]
        y += [before, after]
    return np.interp(np.arange(n) / 1000, t, y)


def _times(n: int, first: float, low: float, high: float, rng) -> list[float]:
    out = [first]
    while out[-1] < n / 1000:
        out.append(out[-1] + rng.uniform(low, high))
    return out[:-1]


def _layers(n: int, low: float, high: float, rng) -> np.ndarray:
    at = _times(n, rng.uniform(3, 5), 3.0, 7.0, rng)
    return _ramp(at, [0.15, *rng.uniform(low, high, len(at))], n, 0.25)


def _overrun(n: int, direction: np.ndarray, share: float, rng) -> np.ndarray:
    """Return two phases in which the load drives the head (signed, in the way it turns)."""
    out = np.zeros(n)
    for part in (0.25, 0.7):
        a = int(n * (part + rng.uniform(0, 0.08)))
        b = a + int(rng.uniform(3000, 5000))
        window = np.interp(np.arange(n), [a, a + 400, b, b + 400], [0, 1, 1, 0])
        out -= window * np.sign(direction) * share * rng.uniform(0.5, 1.0)
    return out


def commands(log: str, n: int, scale: dict[str, float], rng,
             dead: float, circuit: str, second: bool) -> dict[str, np.ndarray | bool]:
    """
    Return set point, command of the open loop, rock, signed torque, break-out and the loop.

    Speeds in rad/s, torques in N m, commands in V; `dead` is the dead band.
    A valve is opened slower and less: full opening is more than rated speed. With `second` the
    motors run with their second displacement for a while, against softer rock.
    """
    setpoint = manual = breakout = np.zeros(n)
    push = np.zeros(n)
    closed = log != 'sweep'
    if log == 'drilling':
        at = _times(n, rng.uniform(4, 7), 6.0, 10.0, rng)
        setpoint = _ramp(at, [0.5, *rng.uniform(0.3, 0.85, len(at))], n, 0.5)
        rock = _layers(n, 0.25, 0.95, rng)
    elif log == 'reverse':
        a, b, c, d = np.cumsum([n * 0.27, n * 0.1, n * 0.3, n * 0.08]) / 1000
        fast, back, again = rng.uniform(0.4, 0.8), -rng.uniform(0.25, 0.6), rng.uniform(0.4, 0.8)
        setpoint = _ramp([0.5, a, b, c, d], [0, fast, 0, back, 0, again], n, 0.8)
        rock = np.where(setpoint < 0, rng.uniform(0.1, 0.25), _layers(n, 0.25, 0.8, rng))
        breakout = np.where(setpoint < 0, rng.uniform(0.45, 0.7), 0.0)
    elif log == 'sweep':
        level = rng.uniform(0.12, 0.9, 12) * rng.choice([-1, 1], 12)
        level[:4] = np.abs(level[:4]) * (1, -1, 1, -1)
        at = list(np.arange(1, 12) * n / 12000 + rng.uniform(-0.4, 0.4, 11))
        valve = circuit == 'valve'
        way = _ramp(at, list(level), n, 0.6 if valve else 0.05) * (0.6 if valve else 1.0)
        manual = np.sign(way) * (dead + np.abs(way) * (10 - dead))
        rock = _layers(n, 0.1, 0.6, rng)
        push = _overrun(n, way, 0.5, rng)
    else:
        at = _times(n, rng.uniform(4, 6), 5.0, 8.0, rng)
        level = [0.5, *rng.uniform(0.25, 0.85, len(at))]
        level[2::3] = [-x for x in level[2::3]]
        setpoint = _ramp(at, level, n, 0.7)
        rock = _layers(n, 0.2, 0.85, rng)
        push = _overrun(n, setpoint, 0.35, rng)
    rough = roughness(n, rng, 0.006)
    rock = np.maximum(rock + rough, 0.02)
    # an overrunning phase is one without much rock
    rock = rock * (1 - np.minimum(np.abs(push) / 0.1, 1.0) * 0.85)
    small = np.zeros(n)
    if second and log in ('drilling', 'holdout'):
        small[int(0.45 * n):int(0.7 * n)] = 10.0
        rock = rock * np.where(small > 0, 0.45, 1.0)
        push = push * np.where(small > 0, 0.45, 1.0)
    return {'small': small, 'setpoint': setpoint * scale['W'], 'manual': np.asarray(manual, float),
            'rock': rock * scale['T'], 'push': push * scale['T'],
            'breakout': breakout * scale['T'], 'closed': closed}


def temperature(n: int, warm: bool, rng) -> np.ndarray:
    """Return oil temperature, degC: near 50, or far from it and moving where `warm`."""
    if warm:
        start = rng.uniform(32, 66)
        end = start + rng.uniform(8, 16) * (1 if start < 50 else -1)
    else:
        start = 50 + 0.7 * rng.standard_normal()
        end = start + rng.uniform(-0.7, 0.7)
    bend = np.linspace(0, 1, n) ** rng.uniform(0.7, 1.3)
    return start + (end - start) * bend


def fluidity(degrees: np.ndarray, form: str, strength: float) -> np.ndarray:
    """Return viscosity at 50 degC over viscosity now."""
    return viscosity_factor(degrees, form, strength)


def engine(n: int, wander: float, rng) -> np.ndarray:
    """Return the prime mover's relative speed without load: it wanders slowly."""
    slow = roughness(n, rng, 1.0, 4.0)
    return 1.0 + wander * np.tanh(slow)


def switched(volts: np.ndarray, lag: float = 0.02) -> np.ndarray:
    """Return the share of the way to the second displacement (its valve takes `lag` seconds)."""
    return lfilter([1e-3 / lag], [1.0, 1e-3 / lag - 1.0], volts > 5.0)
