# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands, temperatures and load roughness of a campaign, on a grid of 1 ms."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

LOGS = ('drilling', 'speed_sweep', 'open_loop', 'drilling_holdout')
QUANTUM = 10.0 / 4096
TEMPERATURES = {    # degC at start and end of each log
    'steady': ((50.0, 50.0), (50.0, 50.0), (50.0, 50.0), (52.0, 50.0)),
    'warm': ((38.0, 55.0), (52.0, 66.0), (70.0, 58.0), (40.0, 70.0)),
    'cold': ((18.0, 30.0), (26.0, 37.0), (40.0, 33.0), (20.0, 42.0)),
    'constant_warm': ((65.0, 65.0),) * 4,
}


def quantise(value: np.ndarray) -> np.ndarray:
    """Return commands in the steps of the 12-bit output."""
    return np.round(np.asarray(value) / QUANTUM) * QUANTUM


def _steps(n: int, start: float, first: float, draw_time, draw_level, rng) -> np.ndarray:
    out = np.full(n, start)
    t = first
    while t < n / 1000:
        out[int(round(t, 2) * 1000):] = draw_level(rng)
        t += draw_time(rng)
    return out


def _ramps(n: int, start: float, first: float, rng) -> np.ndarray:
    knots, levels = [0.0, first], [start, start]
    t = first
    while t < n / 1000:
        level = rng.uniform(12, 150)
        knots += [t + 1.0, t + (stay := rng.uniform(4, 9))]
        levels += [level, level]
        t += stay
    tick = np.interp(np.arange(0, n, 10) / 1000, knots, levels)
    return np.repeat(tick, 10)[:n]


def commands(log: str, n: int, rng: np.random.Generator, gentle: bool) -> dict[str, np.ndarray]:
    """
    Return set point (rpm), pump command (V, for the open loop), PPRV command (V) and the loop.

    With `gentle` every log is closed loop at 100 rpm: a campaign that exercises little.
    """
    manual, closed = np.zeros(n), True
    setpoint = np.full(n, 100.0)
    if gentle or log in ('drilling', 'drilling_holdout'):
        pprv = _steps(n, 0.5, 6.0, lambda r: r.uniform(3, 8), lambda r: r.uniform(0.8, 4.2), rng)
    elif log == 'speed_sweep':
        setpoint = _ramps(n, 60.0, rng.uniform(4, 5), rng)
        pprv = np.full(n, 1.0)
        t = 5.0
        while t < n / 1000:
            if rng.random() < 0.6:
                pprv[int(round(t, 2) * 1000):] = rng.uniform(0.7, 3.5)
            t += rng.uniform(4, 9)
    else:
        closed, setpoint = False, np.zeros(n)
        manual, pprv, t = np.full(n, 4.0), np.full(n, 1.0), 4.0
        while t < n / 1000:
            at = int(round(t, 2) * 1000)
            if rng.random() < 0.58:
                manual[at:] = rng.uniform(3.0, 7.2)
            else:
                pprv[at:] = rng.uniform(0.7, 5.2)
            t += rng.uniform(1.5, 5.0)
    return {'setpoint': setpoint, 'manual': quantise(manual), 'pprv': quantise(pprv),
            'closed': closed}


def temperature(log: str, n: int, kind: str | dict) -> np.ndarray:
    """Return degC over time: a named kind, or {log: (start, end)}."""
    start, end = kind[log] if isinstance(kind, dict) else TEMPERATURES[kind][LOGS.index(log)]
    return np.linspace(start, end, n)


def roughness(n: int, rng: np.random.Generator, size: float = 0.5,
              memory: float = 0.3) -> np.ndarray:
    """Return noise of the load, N m, with an exponential memory (s)."""
    a = np.exp(-1e-3 / memory)
    white = rng.standard_normal(n) * size * np.sqrt(1 - a * a)
    return lfilter([1.0], [1.0, -a], white)


def viscosity_factor(temp: np.ndarray, form: str, strength: float) -> np.ndarray:
    """Return viscosity at 50 degC over viscosity at `temp` (degC), to the power `strength`."""
    if strength == 0.0:
        return np.ones_like(temp)
    if form == 'reynolds':
        return np.exp(0.0335 * (temp - 50.0)) ** strength
    if form == 'vogel':    # nu = c exp(b / (T + t0)), through 46 cSt at 40 and 6.8 at 100 degC
        b = np.log(46 / 6.8) / (1 / (40 + 95.0) - 1 / (100 + 95.0))
        return np.exp(b / (50 + 95.0) - b / (temp + 95.0)) ** strength

    def walther(celsius: np.ndarray | float) -> np.ndarray:
        z40, z100 = np.log10(np.log10(46 + 0.7)), np.log10(np.log10(6.8 + 0.7))
        k40, k100 = np.log10(313.15), np.log10(373.15)
        slope = (z40 - z100) / (k100 - k40)
        return 10 ** 10 ** (z40 - slope * (np.log10(np.add(celsius, 273.15)) - k40)) - 0.7
    return (walther(50.0) / walther(temp)) ** strength
