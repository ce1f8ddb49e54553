# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of the test rig's datasheet, rigs of other sizes, units of one make, and rig files."""
import copy

import numpy as np

_DISPLACEMENT = {
    'command_V': [0.0, 1.2, 1.8, 3.0, 5.0, 7.0, 9.0, 10.0],
    'displacement_cc_rev': [0.0, 0.0, 0.95, 4.88, 11.5, 18.1, 24.7, 28.0]}
_PUMP_LEAKAGE = {
    'pressure_bar': [0.0, 25.0, 50.0, 75.0, 100.0, 150.0, 200.0],
    'command_V': [0.0, 2.0, 4.0, 6.0, 8.0, 10.0],
    'table': [[0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
              [0.085, 0.09, 0.095, 0.1, 0.106, 0.111],
              [0.172, 0.182, 0.192, 0.202, 0.212, 0.222],
              [0.259, 0.274, 0.289, 0.304, 0.32, 0.335],
              [0.347, 0.367, 0.388, 0.408, 0.428, 0.449],
              [0.525, 0.556, 0.587, 0.618, 0.649, 0.68],
              [0.707, 0.749, 0.79, 0.832, 0.874, 0.915]]}
_MOTOR_LEAKAGE = {
    'pressure_bar': [0.0, 25.0, 50.0, 75.0, 100.0, 150.0, 200.0],
    'speed_rpm': [0.0, 50.0, 100.0, 150.0, 200.0],
    'table': [[0.0, 0.0, 0.0, 0.0, 0.0],
              [0.139, 0.145, 0.151, 0.157, 0.163],
              [0.278, 0.29, 0.302, 0.314, 0.326],
              [0.419, 0.437, 0.455, 0.473, 0.491],
              [0.56, 0.585, 0.609, 0.633, 0.658],
              [0.847, 0.883, 0.92, 0.957, 0.994],
              [1.137, 1.187, 1.236, 1.285, 1.335]]}
_EFFICIENCY = {
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
              [0.902, 0.901, 0.899, 0.896, 0.893, 0.89]]}
