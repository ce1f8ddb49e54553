# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Effects of EFFECTS.md that the open circuit can have, each with a form of its own choice.

Left out: the effects of closed and valve circuits, and gear_backlash (the pump cannot turn the
hydromotor backwards, so that its play is crossed once, at the start).

Sources: H. E. Merritt, Hydraulic Control Systems, 1967 (orifices, leakage, compliance);
J. Ivantysyn and M. Ivantysynova, Hydrostatic Pumps and Motors, 2001 (gaps, losses, filling);
C. Canudas de Wit and others, IEEE Trans. Autom. Control 40 (1995) 419 (LuGre); P. R. Dahl, 1968
(play that bends); B. Armstrong-Helouvry and others, Automatica 30 (1994) 1083 (Stribeck); ASTM
D341; H. Murrenhoff, Fundamentals of Fluid Power (free air, Henry's law); E. Blasius, 1913
(turbulent pipe).
"""
from collections.abc import Callable

from bench.frozen.kind import Kind
from bench.frozen.plant import Plant
import numpy as np

Rng = np.random.Generator
#: m/s through an orifice at 100 bar.
JET = 151.6


def _hose(base: Plant) -> float:
    """Inertance [kg/m4] of 3 m of hose that suits the rig's flow."""
    return 9e6 * 3.2e-4 / base.q_nominal


def _bristles(rng: Rng) -> float:
    """Stiffness [1/rad] of LuGre's bristles, or none."""
    return float(rng.choice([0.0, rng.uniform(60, 150)]))


def _sign(rng: Rng) -> float:
    """Return 1 or -1."""
    return float(rng.choice([-1.0, 1.0]))


def leakage_temperature(rng: Rng, base: Plant) -> Kind:
    return Kind('leakage_temperature', 'flow', 0.02, 1.3, lambda s: {'visc_share': s}, wide=True,
                needs=('oil_temperature',), note='share of all leakage goes with 1/viscosity')


def elastic_leakage(rng: Rng, base: Plant) -> Kind:
    return Kind('elastic_leakage', 'flow', 2e-10, 6e-8, lambda s: {'motor_elastic': s},
                note='gap widens with pressure, leakage with its cube')


def pump_leakage(rng: Rng, base: Plant) -> Kind:
    power = rng.uniform(0.85, 1.25)
    return Kind('pump_leakage', 'flow', 1e-3, 0.15,
                lambda s: {'pump_wear': s * base.q_nominal, 'pump_wear_power': power})


def motor_leakage(rng: Rng, base: Plant) -> Kind:
    speed = rng.uniform(-0.1, 0.3)
    return Kind('motor_leakage', 'flow', 1e-3, 0.15,
                lambda s: {'motor_wear': s * base.q_nominal, 'motor_wear_speed': speed})


def entrained_air(rng: Rng, base: Plant) -> Kind:
    form = {'air_power': rng.uniform(1.0, 1.4),
            'air_gone': float(rng.choice([1e9, rng.uniform(3e6, 1.5e7)]))}
    return Kind('entrained_air', 'flow', 5e-4, 0.15, lambda s: {'air': s, **form})


def compressibility_flow(rng: Rng, base: Plant) -> Kind:
    pump = rng.uniform(0.4, 1.0)
    return Kind('compressibility_flow', 'flow', 0.05, 8.0,
                lambda s: {'decompress': s * pump, 'decompress_motor': s * (1 - pump)})


def prv_cracking(rng: Rng, base: Plant) -> Kind:
    flow, power = rng.uniform(0.05, 0.4) * base.q_nominal, rng.uniform(1, 2)
    return Kind('prv_cracking', 'flow', 0.05, 0.75, lambda s: {
        'crack_p': base.relief_set * (1 - s), 'crack_q': flow, 'crack_power': power}, heavy=True)


def pump_speed_droop(rng: Rng, base: Plant) -> Kind:
    form = {'droop_lag': rng.uniform(0.1, 0.6), 'droop_bend': rng.uniform(-0.2, 0.4)}
    return Kind('pump_speed_droop', 'flow', 5e-4, 0.08, lambda s: {'droop': s, **form})


def pump_command_offset(rng: Rng, base: Plant) -> Kind:
    sign, fade = _sign(rng), rng.uniform(0, 0.25)
    return Kind('pump_command_offset', 'pump_actuator', 2e-3, 0.6,
                lambda s: {'offset': sign * s, 'offset_fade': fade})


def pump_hysteresis(rng: Rng, base: Plant) -> Kind:
    power = float(rng.choice([0.0, rng.uniform(1, 6)]))
    return Kind('pump_hysteresis', 'pump_actuator', 5e-4, 0.04,
                lambda s: {'play': s * base.stroke_max, 'play_power': power},
                note='half width of a gap, or of a rounded loop')


def pump_rate_limit(rng: Rng, base: Plant) -> Kind:
    ratio, bend = rng.uniform(0.8, 1.25), float(rng.choice([2.0, 4.0, 8.0]))
    return Kind('pump_rate_limit', 'pump_actuator', 0.1, 8.0, lambda s: {
        'rate_up': base.stroke_max / s, 'rate_down': base.stroke_max / s * ratio,
        'rate_round': bend}, neutral=1e-6)


def pump_lag(rng: Rng, base: Plant) -> Kind:
    return Kind('pump_lag', 'pump_actuator', 5e-3, 0.8, lambda s: {'extra_lag': s},
                note='a further pole')


def bearing_friction(rng: Rng, base: Plant) -> Kind:
    dry, power, bristles = rng.uniform(0.2, 1.0), rng.uniform(0.8, 1.1), _bristles(rng)
    return Kind('bearing_friction', 'torque', 1e-3, 0.15, lambda s: {
        'coulomb': s * base.t_nominal * dry, 'coulomb_load': s * (1 - dry),
        'coulomb_power': power, 'bristles': bristles})


def stribeck_friction(rng: Rng, base: Plant) -> Kind:
    form = {'stribeck_w': rng.uniform(0.08, 0.45) * base.w_nominal,
            'stribeck_power': rng.uniform(0.7, 2.0), 'bristles': _bristles(rng)}
    return Kind('stribeck_friction', 'torque', 2e-3, 0.3,
                lambda s: {'stribeck': s * base.t_nominal, **form})


def viscous_drag(rng: Rng, base: Plant) -> Kind:
    power = rng.uniform(0.9, 1.1)
    return Kind('viscous_drag', 'torque', 1e-3, 0.15,
                lambda s: {'viscous': s * base.t_nominal, 'viscous_power': power})


def hydrodynamic_drag(rng: Rng, base: Plant) -> Kind:
    power = rng.uniform(1.8, 2.1)
    return Kind('hydrodynamic_drag', 'torque', 1e-3, 0.15,
                lambda s: {'churn': s * base.t_nominal, 'churn_power': power})


def line_loss(rng: Rng, base: Plant) -> Kind:
    laminar = rng.uniform(0.1, 0.9)
    form = {'line_on': 1, 'line_inertance': _hose(base) * rng.uniform(0.15, 0.5),
            'line_share': rng.uniform(0.3, 0.7)}
    return Kind('line_loss', 'torque', 5e-4, 0.12, lambda s: {
        'line_laminar': s * laminar * base.p_top,
        'line_turbulent': s * (1 - laminar) * base.p_top, **form})


def back_pressure(rng: Rng, base: Plant) -> Kind:
    spring, power = rng.uniform(0.3, 1.0), rng.uniform(1, 2)
    return Kind('back_pressure', 'torque', 5e-4, 0.12, lambda s: {
        'back': s * spring * base.p_top, 'back_flow': s * (1 - spring) * base.p_top,
        'back_power': power}, note='spring of a check valve and what the return line throttles')


def piston_ripple(rng: Rng, base: Plant) -> Kind:
    form = {'ripple_second': rng.uniform(0, 0.5),
            'ripple_pistons': float(rng.choice([5.0, 7.0, 9.0]))}
    return Kind('piston_ripple', 'torque', 2e-3, 0.3, lambda s: {'ripple': s, **form},
                slowest_ms=20)


def shaft_compliance(rng: Rng, base: Plant) -> Kind:
    form = {'twist_share': rng.uniform(0.3, 0.8), 'twist_damping': rng.uniform(0.02, 0.15)}
    return Kind('shaft_compliance', 'torque', 0.03, 20.0,
                lambda s: {'twist': s / base.t_nominal, **form})


def gearbox_loss(rng: Rng, base: Plant) -> Kind:
    share = rng.uniform(0.3, 1.0)
    return Kind('gearbox_loss', 'load', 1e-3, 0.2, lambda s: {
        'gear_share': s * share, 'gear_idle': s * (1 - share) * 0.5 * base.t_nominal})


def pressure_sensor_bias(rng: Rng, base: Plant) -> Kind:
    off = _sign(rng) * base.p_top / 1e5
    return Kind('pressure_sensor_bias', 'sensor', 2e-4, 0.05,
                sensor=lambda s: {'pump_outlet_pressure': lambda t, x, rows: x + s * off},
                parameters=lambda s: {'bias': s * off * 1e5})


def speed_sensor_lag(rng: Rng, base: Plant) -> Kind:
    return Kind('speed_sensor_lag', 'sensor', 2e-3, 1.5, lambda s: {'speed_lag': s},
                note='second order, damping 0.8')


def torque_sensor_scale(rng: Rng, base: Plant) -> Kind:
    sign = _sign(rng)
    return Kind('torque_sensor_scale', 'sensor', 1e-3, 0.25, needs=('load_torque',),
                sensor=lambda s: {'load_torque': lambda t, x, rows: x * (1 + sign * s)},
                parameters=lambda s: {'factor': 1 + sign * s})


def flow_sensor_scale(rng: Rng, base: Plant) -> Kind:
    sign = _sign(rng)
    return Kind('flow_sensor_scale', 'sensor', 1e-3, 0.25, needs=('motor_inlet_flow',),
                sensor=lambda s: {'motor_inlet_flow': lambda t, x, rows: x * (1 + sign * s)},
                parameters=lambda s: {'factor': 1 + sign * s})


def motor_orifice_leakage(rng: Rng, base: Plant) -> Kind:
    return Kind('motor_orifice_leakage', 'flow', 1e-3, 0.15,
                lambda s: {'orifice': s * base.q_nominal / JET})


def suction_starvation(rng: Rng, base: Plant) -> Kind:
    limit = rng.uniform(0.55, 1.0) * base.q_nominal
    return Kind('suction_starvation', 'flow', 2e-3, 1.0,
                lambda s: {'starve': s, 'starve_q': limit})


def swash_compliance(rng: Rng, base: Plant) -> Kind:
    power = rng.uniform(1, 1.6)
    return Kind('swash_compliance', 'pump_actuator', 5e-4, 0.15,
                lambda s: {'swash_yield': s * base.stroke_max, 'swash_power': power})


def constant_torque(rng: Rng, base: Plant) -> Kind:
    if rng.random() < 0.6:
        return Kind('constant_torque', 'torque', 1e-3, 0.15,
                    lambda s: {'hang': s * base.t_nominal}, note='hanging load')
    off = _sign(rng) * base.t_nominal
    return Kind('constant_torque', 'torque', 1e-3, 0.15, needs=('load_torque',),
                sensor=lambda s: {'load_torque': lambda t, x, rows: x + s * off},
                parameters=lambda s: {'zero': s * off}, note='zero of the torque sensor')


def line_inertance(rng: Rng, base: Plant) -> Kind:
    form = {'line_on': 1, 'line_share': rng.uniform(0.3, 0.7),
            'line_laminar': 5e-5 * base.p_top}
    return Kind('line_inertance', 'flow', 2.0, 600.0,
                lambda s: {'line_inertance': s * _hose(base), **form}, neutral=0.1)


def accumulator(rng: Rng, base: Plant) -> Kind:
    precharge, power = rng.uniform(0.08, 0.35) * base.p_top, rng.uniform(1.05, 1.4)

    def plant(s: float) -> dict:
        volume = s * base.volume
        # The neck fills the gas in half a millisecond at the highest pressure, or throttles more.
        least = volume * (precharge / base.p_top) ** (1 / power) / (power * base.p_top)
        return {'acc_volume': volume, 'acc_p': precharge, 'acc_power': power,
                'acc_neck': max(5e5 / base.q_nominal, 5e-4 / max(least, 1e-20))}
    return Kind('accumulator', 'flow', 5e-3, 3.0, plant)


KINDS: dict[str, Callable[[Rng, Plant], Kind]] = {f.__name__: f for f in (
    leakage_temperature, elastic_leakage, pump_leakage, motor_leakage, entrained_air,
    compressibility_flow, prv_cracking, pump_speed_droop, pump_command_offset, pump_hysteresis,
    pump_rate_limit, pump_lag, bearing_friction, stribeck_friction, viscous_drag,
    hydrodynamic_drag, line_loss, back_pressure, piston_ripple, shaft_compliance, gearbox_loss,
    pressure_sensor_bias, speed_sensor_lag, torque_sensor_scale, flow_sensor_scale,
    motor_orifice_leakage, suction_starvation, swash_compliance, constant_torque, line_inertance,
    accumulator)}
