# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What both circuits' integrators share: shaft, speed sensor, controller, steps of the solver."""

from __future__ import annotations

from math import copysign, exp, tanh

from .pieces import contact, drag, shaft_torque, sign
from ..terms import jit

STEP = 0.2e-3
PER_MS = 5
MS_PER_TICK = 10
# the states that both circuits have come first
PA, PB, W, WL, TWIST, ANGLE, WF1, WF2, PILOT, STROKE, EXTRA1, EXTRA2 = range(12)


@jit
def shaft(p, y, dy, dp, d_motor, rock, push, temperature):
    """Write the derivatives of shaft and speed sensor; return torques: drive, lost, load."""
    w, wl = y[W], y[WL]
    drive = shaft_torque(p, dp, w, d_motor)
    lost = drag(p, w, drive, y[ANGLE], temperature)
    turning = wl if p.play > 0.0 else w
    load = rock * sign(p, turning) + push
    if p.play > 0.0:
        through = contact(p, y[TWIST], w - wl)
        dy[W] = (drive - through) / (p.inertia * p.inertia_share)
        dy[WL] = (through - lost - load) / (p.inertia * (1.0 - p.inertia_share))
        dy[TWIST] = w - wl
    else:
        dy[W] = (drive - lost - load) / p.inertia
        dy[WL] = dy[W]
        dy[TWIST] = 0.0
    dy[ANGLE] = turning
    dy[WF1] = dy[WF2] = 0.0
    if p.speed_lag > 0.0:
        tau = p.speed_lag if p.f_speed_sensor_lag == 0.0 else 0.5 * p.speed_lag
        dy[WF1] = (turning - y[WF1]) / tau
        dy[WF2] = (y[WF1] - y[WF2]) / tau
    return drive, lost, load


@jit
def delayed(p, y, dy, target, extra, second):
    """Write the derivatives of the actuator's hidden lag and pilot; return its rate alone."""
    aim = target
    dy[EXTRA1] = dy[EXTRA2] = 0.0
    if extra > 0.0:
        tau = 0.5 * extra if second else extra
        dy[EXTRA1] = (aim - y[EXTRA1]) / tau
        dy[EXTRA2] = (y[EXTRA1] - y[EXTRA2]) / tau
        aim = y[EXTRA2] if second else y[EXTRA1]
    dy[PILOT] = (aim - y[PILOT]) / (0.04 * p.lag)
    return (y[PILOT] - y[STROKE]) / (0.96 * p.lag)


@jit
def speed_seen(p, y):
    """Return the speed that the sensor sees, without noise."""
    seen = y[WL] if p.play > 0.0 else y[W]
    if p.speed_lag > 0.0:
        seen = y[WF1] if p.f_speed_sensor_lag == 0.0 else y[WF2]
    if p.miss > 0.0:
        seen *= 1.0 - p.miss * max(abs(seen) - p.w_miss, 0.0) / (0.5 * p.w_rated)
    return seen


@jit
def controller(p, setpoint, reading, integral, share):
    """
    Return the command of the speed controller, which jumps the dead band, and its integral.

    `share` is the motors' displacement over the full one.
    """
    error = setpoint - reading
    v = share * (p.ff * setpoint + p.kp * error) + integral
    if abs(v) < 10.0 - p.u_zero:
        integral += share * p.ki * error * 0.01
    if setpoint == 0.0 and abs(reading) < 0.02 * p.w_rated:
        integral *= 0.9
    u = v + 0.95 * p.u_zero * tanh(v / 0.1)
    return max(-10.0, min(10.0, u)), integral


@jit
def play(half, form, u, seen, z, last):
    """Return the command behind a backlash or a Bouc-Wen hysteresis, and the inner state."""
    if half <= 0.0:
        return u, z
    if form == 0.0:
        return max(u - half, min(u + half, seen)), z
    du = u - last
    x = abs(z) / half
    z += du * (1.0 - x * x if du * z > 0.0 else 1.0)
    z = max(-half, min(half, z))
    return u - z, z


@jit
def stuck_thread(torque, turned):
    """Return what is left of a break-out torque after an angle of turning (rad)."""
    return torque * exp(-(turned / 0.35) ** 2)


@jit
def towards(out, y, rate, h):
    """Write y + h rate to `out`."""
    for i in range(y.size):
        out[i] = y[i] + h * rate[i]


@jit
def advance(y, rates, h):
    """Move the states by one Runge-Kutta step."""
    for i in range(y.size):
        y[i] += h / 6.0 * (rates[0, i] + 2.0 * (rates[1, i] + rates[2, i]) + rates[3, i])


@jit
def limited(rate, limit, form):
    """Return a rate within a limit: hard, soft, asymmetric."""
    if limit <= 0.0:
        return rate
    if form == 1.0:
        return rate / (1.0 + (rate / limit) ** 4) ** 0.25
    if form == 2.0:
        limit *= 1.2 if rate > 0.0 else 0.8
    return copysign(min(abs(rate), limit), rate)
