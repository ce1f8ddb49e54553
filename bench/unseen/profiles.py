# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What operators do, how the oil warms, how rough the rock is and when faults strike."""
from math import exp, log
from typing import NamedTuple

from bench.unseen.machine import RPM
from bench.unseen.stepper import TICK
import numpy as np
from scipy.signal import lfilter

# What the converters of the rig's computer resolve, V.
CONVERTER = 10 / 4096
# Kinematic viscosity of ISO VG 46 at 40 and 100 degC, mm^2/s.
AT_40, AT_100 = 46.0, 6.8


class Commands(NamedTuple):
    """What goes into the drive, at each tick; a manual command below 0 means the controller."""

    name: str
    setpoint: np.ndarray
    manual: np.ndarray
    pprv: np.ndarray
    # Ticks that pass before the logger is switched on.
    before: int


def _steps(rng, ticks: int, grid: int, hold: tuple[float, float], values) -> np.ndarray:
    """Return random levels, held for random times that end with a row of the logger."""
    levels, at = np.zeros(ticks), 0
    while at < ticks:
        until = at + max(round(rng.uniform(*hold) / TICK / grid), 1) * grid
        levels[at:until] = values()
        at = until
    return levels


def _ramped(levels: np.ndarray, grid: int, seconds: float) -> np.ndarray:
    """Return the levels with a limit on their slope, as staircase of the logger's rows."""
    width = max(round(seconds / TICK / grid), 1)
    rows = np.convolve(np.concatenate([np.full(width, levels[0]), levels[::grid]]),
                       np.ones(width) / width)[width:width + len(levels[::grid])]
    return np.repeat(rows, grid)[:len(levels)]


def _brake(rng, ticks: int, grid: int, hard: bool) -> np.ndarray:
    """Return the command of the loading valve for beds of rock of random strength."""
    top = rng.uniform(5.6, 6.4) if hard or rng.random() < 0.25 else rng.uniform(3.6, 5.2)
    volts = _steps(rng, ticks, grid, (1.5, 6), lambda: rng.uniform(1.2, top))
    if rng.random() < 0.5:
        volts = _ramped(volts, grid, rng.uniform(0.1, 1.0))
    volts[:round(rng.uniform(1, 4) / TICK / grid) * grid] = rng.uniform(0.6, 1.2)
    return volts


def _sweep(rng, ticks: int, grid: int, full: float) -> np.ndarray:
    """Return a setpoint that goes up and down: a slow sine or ramps."""
    low, high = rng.uniform(0.08, 0.2) * full, rng.uniform(0.65, 0.85) * full
    if rng.random() < 0.4:
        t = np.arange(0, ticks, grid) * TICK
        wave = 0.5 - 0.5 * np.cos(2 * np.pi * t / rng.uniform(8, 20))
        return np.repeat(low + (high - low) * wave, grid)[:ticks]
    levels = _steps(rng, ticks, grid, (3, 7), lambda: rng.uniform(low, high))
    return _ramped(levels, grid, rng.uniform(0.5, 3))


