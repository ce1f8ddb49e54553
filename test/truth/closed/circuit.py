# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The closed circuit: lines, charge line, servo and prime mover; Runge-Kutta of order four."""

from __future__ import annotations

from math import copysign, exp, tanh

import numpy as np

from .common import (advance, ANGLE, controller, delayed, EXTRA2, limited, MS_PER_TICK, PA, PB,
                     PER_MS, play, shaft, speed_seen, STEP, STROKE, stuck_thread, towards, W)
from .pieces import above, cross_leak, gas_capacity, line_drop, modulus, motor_flows, stroke
from ..terms import jit, root

PC, WP, STATES = EXTRA2 + 1, EXTRA2 + 2, EXTRA2 + 3
OUT = ('u', 'pa', 'pb', 'pc', 'w', 'torque', 'd_pump', 'w_pump', 'q_drain', 't_pump', 'theta',
       'w_seen', 'q_pump', 'q_motor', 'q_out', 'q_check', 't_drive', 't_lost', 'q_charge')


@jit
def pump_leak(p, pressure, fluid):
    """Return one side's leakage of the pump (odd in pressure)."""
    q = p.p_lam * pressure * fluid + p.p_turb * root(pressure, 0.5e5)
    if p.g_pump > 0.0:
        if p.f_pump_leakage == 0.0:
            q += p.g_pump * pressure * fluid
        elif p.f_pump_leakage == 1.0:
            q += p.g_pump * pressure * (0.7 * fluid + 0.3 * abs(pressure) / 150e5)
        else:
            q += p.g_pump * root(pressure, 0.5e5) * 150e5 ** 0.5
    return q


@jit
def pump(p, x, dp, low, wp):
    """Return the pump's displacement and the flow that it moves from one line to the other."""
    if p.k_swash > 0.0:
        if p.f_swash_compliance == 0.0:
            x *= 1.0 - p.k_swash * dp * tanh(20.0 * x)
        else:
            x -= 0.6 * p.k_swash * dp * tanh(abs(20.0 * x))
    d = p.d_pump * x
    fill = 0.5 * (1.0 + tanh((low + 0.7e5) / 0.15e5))
    if p.starve > 0.0:
        if p.f_suction_starvation == 0.0:
            fill -= p.starve * (max(abs(x) - 0.55, 0.0) / 0.45) ** 2
        else:
            fill -= p.starve * abs(x) / (1.0 + exp((low - p.c_set + 1e5) / 1.5e5))
    swept = d * wp * fill
    if p.c_comp > 0.0:
        swept -= p.c_comp * dp * wp * (
            abs(d) if p.f_compressibility_flow == 0.0 else 0.45 * p.d_pump + 0.2 * abs(d))
    return d, swept


@jit
def servo_rate(p, y, dy, target):
    """Return the rate of the swash plate."""
    rate = delayed(p, y, dy, target, p.extra_lag, p.f_pump_lag == 1.0)
    if p.servo_load > 0.0:
        if p.f_servo_supply == 0.0:
            rate *= (max(y[PC], 3e5) / p.c_set) ** (3.0 * p.servo_load)
        else:
            rate /= 1.0 + p.servo_load * abs(y[PA] - y[PB]) / 200e5
    return limited(rate, p.rate_limit, p.f_pump_rate_limit)


