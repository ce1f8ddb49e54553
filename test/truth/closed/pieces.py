# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Compiled terms that both circuits share; `p` is the record of numbers (SI).

After a change here or in common.py remove __pycache__: numba looks at the caller's file alone.
"""

from __future__ import annotations

from math import atan, copysign, cos, exp, log1p, pi, sqrt, tanh

from ..terms import jit, root

ATM = 101325.0


@jit
def above(x, soft):
    """Return x where it is positive and 0 below, with a corner rounded over `soft`."""
    return 0.5 * (x + sqrt(x * x + soft * soft))


@jit
def stroke(u, zero, corner):
    """Return -1 to 1 for a command of -10 to 10 V, with a dead band of rounded corners."""
    x = (abs(u) - zero) / corner
    over = corner * (x if x > 40.0 else log1p(exp(x)))
    return copysign(min(over / (10.0 - zero), 1.0), u)


@jit
def modulus(p, pressure):
    """Return the bulk modulus of oil with its air at a gauge pressure."""
    bulk = p.bulk * (1.0 + p.bulk_slope * (pressure - 100e5) / p.bulk)
    air = p.air0 + p.air
    absolute = max(pressure + ATM, 0.03e5)
    n = 1.0 if p.f_entrained_air == 1.0 else 1.4
    if p.f_entrained_air == 2.0:
        air *= exp(-max(pressure, 0.0) / 80e5)
    gas = air * (ATM / absolute) ** (1.0 / n)
    return (1.0 + gas) / (1.0 / bulk + gas / (n * absolute))


@jit
def gas_capacity(p, pressure):
    """Return what an accumulator adds to the capacity of a line (m^3/Pa)."""
    if p.gas <= 0.0:
        return 0.0
    n = 1.0 if p.f_accumulator == 0.0 else 1.25
    open_share = 0.5 * (1.0 + tanh((pressure - p.precharge) / 1e5))
    return p.gas * open_share * (2.0 * p.precharge / max(pressure, 1e5)) ** (1.0 + 1.0 / n)


@jit
def gaps(p, dp, w, fluid):
    """Return one motor's leakage at a pressure difference (odd in it): sheet's and more."""
    q = p.m_lam * dp * fluid + p.m_turb * root(dp, 0.5e5)
    size = abs(dp)
    if p.k_elastic > 0.0:
        if p.f_elastic_leakage == 0.0:
            q *= (1.0 + p.k_elastic * size) ** 3
        else:
            q *= 1.0 + 4.4 * p.k_elastic * size * size / 200e5
    if p.g_motor > 0.0:
        g = p.g_motor / p.count * dp
        if p.f_motor_leakage == 0.0:
            q += g * fluid
        elif p.f_motor_leakage == 1.0:
            q += g * (0.7 * fluid + 0.3 * size / 150e5)
        else:
            q += g * fluid * (0.85 + 0.15 * abs(w) / p.w_rated)
    if p.g_orifice > 0.0:
        g = p.g_orifice / p.count
        if p.f_motor_orifice_leakage == 0.0:
            q += g * root(dp, 0.5e5) * sqrt(150e5)
        else:
            q += g * copysign(150e5 * (size / 150e5) ** 0.6, dp)
    return q


@jit
def motor_flows(p, pa, pb, w, fluid, d_motor):
    """
    Return what the motors take from line A, give to line B, and drain to the case.

    The leakage of the sheet is split: `case_share` leaves each line for the case, the rest
    goes from line to line.
    """
    swept = p.per_turn * d_motor * w
    across = p.count * (1.0 - p.case_share) * gaps(p, pa - pb, w, fluid)
    case_a = p.count * p.case_share * gaps(p, pa, w, fluid)
    case_b = p.count * p.case_share * gaps(p, pb, w, fluid)
    return swept + across + case_a, swept + across - case_b, case_a + case_b


@jit
def cross_leak(p, dp, fluid):
    """Return the hidden flow from line A to line B."""
    if p.g_cross <= 0.0:
        return 0.0
    if p.f_cross_port_leakage == 0.0:
        return p.g_cross * root(dp, 0.5e5) * sqrt(150e5)
    return p.g_cross * dp * fluid


@jit
def line_drop(p, q):
    """Return the pressure lost in one line at a flow (odd in it)."""
    if p.r_lam <= 0.0:
        return 0.0
    if p.f_line_loss == 0.0:
        return p.r_lam * q + p.r_turb * q * abs(q)
    full = p.q_rated
    return copysign((p.r_lam * full + p.r_turb * full * full) * (abs(q) / full) ** 1.75, q)


@jit
def sign(p, w):
    """Return a smooth sign of rotation of the measured shaft."""
    return tanh(w / p.w_sign)


@jit
def shaft_torque(p, dp, w, d_motor):
    """Return the torque of the motors behind the gear, after their and the gear's losses."""
    turn = sign(p, w)
    w_motor = w * p.ratio
    ideal = d_motor * dp
    one = ideal - turn * (p.m_coul + p.m_share * abs(ideal)) - p.m_visc * w_motor
    loss = 1.0 - p.gear_eta
    if p.gear_loss > 0.0:
        more = 1.0 if p.f_gearbox_loss == 0.0 else 0.7 + 0.4 * abs(w) / p.w_rated
        loss += p.gear_loss * more
    out = p.per_turn * one
    return out - loss * abs(out) * turn


