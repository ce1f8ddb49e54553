# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The equations of the drive, healthy and with all its faults, for numba or plain Python.

More than the datasheet has: bulk modulus that rises with pressure (Tait), valve and coil poles,
play, stiction and creep as states, LuGre friction, hose of two volumes and an inertance, gas of an
accumulator, wall of a hose that creeps, shaft with two inertias, relief valve with a state.
"""
import math

from bench.frozen.jit import njit
from bench.frozen.lookup import along, over, ramp, root, thinner
import numpy as np

# States.
(SERVO, LATE, STROKE, SWING, SWING_RATE, PLAY, CREEP, P, P_MOTOR, Q_LINE, W, W_LOAD, TWIST, ANGLE,
 COIL, PPRV, POPPET, BRISTLE, GAS, WALL, SNAP, SHAFT, READ, READ_RATE, STATES) = range(25)
# What is written down each millisecond.
(O_U, O_V, O_STROKE, O_P, O_P_MOTOR, O_FLOW, O_DRAIN, O_W, O_TORQUE, O_SHAFT, O_ANGLE, O_P_LOAD,
 O_READ, O_IN, O_OUT, O_NET, O_BULK, OUTPUTS) = range(18)
# Columns of what comes from outside: roughness (1), oil (degC), a disturbance of the fault.
ROUGH, OIL, SHAKE = range(3)
AMBIENT = 1.013e5
#: rad/s, the datasheet's width of a smooth sign.
WIDTH = 0.15


@njit
def stiffness(p, pressure):
    """Bulk modulus [Pa]: Tait, and free air that goes into solution (Henry) up to a pressure."""
    oil = p.bulk + p.stiffening * (pressure - 0.25 * p.p_top)
    if p.air > 0.0:
        absolute = max(pressure + AMBIENT, 0.05 * AMBIENT)
        free = p.air * max(1.0 - max(pressure, 0.0) / p.air_gone, 0.0)
        gas = free * (AMBIENT / absolute) ** (1.0 / p.air_power)
        oil = (1.0 + gas) / (1.0 / oil + gas / (p.air_power * absolute))
    return oil


@njit
def actuator(y, dy, u, shake, p, c):
    """Displacement [m3/rad] and the states between it and the command."""
    u = u * (1.0 - p.sag * shake) + p.offset * (1.0 - p.offset_fade * u / 10.0)
    if u > p.amp_knee:
        u = p.amp_knee + (u - p.amp_knee) * (1.0 - p.amp_loss)
    dy[SERVO] = (u - y[SERVO]) / p.servo_lag
    target = along(c.stroke, 10.0, y[SERVO])
    if p.swash_yield != 0.0:
        target -= p.swash_yield * (max(y[P], 0.0) / 1e7) ** p.swash_power \
            * math.sqrt(target / p.stroke_max)
    if p.extra_lag > 0.0:
        dy[LATE] = (target - y[LATE]) / p.extra_lag
        target = y[LATE]
    if p.creep != 0.0:
        dy[CREEP] = (target - y[CREEP]) / p.creep_lag
        target = (1.0 - p.creep) * target + p.creep * y[CREEP]
    rate = (target - y[STROKE]) / p.stroke_lag
    if rate > 0.0:
        rate /= p.lag_up
    limit = p.rate_up if rate > 0.0 else p.rate_down
    if limit > 0.0:
        rate /= (1.0 + (abs(rate) / limit) ** p.rate_round) ** (1.0 / p.rate_round)
    dy[STROKE] = rate
    stroke = y[STROKE]
    if p.ring > 0.0:
        dy[SWING] = y[SWING_RATE]
        dy[SWING_RATE] = p.ring_w * (rate - p.ring_w * y[SWING]
                                     - 2.0 * p.ring_damping * y[SWING_RATE])
        stroke += p.ring * y[SWING]
    if p.play > 0.0:
        if p.play_power == 0.0:
            gap = max(stroke - p.play - y[PLAY], 0.0) + min(stroke + p.play - y[PLAY], 0.0)
            dy[PLAY] = gap / 0.002
            stroke = y[PLAY]
        else:
            z = y[PLAY] / p.play
            dy[PLAY] = rate * (1.0 - math.copysign(min(abs(z), 1.0) ** p.play_power, rate * z))
            stroke -= y[PLAY]
    return max(stroke, 0.0)


@njit
def leakage(y, pressure, oil, p, c):
    """Leakage of the hydromotor [m3/s]."""
    w = abs(y[W])
    above = max(pressure, 0.0)
    thin = 1.0
    if p.visc_share != 0.0:
        thin += p.visc_share * (thinner(oil) - 1.0)
    flow = over(c.motor_leak, p.p_top, p.w_top, pressure, w)
    flow *= thin * (1.0 + p.motor_elastic * above) ** 3
    if p.motor_wear != 0.0:
        flow += p.motor_wear * above / 1e7 * (1.0 + p.motor_wear_speed
                                              * (w / p.w_nominal - 1.0))
    if p.orifice + p.piston_leak != 0.0:
        area = p.orifice
        if p.piston_leak != 0.0:
            area += p.piston_leak * max(math.cos(y[ANGLE]), 0.0) ** 6
        flow += area * root(pressure, p.density)
    return flow


@njit
def relief(y, dy, t, shake, p):
    """Flow [m3/s] through the relief valve and what stands open beside it."""
    pressure = y[P]
    flow = 0.0
    if pressure > p.relief_set:
        flow += p.relief_area * math.sqrt(2.0 * (pressure - p.relief_set) / p.density)
    if p.crack_q > 0.0 and pressure > p.crack_p:
        open_ = min((pressure - p.crack_p) / (p.relief_set - p.crack_p), 1.0)
        flow += p.crack_q * open_ ** p.crack_power
    if p.flutter_q > 0.0:
        on = 1.0 / (1.0 + math.exp(-(pressure - p.flutter_p) / 1e5))
        flow += p.flutter_q * on * max(math.sin(6.283185307 * p.flutter_hz * t), 0.0)
    if p.snap_q > 0.0:
        edge = p.snap_open - (p.snap_open - p.snap_shut) * y[SNAP]
        goal = 1.0 / (1.0 + math.exp(-min(max((pressure - edge) / 5e4, -60.0), 60.0)))
        dy[SNAP] = (goal - y[SNAP]) / 0.02
        flow += p.snap_q * y[SNAP] * math.sqrt(max(pressure, 0.0) / 1e7)
    if p.dirt > 0.0:
        flow += p.dirt * shake * root(pressure, p.density)
    return flow


@njit
def load(y, dy, v, w, outside, p, c):
    """Torque [N m] of the loading unit at the shaft before the gear, and its pressure."""
    setting = along(c.pprv, 10.0, v)
    if p.coil_fade != 0.0:
        setting *= 1.0 - p.coil_fade * outside[SHAKE]
    dy[COIL] = (setting - y[COIL]) / p.coil_lag
    dy[PPRV] = (y[COIL] - y[PPRV]) / p.pprv_lag
    held = y[PPRV]
    if p.pprv_play > 0.0:
        gap = max(held - p.pprv_play - y[POPPET], 0.0) + min(held + p.pprv_play - y[POPPET], 0.0)
        dy[POPPET] = gap / 0.003
        held = y[POPPET]
    pressure = held + p.override * (p.gear * p.loading * w - p.override_flow)
    pressure *= 1.0 + outside[ROUGH]
    if p.load_starve != 0.0:
        beyond = ramp((w - p.load_starve_w) / (0.05 * p.w_nominal)) * 0.05
        pressure *= 1.0 - min(p.load_starve * beyond, 0.9)
    pressure = 1e4 * ramp(pressure / 1e4)
    torque = pressure * p.loading * p.gear / along(c.load_eta, p.p_top, pressure)
    if p.grip != 0.0:
        torque *= 1.0 + p.grip * math.exp(-abs(w) / p.grip_w)
    if p.lobes != 0.0:
        torque *= 1.0 + p.lobes * math.sin(3.0 * y[ANGLE])
    torque = torque / (1.0 - p.gear_share) + p.gear_idle
    return torque * math.tanh(w / WIDTH), pressure


@njit
def friction(y, dy, loaded, shake, p):
    """Torque [N m] that friction, drag and what rubs take."""
    w = y[W]
    size = abs(w) / p.w_nominal
    torque = 0.0
    if p.viscous != 0.0:
        torque += p.viscous * math.copysign(size ** p.viscous_power, w)
    if p.churn != 0.0:
        torque += p.churn * math.copysign(size ** p.churn_power, w)
    dry = p.coulomb + p.warm_up * shake
    if p.coulomb_load != 0.0:
        dry += p.coulomb_load * p.t_nominal * (abs(loaded) / p.t_nominal) ** p.coulomb_power
    if p.stribeck != 0.0:
        dry += p.stribeck * math.exp(-(abs(w) / p.stribeck_w) ** p.stribeck_power)
    if p.slipper != 0.0:
        dry += p.slipper * 0.03 * ramp((y[P_MOTOR] - p.slipper_p) / 3e5)
    if p.rub != 0.0:
        dry += p.rub * (0.5 + 0.5 * math.cos(y[ANGLE]))
    if dry > 0.0:
        if p.bristles > 0.0:
            # LuGre: the bristles bend by dry / (dry * bristles) at most.
            dy[BRISTLE] = w - p.bristles * abs(w) * y[BRISTLE]
            torque += dry * p.bristles * y[BRISTLE]
        else:
            torque += dry * math.tanh(w / WIDTH)
    if p.chatter != 0.0:
        near = (w - p.chatter_w) / p.chatter_width
        torque += p.chatter * shake * math.exp(-near * near) * math.tanh(w / WIDTH)
    return torque


@njit
def rates(t, y, u, v, outside, p, c, dy, out):
    """Fill the rates of change and what is written down."""
    shake, oil = outside[SHAKE], outside[OIL]
    for i in range(STATES):
        dy[i] = 0.0
    stroke = actuator(y, dy, u, shake, p, c)
    pressure = y[P]
    w = y[W]
    # Prime mover and pump.
    shaft = p.shaft_speed * (1.0 + p.hunt * shake)
    if p.droop != 0.0:
        part = max(pressure, 0.0) * stroke / (0.25 * p.p_top * p.stroke_max)
        goal = p.shaft_speed * (1.0 - p.droop * part * (1.0 + p.droop_bend * part))
        dy[SHAFT] = (goal - y[SHAFT]) / p.droop_lag
        shaft = y[SHAFT]
    pumped = stroke * shaft
    if p.starve != 0.0:
        pumped *= 1.0 - min(p.starve * 0.05 * ramp((pumped / p.starve_q - 1.0) / 0.05), 0.9)
    thin = 1.0
    if p.visc_share != 0.0:
        thin += p.visc_share * (thinner(oil) - 1.0)
    lost = over(c.pump_leak, p.p_top, 10.0, pressure, u) * thin
    if p.pump_wear != 0.0:
        lost += p.pump_wear * (max(pressure, 0.0) / 1e7) ** p.pump_wear_power
    bulk = stiffness(p, pressure)
    lost += p.decompress * max(pressure, 0.0) / bulk * stroke * shaft
    # Hydromotor.
    inlet = y[P_MOTOR] if p.line_on == 1 else pressure
    drain = leakage(y, inlet, oil, p, c)
    flow = p.motor * w + drain + p.decompress_motor * max(inlet, 0.0) / bulk * p.motor * abs(w)
    spilt = relief(y, dy, t, shake, p)
    if p.acc_volume > 0.0:
        full = p.acc_volume / max(y[GAS], 1e-3 * p.acc_volume)
        gas = (p.acc_p + AMBIENT) * full ** p.acc_power - AMBIENT
        taken = (pressure - gas) / p.acc_neck
        if y[GAS] >= p.acc_volume and taken < 0.0:
            taken = 0.0
        dy[GAS] = -taken
        spilt += taken
    if p.hose > 0.0:
        dy[WALL] = (p.hose * pressure - y[WALL]) / p.hose_lag
        spilt += dy[WALL]
    volume = p.volume
    leaving = flow
    if p.line_on == 1:
        part = abs(y[Q_LINE]) / p.q_nominal
        drop = math.copysign(p.line_laminar * part + p.line_turbulent * part ** 1.8, y[Q_LINE])
        dy[Q_LINE] = (pressure - inlet - drop) / p.line_inertance
        dy[P_MOTOR] = (y[Q_LINE] - flow) * stiffness(p, inlet) / (volume * (1 - p.line_share))
        if inlet < -0.9e5 and dy[P_MOTOR] < 0.0:
            dy[P_MOTOR] = 0.0
        volume *= p.line_share
        leaving = y[Q_LINE]
    net = pumped - lost - spilt - leaving
    dy[P] = bulk / volume * net
    if pressure < -0.9e5 and dy[P] < 0.0:
        dy[P] = 0.0
    if p.line_on == 0:
        dy[P_MOTOR] = dy[P]
    # Torques.
    behind = p.back
    if p.back_flow + p.clog != 0.0:
        part = abs(w) / p.w_nominal
        behind += p.back_flow * part ** p.back_power + p.clog * shake * part ** 1.6
    across = inlet - behind
    driving = over(c.motor_eta, p.p_top, p.w_top, across, abs(w)) * across * p.motor
    if p.ripple != 0.0:
        turn = p.ripple_pistons * y[ANGLE]
        driving *= 1.0 + p.ripple * (math.sin(turn) + p.ripple_second * math.sin(2 * turn + 0.7))
    w_load = y[W_LOAD] if p.twist > 0.0 else w
    braking, loading = load(y, dy, v, w_load, outside, p, c)
    held = friction(y, dy, braking, shake, p) + p.hang
    if p.twist > 0.0:
        behind_shaft = p.inertia * p.twist_share
        carried = y[TWIST] / p.twist
        shaft_torque = carried * (1.0 + 0.2 * (carried / p.t_nominal) ** 2)
        shaft_torque += 2.0 * p.twist_damping * math.sqrt(behind_shaft / p.twist) * (w - w_load)
        dy[TWIST] = w - w_load
        dy[W_LOAD] = (shaft_torque - braking) / behind_shaft
        dy[W] = (driving - held - shaft_torque) / (p.inertia - behind_shaft)
        seen = shaft_torque
    else:
        dy[W] = (driving - held - braking) / p.inertia
        dy[W_LOAD] = dy[W]
        seen = braking
    dy[ANGLE] = w
    # What the speed sensor says.
    read = w
    if p.tooth != 0.0 and math.sin(0.5 * y[ANGLE]) ** 2 > 1.0 - 0.25 * p.tooth_width ** 2:
        read *= 1.0 - p.tooth
    if p.speed_lag > 0.0:
        dy[READ] = y[READ_RATE]
        dy[READ_RATE] = (read - y[READ] - p.speed_lag * y[READ_RATE]) * (1.6 / p.speed_lag) ** 2
        read = y[READ]
    out[O_U], out[O_V], out[O_STROKE], out[O_P], out[O_P_MOTOR] = u, v, stroke, pressure, inlet
    out[O_FLOW], out[O_DRAIN], out[O_W], out[O_TORQUE] = flow, drain, w, seen
    out[O_SHAFT], out[O_ANGLE], out[O_P_LOAD], out[O_READ] = shaft, y[ANGLE], loading, read
    out[O_IN], out[O_OUT], out[O_NET] = pumped - lost, spilt, driving - held - braking
    out[O_BULK] = bulk


@njit
def start(p, c, v):
    """Return the state at rest: nothing turns, no pressure."""
    y = np.zeros(STATES)
    y[COIL] = y[PPRV] = y[POPPET] = along(c.pprv, 10.0, v)
    y[GAS] = p.acc_volume
    y[SHAFT] = p.shaft_speed
    return y