@jit
def rhs(p, y, dy, aux, target, d_motor, rock, push, fluid, temperature, engine,
        sticky_a, sticky_b):
    """Write the derivatives of all states, and flows and torques that are not states."""
    pa, pb, pc, w, wp = y[PA], y[PB], y[PC], y[W], y[WP]
    dp = pa - pb
    dy[STROKE] = servo_rate(p, y, dy, target)
    d, swept = pump(p, y[STROKE], dp, min(pa, pb), wp)
    leak_a, leak_b = pump_leak(p, pa, fluid), pump_leak(p, pb, fluid)
    share = p.case_share
    inside = (1.0 - share) * (leak_a - leak_b)
    leak_a, leak_b = share * leak_a, share * leak_b
    cross = (above(dp - p.p_set, 1e5) - above(-dp - p.p_set, 1e5)) * p.g_relief
    cross += cross_leak(p, dp, fluid)
    if p.g_crack > 0.0:
        over = above(abs(dp) - p.p_crack, 1e5)
        if p.f_cross_port_relief_cracking == 1.0:
            over *= over / 60e5
        cross += copysign(p.g_crack * over, dp)
    drop = line_drop(p, p.per_turn * d_motor * w)
    ma, mb = pa - drop, pb + drop
    take, give, case = motor_flows(p, ma, mb, w, fluid, d_motor)
    check_a = p.g_check0 * sticky_a * above(pc - pa, 0.1e5)
    check_b = p.g_check0 * sticky_b * above(pc - pb, 0.1e5)
    if p.g_check > 0.0:
        check_a -= p.g_check * root(max(pa - pc, 0.0), 0.5e5) * 150e5 ** 0.5
    g_flush = p.g_flush
    if p.flush_warm > 0.0:
        g_flush += p.flush_warm * p.q_rated / p.c_set * max((temperature - 40.0) / 20.0, 0.0)
    to_b = 0.5 * (1.0 + tanh(dp / 4e5))
    flush_a, flush_b = g_flush * pa * (1.0 - to_b), g_flush * pb * to_b
    net_a = swept - inside - leak_a - cross - take + check_a - flush_a
    net_b = -swept + inside - leak_b + cross + give + check_b - flush_b
    # charge line
    c_set = p.c_set
    made = p.d_charge * wp
    if p.charge_loss > 0.0:
        if p.f_charge_pressure_loss == 0.0:
            c_set *= 1.0 - min(p.charge_loss, 0.75)
        else:
            made -= 2.5 * p.charge_loss * made * pc / p.c_set
    spill = p.g_charge * above(pc - c_set, 0.3e5)
    net_c = made - spill - check_a - check_b
    dy[PA] = net_a / (p.volume / modulus(p, pa) + gas_capacity(p, pa))
    dy[PB] = net_b / (p.volume / modulus(p, pb))
    dy[PC] = net_c / (p.v_charge / modulus(p, pc))
    for i in (PA, PB, PC):
        if y[i] < -0.9e5:
            dy[i] = max(dy[i], 0.0)
    drive, lost, load = shaft(p, y, dy, ma - mb, d_motor, rock, push, temperature)
    ideal = d * dp
    t_pump = ideal + p.p_share * abs(ideal)
    t_all = t_pump + p.d_charge * pc * (1.0 + p.p_share)
    share = t_all / p.engine_torque
    if p.f_pump_speed_droop == 1.0:
        share *= 0.6 + 0.5 * abs(share)
    dy[WP] = (p.w_pump * (engine - (p.droop + p.droop0) * share) - wp) / 0.15
    aux[0], aux[1], aux[2], aux[3], aux[4] = load, d, case, t_all, swept
    aux[5], aux[6], aux[7] = take, leak_a + leak_b + case + flush_a + flush_b, check_a + check_b
    aux[8], aux[9], aux[10] = drive, lost, made - spill


@jit
def run(numbers, setpoint, manual, closed, rock, push, fluid, temperature, engine, noise,
        breakout, d_motor, fraction):
    """
    Integrate one log and return one row of OUT per millisecond.

    Inputs per millisecond: set point (rad/s), command of the open loop (V), magnitude of the
    rock's torque, signed torque, leakage per leakage at 50 degC, degC, prime mover's relative
    speed, break-out torque in reverse, one motor's displacement
    (m^3/rad). `noise` of the speed per 10 ms; `fraction` refines the
    step (1: STEP).
    """
    p = numbers[0]
    n = setpoint.shape[0]
    out = np.zeros((n, 19))
    y, dy = np.zeros(STATES), np.zeros((4, STATES))
    mid, aux = np.zeros(STATES), np.zeros(11)
    y[PA] = y[PB] = y[PC] = p.c_set
    y[WP] = p.w_pump * engine[0]
    h = STEP / fraction
    integral = u = behind = inner = last = loose = 0.0
    open_a = open_b = True
    for k in range(n):
        seen = speed_seen(p, y)
        if k % MS_PER_TICK == 0:
            if closed:
                u, integral = controller(p, setpoint[k], seen + noise[k // MS_PER_TICK], integral,
                                         d_motor[k] / p.d_motor)
            else:
                u = manual[k]
            u = round(u * 409.6) / 409.6
        behind, inner = play(0.5 * p.u_play, p.f_pump_hysteresis, u, behind, inner, last)
        last = u
        shift, zero = p.u_offset, p.u_zero
        if p.f_pump_command_offset == 1.0:
            shift, zero = 0.5 * p.u_offset, p.u_zero + 0.5 * p.u_offset
        target = stroke(behind - shift, zero, p.corner)
        if p.servo_gain > 0.0 and (target < 0.0) == (p.f_asymmetric_servo == 0.0):
            target *= 1.0 - p.servo_gain
        if p.check_stick > 0.0:
            need = 0.2e5 if open_a else p.check_stick
            open_a = y[PC] - y[PA] > need
            need = 0.2e5 if open_b else p.check_stick
            open_b = y[PC] - y[PB] > need
        hold = rock[k]
        if breakout[k] > 0.0:
            if k == 0 or breakout[k - 1] == 0.0:
                loose = y[ANGLE]
            hold += stuck_thread(breakout[k], y[ANGLE] - loose)
        args = (target, d_motor[k], hold, push[k], fluid[k], temperature[k], engine[k],
                1.0 if open_a else 0.0, 1.0 if open_b else 0.0)
        rhs(p, y, dy[0], aux, *args)
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = u, y[PA], y[PB], y[PC]
        out[k, 4], out[k, 5], out[k, 6], out[k, 7] = dy[0, ANGLE], aux[0], aux[1], y[WP]
        out[k, 8], out[k, 9], out[k, 10], out[k, 11] = aux[2], aux[3], y[ANGLE], seen
        out[k, 12], out[k, 13], out[k, 14], out[k, 15] = aux[4], aux[5], aux[6], aux[7]
        out[k, 16], out[k, 17], out[k, 18] = aux[8], aux[9], aux[10]
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