SHEET = {
    'name': 'test rig',
    'pump': {
        'shaft_speed_rpm': 1450, 'max_displacement_cc_rev': 28,
        'displacement_vs_command': _DISPLACEMENT, 'displacement_lag_s': 0.06,
        'leakage_L_min': _PUMP_LEAKAGE},
    'motor': {
        'displacement_cc_rev': 195, 'inertia_total_kg_m2': 0.35,
        'leakage_L_min': _MOTOR_LEAKAGE, 'mechanical_efficiency': _EFFICIENCY},
    'line': {'bulk_modulus_Pa': 1.2e9, 'volume_m3': 0.0009, 'oil_density_kg_m3': 870.0,
             'oil_grade': 'ISO VG 46'},
    'relief_valve': {'set_pressure_bar': 200, 'discharge_coefficient': 0.61, 'area_m2': 1.6e-05},
    'loading': {
        'gear_ratio': 20, 'pump_displacement_cc_rev': 10,
        'pump_mechanical_efficiency': {
            'pressure_bar': [0.0, 10.0, 20.0, 40.0, 60.0, 80.0, 120.0, 200.0],
            'efficiency': [0.62, 0.74, 0.8, 0.85, 0.875, 0.89, 0.9, 0.905]},
        'pprv_pressure_vs_command': {
            'command_V': [0.0, 0.5, 1.0, 2.0, 4.0, 6.0, 8.0, 10.0],
            'pressure_bar': [3.0, 3.0, 8.0, 27.0, 69.0, 112.0, 156.0, 200.0]},
        'pprv_lag_s': 0.05, 'pprv_override_bar_per_L_min': 0.4,
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

#: Other rigs: pump [cc], shaft [rpm], motor [cc], nominal speed [rpm], relief set [bar],
#: volume [m3], inertia [kg m2], gear ratio, loading pump [cc].
SIZES = {
    'small rig': (10, 2800, 50, 250, 160, 3.5e-4, 0.05, 12, 4),
    'large rig': (160, 1480, 2000, 60, 250, 6e-3, 25.0, 30, 63),
    'high pressure rig': (71, 1800, 400, 150, 350, 1.8e-3, 1.2, 16, 25),
}


def _times(values: list, factor: float) -> list:
    """Multiply numbers of a nested list, rounded to five figures as a datasheet would."""
    if isinstance(values, list):
        return [_times(v, factor) for v in values]
    return float(f'{values * factor:.5g}')


def nominal_speed(sheet: dict) -> float:
    """Return the speed [rpm] that a rig drills at."""
    return SIZES[sheet['name']][3] if sheet['name'] in SIZES else 100.0


def rig(name: str = 'test rig') -> dict:
    """Return the datasheet of the test rig or of one of SIZES."""
    sheet = copy.deepcopy(SHEET)
    if name == sheet['name']:
        return sheet
    pump, shaft, motor, speed, relief, volume, inertia, gear, loading = SIZES[name]
    flow = motor * speed / (195 * 100)
    pressure = relief / 200
    turn = speed / 100
    gain = (28 * 1450 / 195) / (pump * shaft / motor)
    sheet['name'] = name
    p, m, load = sheet['pump'], sheet['motor'], sheet['loading']
    p.update(shaft_speed_rpm=shaft, max_displacement_cc_rev=pump)
    curve = p['displacement_vs_command']
    curve['displacement_cc_rev'] = _times(curve['displacement_cc_rev'], pump / 28)
    m.update(displacement_cc_rev=motor, inertia_total_kg_m2=inertia)
    for table in (p['leakage_L_min'], m['leakage_L_min'], m['mechanical_efficiency']):
        table['pressure_bar'] = _times(table['pressure_bar'], pressure)
        if 'speed_rpm' in table:
            table['speed_rpm'] = _times(table['speed_rpm'], turn)
    for table in (p['leakage_L_min'], m['leakage_L_min']):
        table['table'] = _times(table['table'], flow)
    sheet['line']['volume_m3'] = volume
    sheet['relief_valve'].update(set_pressure_bar=relief, area_m2=_times(1.6e-5, flow))
    load.update(gear_ratio=gear, pump_displacement_cc_rev=loading)
    for name, key in (('pump_mechanical_efficiency', 'pressure_bar'),
                      ('pprv_pressure_vs_command', 'pressure_bar')):
        load[name][key] = _times(load[name][key], pressure)
    reference = gear * loading * speed / 1000
    load['pprv_reference_flow_L_min'] = _times(reference, 1.0)
    load['pprv_override_bar_per_L_min'] = _times(0.4 * pressure * 20, 1 / reference)
    control = sheet['controller']
    for key in ('kp_V_per_rad_s', 'ki_V_per_rad'):
        control[key] = _times(control[key], gain)
    sensors = sheet['sensors']
    for sensor, factor in (('pump_outlet_pressure', pressure), ('motor_inlet_flow', flow),
                           ('motor_speed', turn), ('load_torque', motor / 195 * pressure)):
        sensors[sensor] = {k: _times(v, factor) for k, v in sensors[sensor].items()}
    return sheet


def unit(sheet: dict, seed: np.random.Generator | None) -> dict:
    """
    Draw a unit of that make: the factor and the tilt of each number that has a tolerance.

    Without a generator the unit is exactly on its datasheet. The tilt lets a curve be off a
    little less at one end than at the other (0.3 of the tolerance, in its standard deviation).
    """
    names = sheet['tolerances_1_sigma_relative']
    if seed is None:
        return {name: (1.0, 0.0) for name in names}
    return {name: (1 + sigma * float(np.clip(seed.standard_normal(), -2.5, 2.5)),
                   0.3 * sigma * float(np.clip(seed.standard_normal(), -2.5, 2.5)))
            for name, sigma in names.items()}


def rig_text(value: object, indent: int = 0) -> str:
    """Return a datasheet as the text of a YAML file."""
    pad = ' ' * indent
    lines = []
    for key, item in value.items():
        if isinstance(item, dict):
            lines += [f'{pad}{key}:', rig_text(item, indent + 2)]
        elif isinstance(item, list) and item and isinstance(item[0], list):
            lines += [f'{pad}{key}:', *(f'{pad}- {row}' for row in item)]
        elif isinstance(item, float):
            lines.append(f'{pad}{key}: {np.format_float_positional(item, trim="0")}')
        else:
            lines.append(f'{pad}{key}: {item}')
    return '\n'.join(lines)
