# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a campaign asks of the machine: commands, rock, oil temperature."""
from typing import NamedTuple

from bench.frozen.plant import RPM
from bench.frozen.solve import SAMPLE
import numpy as np
from scipy.signal import lfilter

LOGS = ('drilling', 'speed_sweep', 'open_loop', 'drilling_holdout')


class Profile(NamedTuple):
    """A log's inputs: every 10 ms, but the last two every millisecond."""

    target: np.ndarray      # rad/s
    manual: np.ndarray      # V, not a number in closed loop
    pprv: np.ndarray        # V
    rough: np.ndarray       # 1, share of the load
    oil: np.ndarray         # degC


def _holds(rng: np.random.Generator, count: int, low: float, high: float, first: float,
           draw: object) -> np.ndarray:
    """
    Hold drawn values for low to high seconds; some are reached by a ramp or bear a wave.

    The sequencer changes them at tenths of a second, so that slow rows show when.
    """
    values = np.full(count, first)
    tenth = 100 // SAMPLE
    k = int(rng.uniform(low, high) * 10) * tenth
    while k < count:
        end = min(k + int(rng.uniform(low, high) * 10) * tenth, count)
        goal = draw()
        values[k:] = goal
        way = rng.random()
        if way < 0.25:
            ramp = min(int(rng.uniform(5, 25)) * tenth, end - k)
            values[k:k + ramp] = np.linspace(values[k - 1], goal, ramp)
        elif way < 0.35:
            t = np.arange(end - k) * SAMPLE * 1e-3
            values[k:end] = goal * (1 + rng.uniform(0.03, 0.12)
                                    * np.sin(2 * np.pi * rng.uniform(0.15, 0.9) * t))
        k = end
    return values


def rough(rng: np.random.Generator, count: int, size: float, time: float) -> np.ndarray:
    """Rough rock: noise of a standard deviation, through two poles of a time [s]."""
    keep = np.exp(-1e-3 / time)
    noise = rng.standard_normal(count + int(6 * time * 1e3))
    smooth = lfilter([1 - keep], [1, -keep], lfilter([1 - keep], [1, -keep], noise))
    # Standard deviation of white noise behind two equal poles.
    gain = (1 - keep) ** 2 * np.sqrt((1 + keep ** 2) / (1 - keep ** 2) ** 3)
    return size * smooth[-count:] / gain


def oil(rng: np.random.Generator, count: int, wide: bool) -> np.ndarray:
    """Oil temperature: near 50 degC, or, where wide, of a machine that warms or cools."""
    start, end = rng.uniform(28, 72, 2) if wide else 50 + rng.uniform(-1.5, 1.5, 2)
    t = np.arange(count) * 1e-3
    return end + (start - end) * np.exp(-t / rng.uniform(20, 120))


def draw(log: str, rng: np.random.Generator, nominal: float, seconds: float, wide: bool,
         roughness: float, patch: float, heavy: bool) -> Profile:
    """
    Draw the profile of a log.

    Parameters
    ----------
    log : str
        One of LOGS.
    rng : numpy.random.Generator
        What is drawn, is drawn from it.
    nominal : float
        Speed [rpm] that the rig drills at.
    seconds : float
        Length of the log.
    wide : bool
        Oil warms up or cools down.
    roughness, patch : float
        Size (share of the load) and time [s] of the rock's roughness.
    heavy : bool
        Some rock brings the pressure up to three quarters of the relief valve's.

    """
    count = int(round(seconds * 1e3 / SAMPLE))
    top = 6.3 if heavy else 4.8
    manual = np.full(count, np.nan)
    if log.startswith('drilling'):
        target = np.full(count, nominal)
        pprv = _holds(rng, count, 3.0, 8.0, 0.5, lambda: rng.uniform(0.7, top))
    elif log == 'speed_sweep':
        target = _holds(rng, count, 3.5, 8.0, 0.6 * nominal,
                        lambda: nominal * rng.choice([rng.uniform(0.12, 0.4),
                                                      rng.uniform(0.4, 1.35)], p=[0.25, 0.75]))
        pprv = _holds(rng, count, 5.0, 10.0, 1.0, lambda: rng.uniform(0.8, 0.8 * top))
    else:
        target = np.zeros(count)
        manual = _holds(rng, count, 3.0, 6.0, 4.0, lambda: rng.uniform(2.6, 7.0))
        pprv = _holds(rng, count, 4.0, 9.0, 1.0, lambda: rng.uniform(0.8, top))
    rows = count * SAMPLE
    return Profile(target * RPM, manual, np.clip(pprv, 0, 10),
                   rough(rng, rows, roughness, patch), oil(rng, rows, wide))
