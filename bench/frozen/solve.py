# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Run a log: the controller every 10 ms, the machine between, a row each millisecond.

With numba the machine is stepped by Runge and Kutta's fourth order at 0.1 ms, without by SciPy's
LSODA (the same within a hundredth of the noise, some seventy times slower).
"""
from bench.frozen import equations as eq
from bench.frozen.jit import COMPILED, njit
import numpy as np
from scipy.integrate import solve_ivp

#: Milliseconds between two samples of the controller, on all rigs.
SAMPLE = 10
#: V, of the 12 bits for 10 V in which commands are given out.
COMMAND_STEP = 10 / 4096


@njit
def _runge_kutta(y, k, u, v, outside, p, c, steps, states):
    """Fill the states at the SAMPLE milliseconds from row k on; return the state after them."""
    h = 1e-3 / steps
    a, b, e, d, at = (np.empty(eq.STATES), np.empty(eq.STATES), np.empty(eq.STATES),
                      np.empty(eq.STATES), np.empty(eq.STATES))
    seen = np.empty(eq.OUTPUTS)
    for i in range(SAMPLE):
        states[i] = y
        now = outside[k + i]
        for j in range(steps):
            t = (k + i) * 1e-3 + j * h
            eq.rates(t, y, u, v, now, p, c, a, seen)
            for m in range(eq.STATES):
                at[m] = y[m] + 0.5 * h * a[m]
            eq.rates(t + 0.5 * h, at, u, v, now, p, c, b, seen)
            for m in range(eq.STATES):
                at[m] = y[m] + 0.5 * h * b[m]
            eq.rates(t + 0.5 * h, at, u, v, now, p, c, e, seen)
            for m in range(eq.STATES):
                at[m] = y[m] + h * e[m]
            eq.rates(t + h, at, u, v, now, p, c, d, seen)
            for m in range(eq.STATES):
                y[m] += h / 6.0 * (a[m] + 2.0 * b[m] + 2.0 * e[m] + d[m])
    return y


def _lsoda(y, k, u, v, outside, p, c, steps, states):
    """Do the same with SciPy."""
    seen, tiny = np.empty(eq.OUTPUTS), 1e-7 * np.ones(eq.STATES)
    tiny[[eq.P, eq.P_MOTOR, eq.COIL, eq.PPRV, eq.POPPET]] = 1.0
    tiny[[eq.STROKE, eq.LATE, eq.PLAY, eq.CREEP, eq.SWING, eq.SWING_RATE]] = 1e-12
    tiny[[eq.Q_LINE, eq.GAS, eq.WALL]] = 1e-10

    def rates(t, state):
        change = np.empty(eq.STATES)
        row = min(int(t * 1e3 + 1e-9), k + SAMPLE - 1)
        eq.rates(t, state, u, v, outside[row], p, c, change, seen)
        return change

    times = (k + np.arange(SAMPLE + 1)) * 1e-3
    found = solve_ivp(rates, times[[0, -1]], y, 'LSODA', times, rtol=1e-6, atol=tiny,
                      max_step=2e-3)
    states[:] = found.y.T[:-1]
    return found.y[:, -1].copy()


_advance = _runge_kutta if COMPILED else _lsoda


@njit
def _run(p, c, y, target, manual, v, outside, noise, steps, rows):
    """Fill the rows of a log."""
    states = np.empty((SAMPLE, eq.STATES))
    change, seen = np.empty(eq.STATES), np.empty(eq.OUTPUTS)
    integral = 0.0
    u = applied = 0.0
    for n in range(len(v)):
        k = n * SAMPLE
        if np.isnan(manual[n]):
            eq.rates(k * 1e-3, y, applied, v[n], outside[k], p, c, change, seen)
            read = np.rint((seen[eq.O_READ] + noise[k]) / p.speed_step) * p.speed_step
            error = target[n] - read
            wanted = p.kp * error + integral
            if 0.0 < wanted < 10.0:
                integral += p.ki * error * SAMPLE * 1e-3
            u = min(max(wanted, 0.0), 10.0)
        else:
            u = manual[n]
        u = np.rint(u / COMMAND_STEP) * COMMAND_STEP
        if k % p.hold_ms == 0:
            applied = u
        y = _advance(y, k, applied, v[n], outside, p, c, steps, states)
        for i in range(SAMPLE):
            eq.rates((k + i) * 1e-3, states[i], applied, v[n], outside[k + i], p, c, change, seen)
            rows[k + i] = seen
            rows[k + i, eq.O_U] = u


def run(plant, target: np.ndarray, manual: np.ndarray, v: np.ndarray, outside: np.ndarray,
        noise: np.ndarray, step: float = 1e-4, angle: float = 0.0) -> np.ndarray:
    """
    Run one log from rest.

    Parameters
    ----------
    plant : Plant
        The machine.
    target, manual, v : numpy.ndarray
        Set speed [rad/s], manual pump command [V] (not a number: closed loop), PPRV command [V],
        each every 10 ms.
    outside : numpy.ndarray
        Roughness, oil temperature, disturbance: a row each millisecond.
    noise : numpy.ndarray
        Noise of the speed reading [rad/s], each millisecond.
    step : float
        Step [s] of the solver.
    angle : float
        Angle [rad] at which the shaft stands.

    Returns
    -------
    numpy.ndarray
        A row each millisecond, columns ``equations.O_*``.

    """
    v = np.rint(v / COMMAND_STEP) * COMMAND_STEP
    rows = np.empty((len(v) * SAMPLE, eq.OUTPUTS))
    p, c = plant.packed()
    y = eq.start(p, c, v[0])
    y[eq.ANGLE] = angle
    _run(p, c, y, target, manual, v, outside, noise, max(int(round(1e-3 / step)), 1), rows)
    return rows
