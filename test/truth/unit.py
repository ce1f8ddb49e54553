# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The rig that makes the data: datasheet, scatter of one unit, other rigs, smooth tables."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator
import yaml

BAR, L_MIN, RPM, CC = 1e5, 1e-3 / 60, np.pi / 30, 1e-6 / (2 * np.pi)
P_STEP, U_STEP, W_STEP = 0.5e5, 0.05, 0.25
P_TOP, U_TOP, W_TOP = 200e5, 10.0, 21.0
DETAIL, DETAIL_LOAD = 0.25, 0.1    # weight of a smooth curve against straight pieces


def datasheet() -> dict:
    """Return a fresh copy of the test rig's datasheet, as in its YAML file."""
    return yaml.safe_load((Path(__file__).parent / 'datasheet.yaml').read_text())


def other_rig(seed: int) -> dict:
    """Return the datasheet of a rig of another size, with the same working pressures."""
    rng = np.random.default_rng([seed, 77])
    sheet = datasheet()
    pump, motor, loading = rng.uniform(0.5, 2.5), rng.uniform(0.8, 1.3), rng.uniform(0.9, 1.1)
    size = pump * motor
    d = sheet['pump']
    d['max_displacement_cc_rev'] = round(d['max_displacement_cc_rev'] * pump, 3)
    curve = d['displacement_vs_command']
    curve['displacement_cc_rev'] = [round(x * pump, 4) for x in curve['displacement_cc_rev']]
    for table, factor in ((d['leakage_L_min'], pump), (sheet['motor']['leakage_L_min'], size)):
        table['table'] = [[round(x * factor, 4) for x in row] for row in table['table']]
    sheet['motor']['displacement_cc_rev'] = round(195 * size, 2)
    sheet['motor']['inertia_total_kg_m2'] = round(0.35 * size * rng.uniform(0.7, 1.4), 4)
    sheet['line']['volume_m3'] = round(9e-4 * size * rng.uniform(0.7, 1.8), 7)
    sheet['relief_valve']['area_m2'] = float(f'{1.6e-5 * size:.4g}')
    gear = int(rng.integers(12, 26))
    sheet['loading']['gear_ratio'] = gear
    small = 10 * 20 / gear * size * loading
    sheet['loading']['pump_displacement_cc_rev'] = round(small, 3)
    flow = gear * small * 100 / motor / 1000
    sheet['loading']['pprv_reference_flow_L_min'] = round(flow, 3)
    sheet['loading']['pprv_override_bar_per_L_min'] = round(0.4 * 20 / flow, 4)
    for name, quantity in (('load_torque', 'N_m'), ('motor_inlet_flow', 'L_min')):
        factor = size if name == 'load_torque' else pump
        for key in (f'noise_std_{quantity}', f'resolution_{quantity}'):
            sheet['sensors'][name][key] = float(f'{sheet["sensors"][name][key] * factor:.4g}')
    return sheet


def scatter(sheet: dict, rng: np.random.Generator, on_datasheet: bool) -> dict[str, float]:
    """Return relative factors of this unit, one per toleranced number (1.0 on the datasheet)."""
    return {name: 1.0 if on_datasheet else float(1 + sigma * np.clip(rng.standard_normal(), -3, 3))
            for name, sigma in sheet['tolerances_1_sigma_relative'].items()}


def _curve(x: list, y: list, at: np.ndarray, weight: float = DETAIL) -> np.ndarray:
    x, y = np.asarray(x, float), np.asarray(y, float)
    at = np.clip(at, x[0], x[-1])
    return weight * PchipInterpolator(x, y)(at) + (1 - weight) * np.interp(at, x, y)


def _surface(x: list, y: list, table: list, at_x: np.ndarray, at_y: np.ndarray) -> np.ndarray:
    rows = np.array([_curve(y, row, at_y) for row in table])
    return np.ascontiguousarray(np.array([_curve(x, col, at_x) for col in rows.T]).T)


def tables(sheet: dict, factor: dict[str, float]) -> tuple[np.ndarray, ...]:
    """
    Return the unit's tables on even, fine grids (SI): displacement, leakages, efficiencies, PPRV.

    Order: pump displacement (u), pump leakage (P, u), motor leakage (P, w), motor efficiency
    (P, w), loading pump efficiency (P), PPRV pressure (v).
    """
    p, u, w = (np.arange(0, top + step / 2, step) for top, step in
               ((P_TOP, P_STEP), (U_TOP, U_STEP), (W_TOP, W_STEP)))
    pump, motor, load = sheet['pump'], sheet['motor'], sheet['loading']
    c = pump['displacement_vs_command']
    lp, lm, em = pump['leakage_L_min'], motor['leakage_L_min'], motor['mechanical_efficiency']
    el, pv = load['pump_mechanical_efficiency'], load['pprv_pressure_vs_command']
    return (
        _curve(c['command_V'], c['displacement_cc_rev'], u) * CC
        * factor['pump.displacement_vs_command'],
        _surface(lp['pressure_bar'], lp['command_V'], lp['table'], p / BAR, u) * L_MIN
        * factor['pump.leakage'],
        _surface(lm['pressure_bar'], lm['speed_rpm'], lm['table'], p / BAR, w / RPM) * L_MIN
        * factor['motor.leakage'],
        _surface(em['pressure_bar'], em['speed_rpm'], em['table'], p / BAR, w / RPM)
        * factor['motor.mechanical_efficiency'],
        _curve(el['pressure_bar'], el['efficiency'], p / BAR, DETAIL_LOAD)
        * factor['loading.pump_mechanical_efficiency'],
        _curve(pv['command_V'], pv['pressure_bar'], u, DETAIL_LOAD) * BAR
        * factor['loading.pprv_pressure'],
    )


def numbers(sheet: dict, factor: dict[str, float]) -> dict[str, float]:
    """Return the unit's single numbers in SI units, by the names that the kernel uses."""
    line, valve, load, ctrl = (sheet[k] for k in ('line', 'relief_valve', 'loading', 'controller'))
    over = load['pprv_override_bar_per_L_min'] * BAR / L_MIN
    return {
        'w_pump': sheet['pump']['shaft_speed_rpm'] * RPM,
        'd_pump_max': sheet['pump']['max_displacement_cc_rev'] * CC,
        'd_motor': sheet['motor']['displacement_cc_rev'] * CC * factor['motor.displacement'],
        'inertia': sheet['motor']['inertia_total_kg_m2'] * factor['motor.inertia'],
        'bulk': line['bulk_modulus_Pa'] * factor['line.bulk_modulus'],
        'volume': line['volume_m3'],
        'hose_inertance': 5e6 * 9e-4 / line['volume_m3'],
        'cd_area': valve['discharge_coefficient'] * valve['area_m2'],
        'p_set': valve['set_pressure_bar'] * BAR, 'rho': line['oil_density_kg_m3'],
        'gear': load['gear_ratio'], 'd_load': load['pump_displacement_cc_rev'] * CC,
        'override': over * factor['loading.pprv_override'],
        'q_ref': load['pprv_reference_flow_L_min'] * L_MIN,
        'lag_pump': sheet['pump']['displacement_lag_s'] * factor['pump.displacement_lag'],
        'lag_pprv': load['pprv_lag_s'] * factor['loading.pprv_lag'],
        'kp': ctrl['kp_V_per_rad_s'], 'ki': ctrl['ki_V_per_rad'],
        'u_low': ctrl['output_limits_V'][0], 'u_high': ctrl['output_limits_V'][1],
        'speed_resolution': sheet['sensors']['motor_speed']['resolution_rpm'] * RPM,
    }
