# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Compiled terms of the truth's balances; `p` is the record of numbers (SI), see kernel.py."""

from __future__ import annotations

from math import atan, cos, exp, pi, sin, sqrt, tanh

import numba
import numpy as np

from .unit import P_STEP, P_TOP, U_STEP, U_TOP, W_STEP, W_TOP

jit = numba.njit(cache=True, error_model='numpy')


@jit
def curve(table, x, step):
    """Return a value from an even grid that starts at 0, end values held."""
    r = min(max(x / step, 0.0), table.shape[0] - 1.000001)
    i = int(r)
    return table[i] + (r - i) * (table[i + 1] - table[i])


@jit
def surface(table, x, y, y_step):
    """Return a value from an even pressure grid times a second one, end values held."""
    r = min(max(x / P_STEP, 0.0), table.shape[0] - 1.000001)
    s = min(max(y / y_step, 0.0), table.shape[1] - 1.000001)
    i, j = int(r), int(s)
    a, b = r - i, s - j
    return ((1 - a) * ((1 - b) * table[i, j] + b * table[i, j + 1])
            + a * ((1 - b) * table[i + 1, j] + b * table[i + 1, j + 1]))


@jit
def root(x, soft):
    """Return a square root that is smooth and odd through zero."""
    return x / sqrt(sqrt(x * x + soft * soft))


@jit
def volume_modulus(p, pressure):
    """Return the effective bulk modulus of oil with free air at a gauge pressure."""
    bulk = p.bulk * (1.0 + 2e-10 * (pressure - 60e5))
    if p.air_frac <= 0.0:
        return bulk
    atm = 101325.0
    absolute = max(pressure + atm, 0.05e5)
    n = 1.0 if p.f_entrained_air == 1.0 else 1.4
    alpha = p.air_frac
    if p.f_entrained_air == 2.0:    # Henry: air goes into solution with pressure
        alpha *= exp(-max(pressure, 0.0) / 60e5)
    ratio = (atm / absolute) ** (1.0 / n)
    gas = alpha * ratio / (n * absolute)
    return (1.0 - alpha + alpha * ratio) / ((1.0 - alpha) / bulk + gas)


@jit
def pump_leak(p, lp, pressure, u, visc):
    """Return all flow that the pump loses (m^3/s) at a gauge pressure."""
    high = max(pressure, 0.0)
    q = surface(lp, min(high, P_TOP), min(max(u, 0.0), U_TOP), U_STEP) * visc
    if p.g_pump > 0.0:
        if p.f_pump_leakage == 0.0:
            q += p.g_pump * pressure * visc
        elif p.f_pump_leakage == 1.0:
            q += p.g_pump * root(pressure, 0.3e5) * sqrt(70e5)
        else:
            q += p.g_pump * pressure * (0.75 + 0.25 * pressure / 70e5) * visc
    if p.g_command > 0.0:
        x = max(u - 3.0, 0.0) / 3.0
        q += p.g_command * pressure * (x if p.f_command_leakage == 0.0 else x * x)
    return q


@jit
def pump_compression(p, pressure, dp, wp):
    """Return the flow lost by decompression of the pump's displaced volume (m^3/s)."""
    swept = dp if p.f_compressibility_flow == 0.0 else 0.3 * p.d_pump_max + 0.4 * dp
    return p.c_comp * pressure * swept * wp


@jit
def motor_leak(p, lm, pressure, w, theta, visc):
    """Return all flow that leaks through the motor (m^3/s) at its inlet pressure."""
    high = max(pressure, 0.0)
    q = surface(lm, min(high, P_TOP), min(abs(w), W_TOP), W_STEP) * visc
    if p.k_elastic > 0.0:
        if p.f_elastic_leakage == 0.0:
            q *= (1.0 + p.k_elastic * high) ** 3
        else:
            q *= 1.0 + 4.1 * p.k_elastic * high * (high / 80e5)
    if p.g_motor > 0.0:
        if p.f_motor_leakage == 0.0:
            q += p.g_motor * pressure * visc
        elif p.f_motor_leakage == 1.0:
            q += p.g_motor * pressure * (0.9 + 0.1 * abs(w) / 10.5) * visc
        else:
            q += p.g_motor * pressure * (0.8 + 0.2 * pressure / 70e5) * visc
    if p.g_angle > 0.0:
        turns = 1.0 if p.f_angle_leakage == 0.0 else 2.0
        q += p.g_angle * pressure * max(sin(turns * theta), 0.0)
    return q


