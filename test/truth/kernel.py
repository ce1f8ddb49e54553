# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The truth's integrator: symplectic in hose and shaft, linearly implicit in valve and friction.

States: two fast stages and two main stages of the actuators, command with play, two line
volumes with a hose between them, unsteady friction of the hose, motor and load inertia with the
angle and the twist between them, prime mover speed, speed filter.
"""

from __future__ import annotations

from math import copysign, pi

import numpy as np

from .terms import (curve, friction, friction_sign, hose_drop, jit, load_factor,
                    motor_leak, pump_compression, pump_leak, relief, ripple, sign_slope, surface,
                    volume_modulus)
from .unit import P_STEP, P_TOP, U_STEP, W_STEP, W_TOP

STEP = 0.25e-3
PER_MS = 4
MS_PER_TICK = 10
OUT = ('u', 'p1', 'p2', 'q_motor', 'w', 'torque', 'd_pump', 'w_pump', 'q_drain', 'q_pump',
       'q_relief', 't_motor', 'theta', 'w_filtered', 'w_load', 't_load', 'p_out')


@jit
def hysteresis(p, u, s, z, u_last):
    """Return the command behind the play: forms play, Bouc-Wen, Prandtl-Ishlinskii."""
    half = 0.5 * p.play
    if half <= 0.0:
        return u, z
    if p.f_pump_hysteresis == 0.0:
        return max(u - half, min(u + half, s)), z
    if p.f_pump_hysteresis == 1.0:
        du = u - u_last
        x = abs(z) / half
        z += du * (1.0 - x * x * (1.0 if du * z > 0.0 else 0.0)) if x < 1.0 or du * z < 0 else 0.0
        z = max(-half, min(half, z))
        return u - z, z
    first, second = 0.5 * half, 1.5 * half
    a = 2.0 * s - z
    a = max(u - first, min(u + first, a))
    z = max(u - second, min(u + second, z))
    return 0.5 * (a + z), z


@jit
def stage_pump(p, target, fast, d, extra1, extra2, h):
    """Advance the swash plate: fast stage, main lag, extra lag, rate limit."""
    aim = target
    if p.extra_lag > 0.0:
        if p.f_pump_lag == 0.0:
            extra1 += h / (p.extra_lag + h) * (aim - extra1)
            aim = extra1
        else:
            half = 0.5 * p.extra_lag
            extra1 += h / (half + h) * (aim - extra1)
            extra2 += h / (half + h) * (extra1 - extra2)
            aim = extra2
    fast += h / (0.04 * p.lag_pump + h) * (aim - fast)
    lag = 0.96 * p.lag_pump
    if p.lag_ratio > 0.0:
        up = fast > d
        if up == (p.f_pump_asymmetric_lag == 1.0):
            lag *= 1.0 + p.lag_ratio
    rate = (fast - d) / (lag + h)
    if p.rate_limit > 0.0:
        limit = p.rate_limit
        if p.f_pump_rate_limit == 2.0:
            limit *= 1.2 if rate > 0.0 else 0.8
        if p.f_pump_rate_limit == 1.0:
            x = abs(rate) / limit
            rate = rate / (1.0 + x ** 4) ** 0.25
        elif abs(rate) > limit:
            rate = copysign(limit, rate)
    return fast, d + h * rate, extra1, extra2


@jit
def run(numbers, tabs_d, tabs_lp, tabs_lm, tabs_em, tabs_el, tabs_pv, setpoint, manual, closed,
        pprv, temperature, visc, rough, tick_noise, quantum):
    """
    Integrate one log and return one row of OUT per millisecond.

    Parameters (SI): setpoint, manual, pprv, temperature (degC), visc (viscosity at 50 degC over
    viscosity now), rough (N m) per millisecond; tick_noise per 10 ms; quantum of the command.
    """
    p = numbers[0]
    n = pprv.shape[0]
    out = np.zeros((n, 17))
    h = STEP
    u_hist = np.zeros(n)
    p1 = p2 = 3e5
    q = slow = w = wl = theta = twist = 0.0
    fast = d = extra1 = extra2 = s = z = u_last = 0.0
    pp_fast = pp = tabs_pv[0]
    held = 0.0
    creep = back = 0.0
    wp = p.w_pump
    wf1 = wf2 = 0.0
    integral = 0.0
    u = 0.0
    c_rest = 0.5 * p.volume
    dead = int(round(p.dead_time * 1000.0))
    split = 1.0 - p.shaft_share if p.stiffness > 0.0 else 1.0
    torque = t_load = t_motor = q_lm = q_net = q_prv = 0.0
    for k in range(n):
        if k % MS_PER_TICK == 0:
            if closed:
                seen = wf2 if p.speed_lag > 0.0 else w
                seen += tick_noise[k // MS_PER_TICK]
                seen = round(seen / p.speed_resolution) * p.speed_resolution
                error = setpoint[k] - seen
                u = p.kp * error + integral
                u = max(p.u_low, min(p.u_high, u))
                if p.u_low < u < p.u_high or (u <= p.u_low and error > 0.0) or (
                        u >= p.u_high and error < 0.0):
                    integral += p.ki * error * 0.01
                u = round(u / quantum) * quantum
            else:
                u = manual[k]
        u_hist[k] = u
        out[k, 0], out[k, 1], out[k, 2] = u, p1, p2
        q_lm = motor_leak(p, tabs_lm, p2, w, theta, visc[k])
        out[k, 3], out[k, 4], out[k, 5] = p.d_motor * w + q_lm, w, torque
        out[k, 6], out[k, 7], out[k, 8] = d, wp, q_lm
        out[k, 9], out[k, 10], out[k, 11], out[k, 12] = q_net, q_prv, t_motor, theta
        out[k, 13], out[k, 14], out[k, 15] = wf2 if p.speed_lag > 0.0 else w, wl, t_load
        out[k, 16] = back
        # commands seen by the actuators, once per millisecond
        now = u_hist[max(k - dead, 0)] if k >= dead else 0.0
        shift = p.u_offset
        if p.f_pump_command_offset == 1.0:
            shift = p.u_offset * (1.0 - 0.04 * (now - 5.0))
        s, z = hysteresis(p, now, s, z, u_last)
        u_last = now
        target = curve(tabs_d, s - shift, U_STEP)
        if p.pprv_stick > 0.0:
            if p.f_pprv_stiction == 0.0:
                held = pprv[k] if abs(pprv[k] - held) > p.pprv_stick else held
            else:
                half = 0.5 * p.pprv_stick
                held = max(pprv[k] - half, min(pprv[k] + half, held))
        else:
            held = pprv[k]
        aim = curve(tabs_pv, held, U_STEP)
        if p.creep > 0.0:
            creep += 1e-3 / p.creep_time * (p.creep * (aim - 30e5) - creep)
            aim += creep
        for _ in range(PER_MS):
            fast, d, extra1, extra2 = stage_pump(p, target, fast, d, extra1, extra2, h)
            pp_fast += h / (0.03 * p.lag_pprv + h) * (aim - pp_fast)
            pp += h / (0.97 * p.lag_pprv + h) * (pp_fast - pp)
            if p.droop > 0.0:
                drag = max(p1, 0.0) * d
                if p.f_pump_speed_droop == 1.0:
                    drag = drag * (0.7 + 0.3 * drag / 18.0)
                wp += h / 0.08 * (p.w_pump * (1.0 - p.droop * drag) - wp)
            # hose: implicit in its resistance; the slow flow makes friction unsteady
            ohm = hose_drop(p, q)
            extra = 4e8
            q = (q + h / p.hose_inertance * (p1 - p2 + extra * slow)) / (
                1.0 + h / p.hose_inertance * (ohm + extra))
            slow += h / 0.01 * (q - slow)
            # volumes
            lost = pump_leak(p, tabs_lp, p1, u, visc[k]) + pump_compression(p, p1, d, wp)
            q_net = d * wp - lost
            q_prv, slope = relief(p, p1)
            stiff = volume_modulus(p, p1) / c_rest
            p1 = max(p1 + h * stiff * (q_net - q - q_prv) / (1.0 + h * stiff * slope), -0.9e5)
            q_lm = motor_leak(p, tabs_lm, p2, w, theta, visc[k])
            p2 = max(p2 + h * volume_modulus(p, p2) / c_rest * (q - p.d_motor * w - q_lm), -0.9e5)
            # torques
            eta = surface(tabs_em, min(max(p2, 0.0), P_TOP), min(abs(w), W_TOP), W_STEP)
            t_motor = eta * p2 * p.d_motor * (1.0 + ripple(p, theta))
            if p.p_back > 0.0:
                back = p.p_back * (1.0 if p.f_back_pressure == 0.0 else 0.7 + 0.3 * abs(w) / 10.5)
                t_motor -= back * p.d_motor * min(abs(w) / 0.3, 1.0)
            w_load = wl if p.stiffness > 0.0 else w
            pl = max(pp + p.override * (p.gear * p.d_load * w_load - p.q_ref), 0.0)
            raw = pl * p.d_load * p.gear / curve(tabs_el, pl, P_STEP)
            raw = load_factor(p, theta, raw) + rough[k]
            drag = friction(p, w, abs(t_motor), temperature[k])
            sgn, sgn_slope = sign_slope(w)
            sgf, sgf_slope = friction_sign(p, w)
            if p.stiffness > 0.0:
                sgl, sgl_slope = sign_slope(wl)
                t_load = raw * sgl
                bend = twist
                if p.f_shaft_compliance == 1.0:
                    bend = twist * (0.6 + 1.6 * twist * twist)
                torque = p.stiffness * bend + p.shaft_damping * (w - wl)
                j1, j2 = split * p.inertia, (1.0 - split) * p.inertia
                w += h * (t_motor - drag * sgf - torque) / (
                    j1 + h * (drag * sgf_slope + p.shaft_damping))
                wl += h * (torque - t_load) / (j2 + h * (abs(raw) * sgl_slope + p.shaft_damping))
                twist += h * (w - wl)
            else:
                t_load = raw * sgn
                torque = t_load
                w += h * (t_motor - drag * sgf - t_load) / (
                    p.inertia + h * (drag * sgf_slope + abs(raw) * sgn_slope))
            theta += h * w
            if p.speed_lag > 0.0:
                lag = p.speed_lag if p.f_speed_sensor_lag == 0.0 else 0.5 * p.speed_lag
                wf1 += h / (lag + h) * (w - wf1)
                if p.f_speed_sensor_lag == 0.0:
                    wf2 = wf1
                else:
                    wf2 += h / (lag + h) * (wf1 - wf2)
        if theta > 200 * pi:
            theta -= 200 * pi
    return out
