# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Datasheets of three sizes of closed-circuit and valve-driven heads, and units off them."""

from __future__ import annotations

from math import pi

import numpy as np

BAR, L_MIN, RPM, CC = 1e5, 1e-3 / 60, pi / 30, 1e-6 / (2 * pi)
RATED_PRESSURE = 200e5
# pump cc/rev, rpm, lag s; motor cc/rev, count, gear, inertia; charge cc/rev; line litres
SIZES = {
    'small': (28, 2200, 0.09, 80, 1, 4.5, 1.1, 8, 0.9),
    'medium': (71, 1800, 0.12, 160, 2, 3.0, 9.0, 16, 2.5),
    'large': (130, 1700, 0.15, 250, 4, 2.6, 60.0, 28, 5.0),
}
TOLERANCES = {
    'motor.leakage': 0.15, 'pump.leakage': 0.15, 'motor.displacement': 0.004,
    'motor.inertia': 0.08, 'line.bulk_modulus': 0.1, 'pump.displacement_vs_command': 0.006,
    'pump.displacement_lag': 0.1, 'motor.mechanical_efficiency': 0.01,
    'charge.relief_pressure': 0.03, 'charge.pump_displacement': 0.02, 'gear.efficiency': 0.01,
    'valve.rated_flow': 0.03, 'valve.lag': 0.1}


def _two(x: float) -> float:
    return float(f'{x:.2g}')


def _three(x: float) -> float:
    return float(f'{x:.3g}')


def draw(circuit: str, rng: np.random.Generator, gear: bool = False) -> dict:
    """
    Return the datasheet of a rig, drawn: one of three sizes, its numbers moved a little.

    With `gear` it has one; otherwise by chance, where there is one motor.
    """
    size = list(SIZES)[int(rng.integers(3))]
    pump, rpm, lag, motor, count, ratio, inertia, charge, litres = SIZES[size]
    pump, motor = round(pump * rng.uniform(0.9, 1.1)), round(motor * rng.uniform(0.85, 1.2))
    flow = pump * rpm / 1000
    geared = rng.random() < 0.6 or count > 1 or gear
    if not geared:
        motor, ratio = round(motor * ratio), 1.0
    total = motor * count * ratio
    torque = RATED_PRESSURE * total * CC
    head = total / (motor * count)
    sheet = {'name': f'{size.capitalize()} {circuit} head', 'circuit': circuit}
    if circuit == 'closed':
        sheet['pump'] = {
            'shaft_speed_rpm': rpm, 'max_displacement_cc_rev': pump,
            'displacement_vs_command': {'command_V': [-10, -1, 1, 10],
                                        'displacement_cc_rev': [-pump, 0, 0, pump]},
            'displacement_lag_s': lag,
            'leakage_L_min': {'laminar_L_min_per_bar': _two(0.018 * flow / 200),
                              'turbulent_L_min_per_sqrt_bar': _two(0.002 * flow / 200 ** 0.5)},
            'mechanical_efficiency': 0.93}
    else:
        flow *= 0.6
        sheet['supply'] = {'pressure_bar': int(rng.choice([180, 210, 250]))}
        dead = float(rng.choice([0.3, 0.4, 0.5]))
        sheet['valve'] = {
            'rated_flow_L_min': round(flow), 'rated_pressure_drop_bar': 35,
            'opening_vs_command': {'command_V': [-10, -dead, dead, 10],
                                   'opening': [-1, 0, 0, 1]},
            'lag_s': float(rng.choice([0.015, 0.02, 0.03]))}
    sheet['motor'] = {
        'displacement_cc_rev': motor, 'count': count,
        'inertia_total_kg_m2': _three(inertia * rng.uniform(0.7, 1.3)),
        'leakage_L_min': {'laminar_L_min_per_bar': _two(0.02 * flow / 200 / count)},
        'mechanical_efficiency': {
            'coulomb_N_m': _two(0.012 * torque / count / head),
            'viscous_N_m_s_per_rad': _two(0.012 * torque / count / head
                                          / (flow * L_MIN / (motor * count * CC))),
            'pressure_share': 0.04},
        'pistons': int(rng.choice([5, 7, 9]))}
    if geared:
        sheet['gear'] = {'ratio': round(ratio * rng.uniform(0.9, 1.1), 2), 'efficiency': 0.97}
    sheet['line'] = {'volume_m3': _two(litres * 1e-3 * rng.uniform(0.7, 1.4)),
                     'bulk_modulus_Pa': 1.3e9, 'oil_density_kg_m3': 870,
                     'oil_grade': 'ISO VG 46'}
    if circuit == 'closed':
        sheet['cross_port_relief'] = {'set_pressure_bar': 350,
                                      'override_bar_per_L_min': _two(50 / flow)}
        sheet['charge'] = {
            'pump_displacement_cc_rev': charge, 'relief_pressure_bar': 24,
            'relief_override_bar_per_L_min': _two(10 / flow),
            'check_valve_bar_per_L_min': _two(6.4 / flow),
            'flushing_L_min': round(0.06 * flow, 1) if rng.random() < 0.7 else 0}
    sheet['sensors'] = _sensors(flow, torque, pump, rng)
    mine = ('charge_', 'pump_torque', 'pump_speed', 'pump_displacement')
    for channel in list(sheet['sensors']):
        if channel.startswith(mine if circuit == 'valve' else 'pump_outlet'):
            del sheet['sensors'][channel]
    own = ({'charge', 'pump'} if circuit == 'closed' else {'valve'}) | {'motor', 'line'}
    own |= {'gear'} if geared else set()
    if rng.random() < 0.2:
        sheet['motor']['second_displacement_cc_rev'] = round(motor / 2)
    sheet['tolerances_1_sigma_relative'] = {
        k: v for k, v in TOLERANCES.items() if k.split('.')[0] in own}
    return sheet