@jit
def drag(p, w, torque, theta, temperature):
    """Return the hidden torque that the measured shaft loses (N m, against rotation)."""
    a = abs(w)
    turn = sign(p, w)
    t = 0.0
    if p.t_coul > 0.0:
        if p.f_bearing_friction == 0.0:
            t += p.t_coul * turn
        elif p.f_bearing_friction == 1.0:
            t += p.t_coul * turn * (0.7 + 0.5 * abs(torque) / p.t_rated)
        else:
            t += p.t_coul * 2.0 / pi * atan(2.0 * w / p.w_sign)
    if p.t_strib > 0.0:
        x = a / p.w_strib
        if p.f_stribeck_friction == 0.0:
            t += p.t_strib * turn * exp(-x)
        elif p.f_stribeck_friction == 1.0:
            t += p.t_strib * turn * exp(-x * x)
        else:
            t += p.t_strib * turn / (1.0 + x * x)
    if p.b_visc > 0.0:
        x = a / p.w_rated
        t += p.b_visc * w if p.f_viscous_drag == 0.0 else turn * p.b_visc * p.w_rated * x ** 0.85
    if p.b_hydro > 0.0:
        x = a if p.f_hydrodynamic_drag == 0.0 else 1.1 * max(a - 0.1 * p.w_rated, 0.0)
        t += p.b_hydro * x * x * turn
    if p.f_constant_torque == 1.0:
        t += p.t_const
    if p.t_angle > 0.0:
        t += p.t_angle * cos(theta if p.f_bent_shaft == 0.0 else 2.0 * theta)
    if p.t_oneway > 0.0:
        way = -turn if p.f_one_way_drag == 0.0 else turn
        t += p.t_oneway * turn * max(way, 0.0)
    if p.t_warm > 0.0:
        x = (temperature - 50.0) / 20.0
        t += p.t_warm * turn * (exp(-1.2 * x) - 1.0 if p.f_temperature_friction == 0.0 else -x)
    return t


@jit
def contact(p, twist, rate):
    """Return the torque through the gear's play (N m)."""
    half = 0.5 * p.play
    depth = abs(twist) - half
    stiff = p.inertia * p.inertia_share * (1.0 - p.inertia_share) * 1000.0 ** 2
    if p.f_gear_backlash == 1.0:
        over = above(depth, 0.03 * p.play)
    else:
        over = max(depth, 0.0)
    if over <= 0.0:
        return 0.0
    damping = 0.5 * stiff / 1000.0 * min(over / (0.02 * p.play + 1e-9), 1.0)
    side = copysign(1.0, twist)
    return side * max(stiff * over + damping * rate * side, 0.0)
