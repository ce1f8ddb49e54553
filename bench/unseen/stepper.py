# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The solver with the operator's end of the drive: controller, amplifiers, valves that stick.

One tick is a millisecond. What switches (controller, play, clipping) does so at a tick; between
two ticks the states are integrated with Heun's method in as many steps as the stiffest part needs.
"""
from math import exp, pi, sin

from bench.unseen.kernel import (along, ANGLE, CAVITATION, compiled, FAR, GAS, LOAD_SPEED,
                                 LOADING, PILOT, PRESSURE, PRIME, rates, SEEN_SPEED, SPEED, STATES,
                                 STROKE)
import numpy as np

TICK = 0.001
# Columns of what a run returns, one row a tick.
(U, SEEN_P, SEEN_Q, SEEN_W, SEEN_T, P_LOAD, TURNED, STROKE_NOW) = range(8)
COLUMNS = 8


@compiled
def amplified(u, t, event, m):
    """Return the command that reaches the pump."""
    u = u * m.command_gain * (1 - m.dropout * event)
    u -= m.command_shift * (1 - m.shift_fades * u / 10)
    return u + m.hunt * sin(2 * pi * m.hunt_hz * t)


@compiled
def held(u, plays, m):
    """Return the command behind the play of the linkage: a sum of plays of several widths."""
    if m.play <= 0:
        return u
    moved = (1 - m.play_share) * u
    for i in range(len(plays)):
        half = 0.5 * m.play * (i + 1) / len(plays) if m.play_spread > 0.5 else 0.5 * m.play
        plays[i] = min(max(plays[i], u - half), u + half)
        moved += m.play_share * plays[i] / len(plays)
    return moved


@compiled
def stuck(value, rest, threshold):
    """Return a value that stays where it is until the pull exceeds a threshold, then jumps."""
    return value if abs(value - rest) > threshold else rest


@compiled
def loading_pressure(v, t, rest, m):
    """Return the pressure that the proportional relief valve of the loading pump aims at."""
    v = min(v, m.amplifier_limit)
    if m.v_play > 0:
        rest[0] = min(max(rest[0], v - 0.5 * m.v_play), v + 0.5 * m.v_play)
        v = rest[0]
    if m.v_stick > 0:
        rest[1] = stuck(v, rest[1], m.v_stick)
        v = rest[1]
    pressure = along(v, m.pprv_commands, m.pprv_pressures)
    pressure *= 1 - m.coil_drift * (1 - exp(-t / m.coil_time))
    if pressure > m.chatter_from:
        pressure *= 1 + m.chatter * sin(2 * pi * m.chatter_hz * t)
    return pressure


@compiled
def run(start, setpoint, manual, pprv, rock, event, visc, noise, since, steps, m):
    """
    Integrate the drive; return a row of COLUMNS for each tick.

    Where `manual` is not negative it is the pump command; elsewhere the controller works.
    """
    ticks = len(setpoint)
    y = start.copy()
    first, second = np.zeros(STATES), np.zeros(STATES)
    seen, spare = np.zeros(4), np.zeros(4)
    out = np.zeros((ticks, COLUMNS))
    plays = np.zeros(3)
    rest = np.full(2, pprv[0])
    plate = u = integral = 0.0
    every = int(m.control_ticks)
    target = loading_pressure(pprv[0], since, rest, m)
    for k in range(ticks):
        t = since + k * 0.001
        rates(y, first, seen, target, rock[k], event[k], visc[k], m)
        if manual[k] >= 0:
            u = manual[k]
            integral = u
        elif k % every == 0:
            error = setpoint[k] - seen[SEEN_SPEED] - noise[k]
            step = m.ki * error * every * 0.001
            wanted = m.kp * error + integral + step
            if m.u_low < wanted < m.u_high:
                integral += step
            u = min(max(m.kp * error + integral, m.u_low), m.u_high)
        out[k, U] = u
        for i in range(4):
            out[k, SEEN_P + i] = seen[i]
        out[k, P_LOAD], out[k, TURNED] = y[LOADING], y[ANGLE]
        out[k, STROKE_NOW] = y[STROKE]
        reached = held(amplified(u, t, event[k], m), plays, m)
        if m.stick > 0:
            plate = stuck(reached, plate, m.stick)
            reached = plate
        target = loading_pressure(pprv[k], t, rest, m)
        # At standstill the load torque turns over within SIGN_WIDTH; an open valve is stiff.
        stiff = abs(y[SPEED]) < 1 or abs(y[LOAD_SPEED]) < 1 or y[PRESSURE] > 0.95 * m.relief_set
        count = steps[1] if stiff else steps[0]
        h = 0.001 / count
        decay = exp(-h / m.pilot_lag)
        for i in range(count):
            # The pilot valve is stiffer than the rest: its own exact solution.
            y[PILOT] = reached + (y[PILOT] - reached) * decay
            rates(y, first, seen, target, rock[k], event[k], visc[k], m)
            middle = y + h * first
            rates(middle, second, spare, target, rock[k], event[k], visc[k], m)
            y += 0.5 * h * (first + second)
            y[PRESSURE] = max(y[PRESSURE], CAVITATION)
            y[FAR] = max(y[FAR], CAVITATION)
            y[GAS] = max(y[GAS], 0.0)
    return out


def at_rest(m, loading: float) -> np.ndarray:
    """Return the states of a drive that stands still, its pump at no stroke."""
    y = np.zeros(STATES)
    y[PRIME] = m.prime_speed
    y[PRESSURE] = y[FAR] = 3e5
    y[LOADING] = loading
    return y


def steps_for(m, torque: float) -> np.ndarray:
    """
    Return how many steps a tick needs, in motion and where the drive is stiff.

    Heun's method is stable as long as a step times the fastest rate is below 2.
    """
    swing, rates_of_all = m.bulk_modulus / m.volume * 1.2, [400.0]
    if m.inertance > 0:
        share = min(m.far_share, 1 - m.far_share)
        rates_of_all.append(2 * np.sqrt(swing / share / m.inertance))
    lightest = m.inertia
    if m.shaft_stiffness > 0:
        lightest *= min(m.motor_share, 1 - m.motor_share)
        rates_of_all.append(m.shaft_damping / lightest + 3 * np.sqrt(m.shaft_stiffness / lightest))
    if m.gas_neck > 0:
        full = 2 * m.relief_set * (m.relief_set / m.gas_pressure) ** (1 / m.gas_exponent)
        rates_of_all.append((swing + full / m.gas_volume) / m.gas_neck)
    calm = sum(rates_of_all)
    stiff = calm + max((torque + m.coulomb) / (0.15 * lightest),
                       m.relief_gain / np.sqrt(1e5) * swing)
    return np.array([np.clip(np.ceil(rate * TICK / 1.2), 2, 40) for rate in (calm, stiff)],
                    dtype=np.int64)