def _sensors(flow: float, torque: float, pump: float, rng: np.random.Generator) -> dict:
    bar, rpm = (float(rng.choice(x)) for x in ((0.15, 0.3, 0.5), (0.1, 0.15, 0.3)))
    pressure = {'noise_std_bar': bar, 'resolution_bar': 0.1, 'range_bar': [0, 400]}
    low = {'noise_std_bar': 0.1, 'resolution_bar': 0.02, 'range_bar': [0, 60]}
    nm = 0.004 * torque
    drive = RATED_PRESSURE * pump * CC
    return {
        'line_a_pressure': pressure, 'line_b_pressure': pressure, 'charge_pressure': low,
        'pump_outlet_pressure': pressure,
        'motor_speed': {'noise_std_rpm': rpm, 'resolution_rpm': 0.05},
        'motor_torque': {'noise_std_N_m': _two(nm), 'resolution_N_m': _two(nm / 5)},
        'pump_torque': {'noise_std_N_m': _two(0.005 * drive),
                        'resolution_N_m': _two(0.001 * drive)},
        'pump_speed': {'noise_std_rpm': 1.0, 'resolution_rpm': 0.5},
        'pump_displacement': {'noise_std_cc_rev': _two(0.002 * pump),
                              'resolution_cc_rev': _two(0.0005 * pump)},
        'case_drain_flow': {'noise_std_L_min': _two(0.0005 * flow),
                            'resolution_L_min': _two(0.0002 * flow)},
        'oil_temperature': {'noise_std_K': 0.1, 'resolution_K': 0.05}}


def scatter(sheet: dict, rng: np.random.Generator, on_datasheet: bool = False) -> dict[str, float]:
    """Return the factor of this unit on each toleranced number, log-normal, cut at 2.5 sigma."""
    return {name: 1.0 if on_datasheet else
            float(np.exp(sigma * np.clip(rng.standard_normal(), -2.5, 2.5)))
            for name, sigma in sheet['tolerances_1_sigma_relative'].items()}


