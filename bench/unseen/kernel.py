# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The drive as differential equations, in SI units (gauge pressures)."""
from math import exp, sin, sqrt, tanh

import numpy as np

try:
    from numba import njit
except ImportError:
    njit = None

ATMOSPHERE = 1.01325e5
CAVITATION = -0.9e5
# Where a friction or load torque changes its sign (datasheet), rad/s.
SIGN_WIDTH = 0.15

# The states. The first holds the command behind the pilot valve, of which no datasheet tells.
(PILOT, SLOW, STROKE, PRIME, PRESSURE, FAR, LINE, SPEED, LOAD_SPEED, TWIST, ANGLE, PUMP_ANGLE,
 LOADING, GAS, CREEP, READ_1, READ_2, HEAT) = range(18)
STATES = 18

# What a sensor would see without noise.
(SEEN_PRESSURE, SEEN_FLOW, SEEN_SPEED, SEEN_TORQUE) = range(4)


def compiled(function):
    """Return the function compiled, or as it is without numba: the same numbers, slowly."""
    return function if njit is None else njit(cache=True, error_model='numpy')(function)


def packed(m):
    """Return a machine's numbers as one record, which compiled functions pass on by address."""
    if njit is None:
        return m
    kind = [(name, float, np.shape(value)) for name, value in zip(m._fields, m)]
    record = np.zeros(1, dtype=kind)
    for name, value in zip(m._fields, m):
        record[name][0] = value
    return record[0]


@compiled
def along(x, grid, values):
    """Interpolate linearly; hold the end values outside."""
    if x <= grid[0]:
        return values[0]
    last = len(grid) - 1
    if x >= grid[last]:
        return values[last]
    i = 1
    while grid[i] < x:
        i += 1
    share = (x - grid[i - 1]) / (grid[i] - grid[i - 1])
    return values[i - 1] + (values[i] - values[i - 1]) * share


@compiled
def across(x, y, rows, columns, table):
    """Interpolate a table linearly in both directions; hold the end values outside."""
    i = 1
    while i < len(rows) - 1 and rows[i] < x:
        i += 1
    j = 1
    while j < len(columns) - 1 and columns[j] < y:
        j += 1
    a = min(max((x - rows[i - 1]) / (rows[i] - rows[i - 1]), 0.0), 1.0)
    b = min(max((y - columns[j - 1]) / (columns[j] - columns[j - 1]), 0.0), 1.0)
    near = table[i - 1, j - 1] * (1 - b) + table[i - 1, j] * b
    far = table[i, j - 1] * (1 - b) + table[i, j] * b
    return near * (1 - a) + far * a


@compiled
def root(x, width):
    """Return the signed square root, linear within a width (laminar flow through a small gap)."""
    return x / sqrt(sqrt(x * x + width * width))


@compiled
def pump_flow(y, dy, visc, m):
    """Return what the pump gives to the line, and set the rates of its plate and shaft."""
    pressure = y[PRESSURE]
    command = y[PILOT]
    if m.extra_lag > 0:
        dy[SLOW] = (y[PILOT] - y[SLOW]) / m.extra_lag
        command = y[SLOW]
    target = along(command, m.stroke_grid, m.stroke_values)
    above = max(pressure - m.yield_from, 0.0)
    target *= max(1 - m.yield_share * above, 0.0)
    target -= m.yield_stroke * above
    target += m.spot_height * exp(-((command - m.spot_at) / m.spot_width) ** 2)
    target = min(max(target, 0.0), m.stroke_stop)
    rate = (target - y[STROKE]) / (m.stroke_lag if target > y[STROKE] else m.return_lag)
    if m.rate_smooth > 0:
        rate = m.rate_smooth * tanh(rate / m.rate_smooth)
    dy[STROKE] = min(max(rate, -m.rate_limit), m.rate_limit)
    torque = y[STROKE] * pressure / m.prime_torque
    static = m.prime_speed * (1 - m.droop * torque - m.droop_square * torque * abs(torque))
    dy[PRIME] = (static - y[PRIME]) / m.prime_lag
    dy[PUMP_ANGLE] = y[PRIME]
    flow = y[STROKE] * y[PRIME]
    unfilled = flow - m.fill_from
    if unfilled > 0:
        flow -= m.fill_share * unfilled + m.fill_square * unfilled ** 2
    flow -= m.decompression * pressure * (y[STROKE] + m.dead_stroke) * y[PRIME]
    flow *= 1 - m.dead_piston * (1 + sin(y[PUMP_ANGLE]))
    leak = across(pressure, y[PILOT], m.leak_pressures, m.leak_commands, m.pump_leaks)
    leak *= m.pump_leak_factor * visc
    return flow - leak - m.pump_gap * pressure * (1 + m.pump_gap_stroke * y[STROKE])


