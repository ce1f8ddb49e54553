# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The test rig's datasheet, rigs of another size after it, and how it is written as YAML."""
from copy import deepcopy

import numpy as np

PRESSURES = [0.0, 25.0, 50.0, 75.0, 100.0, 150.0, 200.0]

TEST_RIG = {
    'pump': {
        'shaft_speed_rpm': 1450,
        'max_displacement_cc_rev': 28,
        'displacement_vs_command': {
            'command_V': [0.0, 1.2, 1.8, 3.0, 5.0, 7.0, 9.0, 10.0],
            'displacement_cc_rev': [0.0, 0.0, 0.95, 4.88, 11.5, 18.1, 24.7, 28.0]},
        'displacement_lag_s': 0.06,
        'leakage_L_min': {
            'pressure_bar': PRESSURES,
            'command_V': [0.0, 2.0, 4.0, 6.0, 8.0, 10.0],
            'table': [[0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                      [0.085, 0.09, 0.095, 0.1, 0.106, 0.111],
                      [0.172, 0.182, 0.192, 0.202, 0.212, 0.222],
                      [0.259, 0.274, 0.289, 0.304, 0.32, 0.335],
                      [0.347, 0.367, 0.388, 0.408, 0.428, 0.449],
                      [0.525, 0.556, 0.587, 0.618, 0.649, 0.68],
                      [0.707, 0.749, 0.79, 0.832, 0.874, 0.915]]}},
    'motor': {
        'displacement_cc_rev': 195,
        'inertia_total_kg_m2': 0.35,
        'leakage_L_min': {
            'pressure_bar': PRESSURES,
            'speed_rpm': [0.0, 50.0, 100.0, 150.0, 200.0],
            'table': [[0.0, 0.0, 0.0, 0.0, 0.0],
                      [0.139, 0.145, 0.151, 0.157, 0.163],
                      [0.278, 0.29, 0.302, 0.314, 0.326],
                      [0.419, 0.437, 0.455, 0.473, 0.491],
                      [0.56, 0.585, 0.609, 0.633, 0.658],
                      [0.847, 0.883, 0.92, 0.957, 0.994],
                      [1.137, 1.187, 1.236, 1.285, 1.335]]},
        'mechanical_efficiency': {
            'pressure_bar': [0.0, 5.0, 10.0, 20.0, 30.0, 40.0, 60.0, 80.0, 100.0, 140.0, 200.0],
            'speed_rpm': [0.0, 25.0, 50.0, 100.0, 150.0, 200.0],
            'table': [[0.3, 0.3, 0.3, 0.3, 0.3, 0.3],
                      [0.354, 0.353, 0.351, 0.348, 0.345, 0.342],
                      [0.635, 0.634, 0.632, 0.629, 0.626, 0.623],
                      [0.776, 0.774, 0.773, 0.77, 0.767, 0.764],
                      [0.823, 0.821, 0.82, 0.817, 0.814, 0.811],
                      [0.846, 0.845, 0.843, 0.84, 0.837, 0.834],
                      [0.869, 0.868, 0.866, 0.863, 0.86, 0.857],
                      [0.881, 0.88, 0.878, 0.875, 0.872, 0.869],
                      [0.888, 0.887, 0.885, 0.882, 0.879, 0.876],
                      [0.896, 0.895, 0.893, 0.89, 0.887, 0.884],
                      [0.902, 0.901, 0.899, 0.896, 0.893, 0.89]]}},
    'line': {'bulk_modulus_Pa': 1200000000.0, 'volume_m3': 0.0009,
             'oil_density_kg_m3': 870.0, 'oil_grade': 'ISO VG 46'},
    'relief_valve': {'set_pressure_bar': 200, 'discharge_coefficient': 0.61, 'area_m2': 1.6e-05},
    'loading': {
        'gear_ratio': 20,
        'pump_displacement_cc_rev': 10,
        'pump_mechanical_efficiency': {
            'pressure_bar': [0.0, 10.0, 20.0, 40.0, 60.0, 80.0, 120.0, 200.0],
            'efficiency': [0.62, 0.74, 0.8, 0.85, 0.875, 0.89, 0.9, 0.905]},
        'pprv_pressure_vs_command': {
            'command_V': [0.0, 0.5, 1.0, 2.0, 4.0, 6.0, 8.0, 10.0],
            'pressure_bar': [3.0, 3.0, 8.0, 27.0, 69.0, 112.0, 156.0, 200.0]},
        'pprv_lag_s': 0.05,
        'pprv_override_bar_per_L_min': 0.4,
        'pprv_reference_flow_L_min': 20.0},
    'controller': {'kp_V_per_rad_s': 0.02, 'ki_V_per_rad': 0.45, 'sample_time_s': 0.01,
                   'output_limits_V': [0, 10]},
    'sensors': {
        'pump_outlet_pressure': {'noise_std_bar': 0.12, 'resolution_bar': 0.048828125,
                                 'range_bar': [0, 200]},
        'motor_inlet_flow': {'noise_std_L_min': 0.05, 'resolution_L_min': 0.0146484375},
        'motor_speed': {'noise_std_rpm': 0.15, 'resolution_rpm': 0.05},
        'load_torque': {'noise_std_N_m': 0.5, 'resolution_N_m': 0.1},
        'oil_temperature': {'noise_std_K': 0.1, 'resolution_K': 0.05}},
    'tolerances_1_sigma_relative': {
        'motor.displacement': 0.004, 'motor.inertia': 0.08, 'line.bulk_modulus': 0.1,
        'pump.displacement_vs_command': 0.006, 'pump.displacement_lag': 0.08,
        'pump.leakage': 0.08, 'motor.leakage': 0.08, 'motor.mechanical_efficiency': 0.006,
        'loading.pump_mechanical_efficiency': 0.008, 'loading.pprv_pressure': 0.008,
        'loading.pprv_lag': 0.08, 'loading.pprv_override': 0.08},
    'characterised_at_oil_temperature_degC': 50,
}


def _times(values: list, factor: float) -> list:
    """Return a table, nested or not, times a factor, to five figures as a datasheet prints it."""
    return [_times(value, factor) if isinstance(value, list) else float(f'{value * factor:.5g}')
            for value in values]


def other_size(rng: np.random.Generator) -> tuple[dict, float]:
    """
    Return the datasheet of a rig of the same kind and another size, and how much larger it is.

    Displacements, volumes, areas and flows go with the size; the motor's displacement besides with
    a ratio of its own, which sets the speed at full pump stroke; the inertia as of similar bodies
    under equal acceleration time; leakage a little less than in proportion (clearances grow
    slower than lengths).
    """
    sheet = deepcopy(TEST_RIG)
    size = float(np.exp(rng.uniform(np.log(0.35), np.log(2.8))))
    ratio = float(rng.uniform(0.85, 1.2))
    leaking = size ** 0.9
    pump, motor, loading = sheet['pump'], sheet['motor'], sheet['loading']
    pump['max_displacement_cc_rev'] = float(f'{28 * size:.5g}')
    curve = pump['displacement_vs_command']
    curve['displacement_cc_rev'] = _times(curve['displacement_cc_rev'], size)
    pump['displacement_lag_s'] = float(f'{0.06 * size ** 0.3:.4g}')
    for part in (pump, motor):
        part['leakage_L_min']['table'] = _times(part['leakage_L_min']['table'], leaking)
    motor['displacement_cc_rev'] = float(f'{195 * size * ratio:.5g}')
    motor['inertia_total_kg_m2'] = float(f'{0.35 * size * ratio:.4g}')
    sheet['line']['volume_m3'] = float(f'{9e-4 * size:.4g}')
    sheet['relief_valve']['area_m2'] = float(f'{1.6e-5 * size:.4g}')
    loading['pump_displacement_cc_rev'] = float(f'{10 * size * ratio:.5g}')
    loading['pprv_reference_flow_L_min'] = float(f'{20 * size:.4g}')
    loading['pprv_override_bar_per_L_min'] = float(f'{0.4 / size:.4g}')
    for gain in ('kp_V_per_rad_s', 'ki_V_per_rad'):
        sheet['controller'][gain] = float(f'{sheet["controller"][gain] * ratio:.4g}')
    for name in ('motor_inlet_flow', 'load_torque'):
        sensor = sheet['sensors'][name]
        for key in sensor:
            sensor[key] = float(f'{sensor[key] * size:.5g}')
    return sheet, size


def one_machine(sheet: dict, rng: np.random.Generator) -> dict[str, float]:
    """Return the factors by which one machine is off its datasheet, within twice the tolerance."""
    return {name: 1 + sigma * float(np.clip(rng.standard_normal(), -2, 2))
            for name, sigma in sheet['tolerances_1_sigma_relative'].items()}


def as_yaml(value, indent: int = 0) -> str:
    """Return nested dictionaries of numbers, words and tables as YAML."""
    if isinstance(value, dict):
        lines = []
        for key, entry in value.items():
            text = as_yaml(entry, indent + 2)
            lines.append(f'{" " * indent}{key}:' + ('\n' if isinstance(entry, dict) else ' ')
                         + text)
        return '\n'.join(lines)
    if isinstance(value, list):
        return '[' + ', '.join(as_yaml(entry) for entry in value) + ']'
    if isinstance(value, float):
        text = repr(value)
        # YAML 1.1 takes 1e-05 for a word: a number has a point.
        return text.replace('e', '.0e') if 'e' in text and '.' not in text else text
    return str(value)