def numbers(sheet: dict, factor: dict[str, float], rng: np.random.Generator,
            detail: float) -> dict[str, float]:
    """
    Return the numbers of the hidden unit in SI units, by the names that the kernels use.

    `detail` scales what a datasheet never tells: how the leakage splits between case and other
    line, rounded corners, pressure dependence of the oil, dissolved air; 0 is as simple as can be.
    """
    f = {**dict.fromkeys(TOLERANCES, 1.0), **factor}
    motor, gear, line = sheet['motor'], sheet.get('gear', {}), sheet['line']
    loss, leak = motor['mechanical_efficiency'], motor['leakage_L_min']
    ratio, count = gear.get('ratio', 1.0), motor['count']
    share = loss['pressure_share']
    better = f['motor.mechanical_efficiency']
    out = {
        'd_motor': motor['displacement_cc_rev'] * CC * f['motor.displacement'],
        'd_second': motor.get('second_displacement_cc_rev', 0.0) * CC
        * f['motor.displacement'],
        'count': count, 'ratio': ratio, 'per_turn': count * ratio,
        'gear_eta': min(gear.get('efficiency', 1.0) * f['gear.efficiency'], 1.0),
        'inertia': motor['inertia_total_kg_m2'] * f['motor.inertia'],
        'inertia_share': rng.uniform(0.35, 0.6),
        'm_coul': loss['coulomb_N_m'], 'm_visc': loss['viscous_N_m_s_per_rad'],
        'm_share': share + (1 - share) * (1 - better),
        'm_lam': leak['laminar_L_min_per_bar'] * L_MIN / BAR * f['motor.leakage'],
        'm_turb': leak.get('turbulent_L_min_per_sqrt_bar', 0.0) * L_MIN / BAR ** 0.5
        * f['motor.leakage'],
        'case_share': 1 - detail * rng.uniform(0.0, 0.1),
        'bulk': line['bulk_modulus_Pa'] * f['line.bulk_modulus'],
        'bulk_slope': detail * 2.0, 'air0': detail * 5e-4, 'volume': line['volume_m3'],
        'corner': 0.01 + 0.03 * detail,
    }
    if sheet['circuit'] == 'valve':
        valve = sheet['valve']
        curve = valve['opening_vs_command']
        out.update(
            k_valve=valve['rated_flow_L_min'] * L_MIN * f['valve.rated_flow']
            / (valve['rated_pressure_drop_bar'] * BAR) ** 0.5,
            p_supply=sheet['supply']['pressure_bar'] * BAR, u_zero=curve['command_V'][2],
            spool_play=0.02 * detail, lag=valve['lag_s'] * f['valve.lag'])
        return out
    pump, charge = sheet['pump'], sheet['charge']
    leak, relief = pump['leakage_L_min'], sheet['cross_port_relief']
    out.update(
        w_pump=pump['shaft_speed_rpm'] * RPM,
        d_pump=pump['max_displacement_cc_rev'] * CC * f['pump.displacement_vs_command'],
        u_zero=pump['displacement_vs_command']['command_V'][2],
        lag=pump['displacement_lag_s'] * f['pump.displacement_lag'],
        p_lam=leak['laminar_L_min_per_bar'] * L_MIN / BAR * f['pump.leakage'],
        p_turb=leak['turbulent_L_min_per_sqrt_bar'] * L_MIN / BAR ** 0.5 * f['pump.leakage'],
        p_share=1 / pump['mechanical_efficiency'] - 1,
        p_set=relief['set_pressure_bar'] * BAR,
        g_relief=L_MIN / BAR / relief['override_bar_per_L_min'],
        d_charge=charge['pump_displacement_cc_rev'] * CC * f['charge.pump_displacement'],
        c_set=charge['relief_pressure_bar'] * BAR * f['charge.relief_pressure'],
        g_charge=L_MIN / BAR / charge['relief_override_bar_per_L_min'],
        g_check0=L_MIN / BAR / charge['check_valve_bar_per_L_min'],
        g_flush=charge['flushing_L_min'] * L_MIN / (charge['relief_pressure_bar'] * BAR),
        v_charge=0.4 * line['volume_m3'])
    return out


def scales(sheet: dict) -> dict[str, float]:
    """Return rated flow, pressure, speed and torque and the capacity of a line (SI)."""
    motor = sheet['motor']
    per_turn = motor['displacement_cc_rev'] * motor['count'] * CC \
        * sheet.get('gear', {}).get('ratio', 1.0)
    if sheet['circuit'] == 'closed':
        pump = sheet['pump']
        flow = pump['max_displacement_cc_rev'] * CC * pump['shaft_speed_rpm'] * RPM
        pressure = RATED_PRESSURE
    else:
        flow = sheet['valve']['rated_flow_L_min'] * L_MIN
        pressure = 0.6 * sheet['supply']['pressure_bar'] * BAR
    return {'Q': flow, 'P': pressure, 'W': flow / per_turn, 'T': pressure * per_turn,
            'C': sheet['line']['volume_m3'] / sheet['line']['bulk_modulus_Pa']}