@compiled
def motor_leak(pressure, speed, angle, visc, m):
    """Return what passes the motor without turning it."""
    leak = across(pressure, speed, m.leak_pressures, m.leak_speeds, m.motor_leaks)
    widening = m.gap_growth * pressure
    leak *= visc * (m.motor_leak_factor + m.gap_linear * widening
                    + m.gap_cube * ((1 + widening) ** 3 - 1) + m.gap_exp * (exp(widening) - 1))
    leak += m.motor_gap * pressure * (1 + m.motor_gap_speed * speed)
    leak += m.motor_orifice * root(pressure, m.orifice_width)
    if m.lobe_gap > 0:
        leak += m.lobe_gap * pressure * max(sin(angle), 0.0) ** 4
    return leak


@compiled
def stiffness(pressure, m):
    """Return the bulk modulus of the oil with what air is in it."""
    oil = m.bulk_modulus * (1 + m.bulk_growth * pressure)
    if m.air <= 0:
        return oil
    p = max(pressure + ATMOSPHERE, 0.5 * ATMOSPHERE)
    free = m.air * max(1 - p / m.air_dissolved, 0.0) if m.air_dissolved > 0 else m.air
    return 1 / (1 / oil + free * (ATMOSPHERE / p) ** (1 / m.air_exponent) / (m.air_exponent * p))


@compiled
def drag(y, pressure, push, m):
    """Return the friction of the motor and what else brakes its shaft."""
    speed = abs(y[SPEED])
    slow = speed / m.stribeck_speed
    coulomb = m.coulomb * (1 - m.coulomb_fades * y[HEAT]) + m.coulomb_load * abs(push)
    coulomb += m.heat_torque * y[HEAT]
    coulomb += m.stribeck_gauss * exp(-slow * slow) + m.stribeck_exp * exp(-slow)
    coulomb += m.stribeck_hill / (1 + slow * slow)
    coulomb += m.band_torque * exp(-((speed - m.band_at) / m.band_width) ** 2)
    coulomb += m.viscous * speed / (1 + speed * m.viscous_bend)
    coulomb += m.churning * speed ** m.churning_power
    coulomb += m.bent_torque * (1 + sin(m.bent_order * y[ANGLE]))
    torque = coulomb * tanh(y[SPEED] / SIGN_WIDTH)
    return torque + (m.return_pressure + m.return_square * y[SPEED] ** 2) * m.displacement


@compiled
def load_torque(y, speed, factor, m):
    """Return the torque of the loading pump at the slow side of the gear."""
    flow = m.gear * m.load_displacement * speed
    pressure = y[LOADING] + m.override * (flow - m.override_flow) + m.clogged * flow * abs(flow)
    pressure *= 1 - m.starved * min(max(abs(speed) / m.starved_from - 1, 0.0), 1.0)
    pressure = max(pressure * factor, 0.0)
    efficiency = along(pressure, m.load_pressures, m.load_efficiencies)
    torque = pressure * m.load_displacement * m.gear / efficiency
    torque *= 1 + m.gear_share + m.gear_share_speed * abs(speed)
    torque = min(torque + m.gear_torque, m.slip_torque)
    return torque * tanh(speed / SIGN_WIDTH) + m.hanging