@jit
def relief(p, pressure):
    """Return the relief valve's flow and its slope over pressure."""
    q, slope = 0.0, 0.0
    x = pressure - p.p_set
    if x > 0.0:
        q = p.cd_area * sqrt(2.0 / p.rho) * root(x, 0.05e5)
        slope = q / x
    y = pressure - p.p_crack
    if p.g_crack > 0.0 and y > 0.0:
        if p.f_prv_cracking == 0.0:
            q += p.g_crack * y
            slope += p.g_crack
        else:
            q += p.g_crack * y * y / 30e5
            slope += 2.0 * p.g_crack * y / 30e5
    return q, slope


@jit
def hose_drop(p, q):
    """Return the hose's pressure loss and its secant resistance at a flow."""
    r = 6e6 + p.r_lam
    if p.f_line_loss == 0.0:
        r += p.r_turb * abs(q)
    elif p.r_lam > 0.0:    # Blasius: all turbulent, the same loss at 20 L/min
        at = 20e-3 / 60
        r = 6e6 + (p.r_lam + p.r_turb * at) * (abs(q) / at) ** 0.75
    return r


@jit
def friction(p, w, w_torque, temperature):
    """Return friction magnitude at the motor shaft, before the sign of rotation (N m)."""
    a = abs(w)
    f = 0.0
    if p.t_coul > 0.0:
        if p.f_bearing_friction == 1.0:
            f += p.t_coul * (0.8 + 0.2 * w_torque / 150.0)
        else:
            f += p.t_coul
    if p.t_strib > 0.0:
        x = a / p.w_strib
        if p.f_stribeck_friction == 0.0:
            f += p.t_strib * exp(-x)
        elif p.f_stribeck_friction == 1.0:
            f += p.t_strib * exp(-x * x)
        else:
            f += p.t_strib / (1.0 + x * x)
    if p.b_visc > 0.0:
        f += p.b_visc * (a if p.f_viscous_drag == 0.0 else 10.0 * (a / 10.0) ** 0.85)
    if p.b_hydro > 0.0:
        f += p.b_hydro * (a * a if p.f_hydrodynamic_drag == 0.0 else 1.2 * max(a - 1.0, 0.0) ** 2)
    if p.t_band > 0.0:
        x = (a - p.w_band) / p.w_width
        f += p.t_band * exp(-x * x)
    if p.t_warm > 0.0:
        x = (temperature - 50.0) / 20.0
        f += p.t_warm * (exp(-1.2 * x) if p.f_temperature_friction == 0.0
                         else max(1.0 - 0.9 * x, 0.0))
    return f


@jit
def sign_slope(w):
    """Return the smooth sign of the load and its slope."""
    s = tanh(w / 0.15)
    return s, (1.0 - s * s) / 0.15


@jit
def friction_sign(p, w):
    """Return the smooth sign of friction and its slope."""
    if p.f_bearing_friction == 2.0 and p.t_coul > 0.0:
        x = pi / 2 * w / 0.15
        return 2.0 / pi * atan(x), 1.0 / 0.15 / (1.0 + x * x)
    return sign_slope(w)


@jit
def ripple(p, theta):
    """Return the relative ripple of the motor torque over its angle."""
    base = 2e-4 * sin(7.0 * theta + 0.4)
    if p.ripple <= 0.0:
        return base
    n = p.pistons
    if p.f_piston_ripple == 0.0:
        return base + p.ripple * sin(n * theta)
    return base + p.ripple * 2.2 * (abs(cos(0.5 * n * theta)) - 2.0 / pi)


@jit
def load_factor(p, theta, torque):
    """Return the load torque with the gear's and the bit's share (N m)."""
    t = torque
    if p.gear_loss > 0.0:
        t += p.gear_loss * (torque if p.f_gearbox_loss == 0.0 else 0.8 * torque + 30.0)
    if p.eccentric > 0.0:
        t += p.eccentric * (torque if p.f_bit_eccentricity == 0.0 else 120.0) * cos(theta)
    return t


def record(values: dict) -> np.ndarray:
    """Return the one-row structured array that compiled code reads as `p`."""
    row = np.zeros(1, dtype=[(name, 'f8') for name in sorted(values)])
    for name, value in values.items():
        row[name] = value
    return row