def commands(name: str, seconds: float, grid: int, full: float, hard: bool,
             rng: np.random.Generator) -> Commands:
    """
    Return one log's commands.

    Parameters
    ----------
    name : str
        drilling, sweep, manual or holdout.
    seconds : float
        Length of the log.
    grid : int
        Ticks between two rows (or two ticks of the controller, whichever is longer).
    full : float
        Speed at full stroke of the pump, rad/s.
    hard : bool
        Whether rock strong enough for high pressure comes.
    rng : numpy.random.Generator
        Where chance comes from.

    """
    before = round(rng.uniform(2, 4) / TICK / grid) * grid if rng.random() < 0.25 else 0
    ticks = round(seconds / TICK) + before
    pprv = _brake(rng, ticks, grid, hard)
    setpoint, manual = np.zeros(ticks), np.full(ticks, -1.0)
    if name == 'manual':
        manual = _steps(rng, ticks, grid, (1.5, 5), lambda: rng.uniform(2.8, 7.8))
        if rng.random() < 0.5:
            manual = _ramped(manual, grid, rng.uniform(0.2, 1))
        if rng.random() < 0.4:
            middle, half = rng.uniform(4, 6), rng.uniform(0.3, 1.2)
            period = max(round(rng.uniform(0.6, 3) / TICK / grid), 2) * grid
            start = ticks // 2
            square = np.arange(ticks - start) % period < period // 2
            manual[start:] = middle + half * np.where(square, 1, -1)
    elif name == 'sweep':
        setpoint = _sweep(rng, ticks, grid, full)
    else:
        setpoint[:] = round(rng.uniform(0.38, 0.62) * full / RPM / 5) * 5 * RPM
        if name == 'holdout' or rng.random() < 0.4:
            second = ticks // 2 + round(rng.uniform(0, 3) / TICK / grid) * grid
            setpoint[second:] *= rng.uniform(0.6, 1.25)
        if rng.random() < 0.5:
            # A pause: the rod is changed.
            start = round(rng.uniform(0.35, 0.8) * ticks / grid) * grid
            stop = start + round(rng.uniform(1.5, 3) / TICK / grid) * grid
            setpoint[start:stop] = 0.0
            setpoint = _ramped(setpoint, grid, rng.uniform(1.2, 2.5))
            pprv[start:stop] = 1.2
    return Commands(name, setpoint, np.where(manual >= 0, np.round(manual / CONVERTER) * CONVERTER,
                                             -1.0),
                    np.round(pprv / CONVERTER) * CONVERTER, before)


def roughness(ticks: int, rng: np.random.Generator) -> np.ndarray:
    """Return the factor by which rock is rougher than its mean: two coloured noises."""
    factor = np.ones(ticks)
    for seconds, share in ((0.03, rng.uniform(0.001, 0.003)), (0.6, rng.uniform(0.001, 0.003))):
        keeps = exp(-TICK / seconds)
        white = rng.standard_normal(ticks) * np.sqrt(1 - keeps ** 2)
        factor += share * lfilter([1], [1, -keeps], white)
    return factor


def oil(ticks: int, since: float, extra: dict, rng: np.random.Generator) -> np.ndarray:
    """Return the oil's temperature in degC: near 50, or where the oil's effect puts it."""
    t = since + np.arange(ticks) * TICK
    if 'oil.start' in extra:
        start = extra['oil.start'] + rng.uniform(-5, 5)
        return start + extra['oil.rise'] * (1 - np.exp(-(t - since) / 25))
    return rng.uniform(49.3, 50.2) + 1.5 * (1 - np.exp(-t / 90))


def viscosity_ratio(celsius: np.ndarray, law: str) -> np.ndarray:
    """Return by which factor the oil is thinner than at 50 degC."""
    kelvin, hot, cold = np.append(celsius, 50.0) + 273.15, 373.15, 313.15
    if law == 'walther':
        slope = log(log(AT_40 + 0.7) / log(AT_100 + 0.7)) / log(hot / cold)
        nu = np.exp(log(AT_40 + 0.7) * (cold / kelvin) ** slope) - 0.7
    else:
        pole = 178.15
        b = log(AT_40 / AT_100) / (1 / (cold - pole) - 1 / (hot - pole))
        nu = AT_40 * np.exp(b / (kelvin - pole) - b / (cold - pole))
    return nu[-1] / nu[:-1]


def events(kind: str, ticks: int, since: float, total: float,
           rng: np.random.Generator) -> np.ndarray:
    """Return, from 0 to 1, when a fault strikes that comes and goes."""
    event = np.zeros(ticks)
    t = np.arange(ticks) * TICK
    if kind == 'growing':
        return np.clip((since + t - 0.2 * total) / (0.7 * total), 0, 1)
    if kind == 'period':
        period = rng.uniform(4, 8)
        return ((t + rng.uniform(0, period)) % period < rng.uniform(0.25, 0.5) * period) * 1.0
    gap, length = {'bursts': (4, (0.6, 2.5)), 'jolts': (3, (0.15, 0.7)),
                   'blinks': (2, (0.04, 0.2))}.get(kind, (np.inf, (0, 0)))
    at = rng.exponential(gap) if kind else np.inf
    while at < ticks * TICK:
        event[int(at / TICK):int((at + rng.uniform(*length)) / TICK)] = 1.0
        at += 0.5 + rng.exponential(gap)
    return event