@compiled
def rates(y, dy, seen, loading, rock, event, visc, m):
    """Set the rates of all states and what the sensors would see."""
    pressure, speed = y[PRESSURE], y[SPEED]
    given = pump_flow(y, dy, visc, m) - (m.burst + m.hole * root(pressure, 1e5)) * event
    over = pressure - m.relief_set
    if over > 0:
        given -= m.relief_gain * root(over, 1e5)
    cracked = pressure - m.crack_from
    if cracked > 0:
        given -= m.crack_slope * cracked + m.crack_square * cracked ** 2
    taken = m.displacement * speed
    if m.inertance > 0:
        far = y[FAR]
        taken += motor_leak(far, speed, y[ANGLE], visc, m)
        # Unsteady friction brakes what differs from the mean flow, and so the waves alone.
        waves = m.line_wave * (y[LINE] - taken)
        dy[LINE] = (pressure - far - m.line_laminar * y[LINE] - waves) / m.inertance
        dy[FAR] = (y[LINE] - taken) * stiffness(far, m) / (m.far_share * m.volume)
        if far <= CAVITATION and dy[FAR] < 0:
            dy[FAR] = 0.0
        given -= y[LINE]
        near = (1 - m.far_share) * m.volume / stiffness(pressure, m)
    else:
        q = taken + motor_leak(pressure, speed, y[ANGLE], visc, m)
        far = pressure - m.line_laminar * q - m.line_turbulent * q * abs(q)
        if m.line_blasius > 0:
            far -= m.line_blasius * q * abs(q) ** 0.75
        taken += motor_leak(far, speed, y[ANGLE], visc, m)
        given -= taken
        near = m.volume / stiffness(pressure, m)
    if m.gas_volume > 0:
        p = pressure + ATMOSPHERE
        if m.gas_neck > 0:
            left = max(1 - y[GAS] / m.gas_volume, 0.02)
            push = p - m.gas_pressure * left ** -m.gas_exponent
            dy[GAS] = push / m.gas_neck
            if y[GAS] <= 0 and push < 0:
                dy[GAS] = 0.0
            given -= dy[GAS]
        elif p > m.gas_pressure:
            left = (m.gas_pressure / p) ** (1 / m.gas_exponent)
            near += m.gas_volume / m.gas_exponent / p * left
    if m.creep > 0:
        dy[CREEP] = (m.creep * pressure - y[CREEP]) / m.creep_time
        given -= dy[CREEP]
    dy[PRESSURE] = given / near
    if pressure <= CAVITATION and dy[PRESSURE] < 0:
        dy[PRESSURE] = 0.0

    push = far * m.displacement
    torque = push * across(far, speed, m.eta_pressures, m.eta_speeds, m.etas)
    if m.ripple > 0:
        wave = sin(m.pistons * y[ANGLE])
        torque *= 1 + m.ripple * (wave if m.ripple_rectified < 0.5 else 1.57 * abs(wave) - 1)
    torque -= drag(y, far, push, m) + m.jolt * event * tanh(speed / SIGN_WIDTH)
    dy[HEAT] = (abs(speed) / m.heat_speed - y[HEAT]) / m.heat_time
    dy[ANGLE] = speed
    dy[LOADING] = (loading - y[LOADING]) / (m.loading_lag if loading < y[LOADING] else m.rise_lag)
    if m.shaft_stiffness > 0:
        shaft = m.shaft_stiffness * y[TWIST] * (1 + m.shaft_hardening * y[TWIST] ** 2)
        shaft += m.shaft_damping * (speed - y[LOAD_SPEED])
        dy[TWIST] = speed - y[LOAD_SPEED]
        dy[SPEED] = (torque - shaft) / (m.motor_share * m.inertia)
        braking = load_torque(y, y[LOAD_SPEED], rock, m)
        dy[LOAD_SPEED] = (shaft - braking) / ((1 - m.motor_share) * m.inertia)
        seen[SEEN_TORQUE] = shaft
    else:
        braking = load_torque(y, speed, rock, m)
        dy[SPEED] = (torque - braking) / m.inertia
        seen[SEEN_TORQUE] = braking
    seen[SEEN_PRESSURE], seen[SEEN_FLOW] = pressure, taken
    reading = speed * m.speed_scale * (1 + m.eccentric * sin(y[ANGLE]))
    if m.speed_lag > 0:
        dy[READ_1] = (reading - y[READ_1]) / m.speed_lag
        reading = y[READ_1]
        if m.speed_lag_2 > 0:
            dy[READ_2] = (reading - y[READ_2]) / m.speed_lag_2
            reading = y[READ_2]
    seen[SEEN_SPEED] = reading
