# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The valve-driven head: spool, four edges, two lines; Runge-Kutta of order four."""

from __future__ import annotations

import numpy as np

from .common import (advance, ANGLE, controller, delayed, EXTRA2, MS_PER_TICK, PA, PB, PER_MS,
                     play, shaft, speed_seen, STEP, STROKE, stuck_thread, towards, W)
from .pieces import cross_leak, gas_capacity, modulus, motor_flows, stroke
from ..terms import jit, root

STATES = EXTRA2 + 1
OUT = ('u', 'pa', 'pb', 'ps', 'w', 'torque', 'opening', 'q_drain', 'theta', 'w_seen', 'q_a',
       'q_b', 'q_motor', 'q_give', 't_drive', 't_lost', 'pr')


@jit
def rhs(p, y, dy, aux, aim, d_motor, rock, push, fluid, temperature, supply):
    """Write the derivatives of all states, and flows and torques that are not states."""
    pa, pb, w = y[PA], y[PB], y[W]
    dy[STROKE] = delayed(p, y, dy, aim, p.extra_lag, p.f_valve_lag == 1.0)
    zero = p.u_zero + p.u_dead
    if p.f_valve_dead_band == 1.0:
        zero = p.u_zero + (1.6 * p.u_dead if y[STROKE] > 0.0 else 0.0)
    # the overlap takes from the stroke: full opening stays where it is
    opening = stroke(y[STROKE], zero, p.corner)
    to_a, to_b = p.k_valve * max(opening, 0.0), p.k_valve * max(-opening, 0.0)
    take, give, case = motor_flows(p, pa, pb, w, fluid, d_motor)
    across = cross_leak(p, pa - pb, fluid)
    ps, pr = supply, 0.0
    if p.sag > 0.0:
        ps -= p.sag * abs(take)
    if p.p_back > 0.0:
        pr = p.p_back
        if p.f_back_pressure == 1.0:
            pr *= 0.4 + 0.8 * abs(take) / p.q_rated
    q_a = to_a * root(ps - pa, 0.5e5) - to_b * root(pa - pr, 0.5e5)
    q_b = to_b * root(ps - pb, 0.5e5) - to_a * root(pb - pr, 0.5e5)
    dy[PA] = (q_a - take - across) / (p.volume / modulus(p, pa) + gas_capacity(p, pa))
    dy[PB] = (q_b + give + across) / (p.volume / modulus(p, pb))
    for i in (PA, PB):
        if y[i] < -0.9e5:
            dy[i] = max(dy[i], 0.0)
    drive, lost, load = shaft(p, y, dy, pa - pb, d_motor, rock, push, temperature)
    aux[0], aux[1], aux[2], aux[3], aux[4] = load, opening, case, q_a, q_b
    aux[5], aux[6], aux[7], aux[8], aux[9], aux[10] = take, give, drive, lost, pr, ps


@jit
def run(numbers, setpoint, manual, closed, rock, push, fluid, temperature, supply, noise,
        breakout, d_motor, fraction):
    """
    Integrate one log and return one row of OUT per millisecond.

    As circuit.run; `supply` is the supply pressure over its nominal value.
    """
    p = numbers[0]
    n = setpoint.shape[0]
    out = np.zeros((n, 17))
    y, dy = np.zeros(STATES), np.zeros((4, STATES))
    mid, aux = np.zeros(STATES), np.zeros(11)
    y[PA] = y[PB] = 5e5
    h = STEP / fraction
    integral = u = behind = inner = last = loose = held = 0.0
    for k in range(n):
        seen = speed_seen(p, y)
        if k % MS_PER_TICK == 0:
            if closed:
                u, integral = controller(p, setpoint[k], seen + noise[k // MS_PER_TICK], integral,
                                         d_motor[k] / p.d_motor)
            else:
                u = manual[k]
            u = round(u * 409.6) / 409.6
        if abs(u - held) > p.u_stick:
            held = u
        elif p.u_stick == 0.0:
            held = u
        behind, inner = play(0.5 * p.spool_play, 0.0, held, behind, inner, last)
        last = held
        hold = rock[k]
        if breakout[k] > 0.0:
            if k == 0 or breakout[k - 1] == 0.0:
                loose = y[ANGLE]
            hold += stuck_thread(breakout[k], y[ANGLE] - loose)
        args = (behind, d_motor[k], hold, push[k], fluid[k], temperature[k],
                supply[k] * p.p_supply)
        rhs(p, y, dy[0], aux, *args)
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = u, y[PA], y[PB], aux[10]
        out[k, 4], out[k, 5], out[k, 6], out[k, 7] = dy[0, ANGLE], aux[0], aux[1], aux[2]
        out[k, 8], out[k, 9], out[k, 10], out[k, 11] = y[ANGLE], seen, aux[3], aux[4]
        out[k, 12], out[k, 13], out[k, 14], out[k, 15] = aux[5], aux[6], aux[7], aux[8]
        out[k, 16] = aux[9]
        for _ in range(PER_MS * fraction):
            rhs(p, y, dy[0], aux, *args)
            towards(mid, y, dy[0], 0.5 * h)
            rhs(p, mid, dy[1], aux, *args)
            towards(mid, y, dy[1], 0.5 * h)
            rhs(p, mid, dy[2], aux, *args)
            towards(mid, y, dy[2], h)
            rhs(p, mid, dy[3], aux, *args)
            advance(y, dy, h)
    return out
