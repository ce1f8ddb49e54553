# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The numbers of one machine in SI, made from its datasheet, its own factors and its effects."""
from collections import namedtuple
from math import pi

import numpy as np

BAR = 1e5
L_MIN = 1e-3 / 60
CC_REV = 1e-6 / (2 * pi)
RPM = 2 * pi / 60
NEVER = 1e12

# What a healthy machine has of everything that an effect may change.
NEUTRAL = {
    # the pump's plate and its shaft
    'extra_lag': 0.0, 'yield_from': 0.0, 'yield_share': 0.0, 'yield_stroke': 0.0,
    'spot_height': 0.0, 'spot_at': 5.0, 'spot_width': 0.3, 'rate_smooth': 0.0,
    'rate_limit': NEVER, 'droop': 0.0, 'droop_square': 0.0, 'prime_lag': 0.01,
    'command_gain': 1.0, 'command_shift': 0.0, 'shift_fades': 0.0, 'dropout': 0.0,
    'hunt': 0.0, 'hunt_hz': 2.0, 'play': 0.0, 'play_share': 1.0, 'play_spread': 0.0,
    'stick': 0.0,
    # oil that goes elsewhere
    'fill_from': NEVER, 'fill_share': 0.0, 'fill_square': 0.0, 'decompression': 0.0,
    'dead_stroke': 0.0, 'dead_piston': 0.0, 'pump_leak_factor': 1.0, 'pump_gap': 0.0,
    'pump_gap_stroke': 0.0, 'motor_leak_factor': 1.0, 'gap_growth': 0.0, 'gap_linear': 0.0,
    'gap_cube': 0.0, 'gap_exp': 0.0, 'motor_gap': 0.0, 'motor_gap_speed': 0.0,
    'motor_orifice': 0.0, 'orifice_width': 1e5, 'lobe_gap': 0.0, 'air': 0.0,
    'air_dissolved': 0.0, 'air_exponent': 1.2, 'burst': 0.0, 'hole': 0.0,
    'crack_from': NEVER, 'crack_slope': 0.0, 'crack_square': 0.0,
    'inertance': 0.0, 'far_share': 0.5, 'line_laminar': 0.0, 'line_turbulent': 0.0,
    'line_blasius': 0.0, 'line_wave': 0.0, 'gas_volume': 0.0, 'gas_neck': 0.0, 'gas_pressure': 1e6,
    'gas_exponent': 1.2, 'creep': 0.0, 'creep_time': 2.0,
    # torque that goes elsewhere
    'coulomb': 0.0, 'coulomb_fades': 0.0, 'coulomb_load': 0.0, 'heat_torque': 0.0,
    'heat_speed': 10.0, 'heat_time': 15.0, 'stribeck_speed': 3.0, 'stribeck_gauss': 0.0,
    'stribeck_exp': 0.0, 'stribeck_hill': 0.0, 'band_torque': 0.0, 'band_at': 10.0,
    'band_width': 1.0, 'viscous': 0.0, 'viscous_bend': 0.0, 'churning': 0.0,
    'churning_power': 2.0, 'bent_torque': 0.0, 'bent_order': 1.0, 'return_pressure': 0.0,
    'return_square': 0.0, 'ripple': 0.0, 'ripple_rectified': 0.0, 'pistons': 7.0, 'jolt': 0.0,
    # between the motor and the load, and the load itself
    'shaft_stiffness': 0.0, 'shaft_hardening': 0.0, 'shaft_damping': 0.0, 'motor_share': 0.5,
    'clogged': 0.0, 'starved': 0.0, 'starved_from': 10.0, 'gear_share': 0.0,
    'gear_share_speed': 0.0, 'gear_torque': 0.0, 'slip_torque': NEVER, 'hanging': 0.0,
    'amplifier_limit': NEVER, 'v_play': 0.0, 'v_stick': 0.0, 'coil_drift': 0.0,
    'coil_time': 20.0, 'chatter_from': NEVER, 'chatter': 0.0, 'chatter_hz': 4.0,
    # the speed that the controller reads
    'speed_scale': 1.0, 'eccentric': 0.0, 'speed_lag': 0.0, 'speed_lag_2': 0.0,
}

_MADE = ('stroke_grid', 'stroke_values', 'stroke_stop', 'stroke_lag', 'return_lag', 'pilot_lag',
         'prime_speed', 'prime_torque', 'leak_pressures', 'leak_commands', 'pump_leaks',
         'leak_speeds', 'motor_leaks', 'displacement', 'inertia', 'eta_pressures', 'eta_speeds',
         'etas', 'bulk_modulus', 'bulk_growth', 'volume', 'relief_set', 'relief_gain', 'gear',
         'load_displacement', 'load_pressures', 'load_efficiencies', 'pprv_commands',
         'pprv_pressures', 'loading_lag', 'rise_lag', 'override', 'override_flow', 'kp', 'ki',
         'u_low', 'u_high', 'control_ticks')
Machine = namedtuple('Machine', (*_MADE, *NEUTRAL))

# What a real machine has and its datasheet leaves out; all of it below the sensors' noise.
PILOT_LAG = 0.002
BULK_GROWTH = 4e-9


def _column(values, unit: float) -> np.ndarray:
    return np.array(values, dtype=float) * unit


def build(sheet: dict, off: dict[str, float], changes: dict[str, float]) -> Machine:
    """
    Return a machine.

    Parameters
    ----------
    sheet : dict
        Its datasheet.
    off : dict
        Its factors, by the names of the datasheet's tolerances; those left out are 1.
    changes : dict
        Values that differ from NEUTRAL or from what the datasheet gives.

    """
    def own(name: str) -> float:
        return off.get(name, 1.0)

    pump, motor, loading = sheet['pump'], sheet['motor'], sheet['loading']
    curve, efficiency = pump['displacement_vs_command'], motor['mechanical_efficiency']
    relief, line, control = sheet['relief_valve'], sheet['line'], sheet['controller']
    braking, pprv = loading['pump_mechanical_efficiency'], loading['pprv_pressure_vs_command']
    stroke = CC_REV * own('pump.displacement_vs_command')
    lag = pump['displacement_lag_s'] * own('pump.displacement_lag')
    pprv_lag = loading['pprv_lag_s'] * own('loading.pprv_lag')
    made = {
        'stroke_grid': _column(curve['command_V'], 1),
        'stroke_values': _column(curve['displacement_cc_rev'], stroke),
        'stroke_stop': pump['max_displacement_cc_rev'] * 1.02 * CC_REV,
        'stroke_lag': lag, 'return_lag': lag, 'pilot_lag': PILOT_LAG,
        'prime_speed': pump['shaft_speed_rpm'] * RPM,
        'prime_torque': pump['max_displacement_cc_rev'] * CC_REV * 100 * BAR,
        'leak_pressures': _column(pump['leakage_L_min']['pressure_bar'], BAR),
        'leak_commands': _column(pump['leakage_L_min']['command_V'], 1),
        'pump_leaks': _column(pump['leakage_L_min']['table'], L_MIN * own('pump.leakage')),
        'leak_speeds': _column(motor['leakage_L_min']['speed_rpm'], RPM),
        'motor_leaks': _column(motor['leakage_L_min']['table'], L_MIN * own('motor.leakage')),
        'displacement': motor['displacement_cc_rev'] * CC_REV * own('motor.displacement'),
        'inertia': motor['inertia_total_kg_m2'] * own('motor.inertia'),
        'eta_pressures': _column(efficiency['pressure_bar'], BAR),
        'eta_speeds': _column(efficiency['speed_rpm'], RPM),
        'etas': _column(efficiency['table'], own('motor.mechanical_efficiency')),
        'bulk_modulus': line['bulk_modulus_Pa'] * own('line.bulk_modulus'),
        'bulk_growth': BULK_GROWTH, 'volume': line['volume_m3'],
        'relief_set': relief['set_pressure_bar'] * BAR,
        'relief_gain': relief['discharge_coefficient'] * relief['area_m2']
        * np.sqrt(2 / line['oil_density_kg_m3']),
        'gear': float(loading['gear_ratio']),
        'load_displacement': loading['pump_displacement_cc_rev'] * CC_REV,
        'load_pressures': _column(braking['pressure_bar'], BAR),
        'load_efficiencies': _column(braking['efficiency'],
                                     own('loading.pump_mechanical_efficiency')),
        'pprv_commands': _column(pprv['command_V'], 1),
        'pprv_pressures': _column(pprv['pressure_bar'], BAR * own('loading.pprv_pressure')),
        'loading_lag': pprv_lag, 'rise_lag': pprv_lag,
        'override': loading['pprv_override_bar_per_L_min'] * BAR / L_MIN
        * own('loading.pprv_override'),
        'override_flow': loading['pprv_reference_flow_L_min'] * L_MIN,
        'kp': control['kp_V_per_rad_s'], 'ki': control['ki_V_per_rad'],
        'u_low': float(control['output_limits_V'][0]),
        'u_high': float(control['output_limits_V'][1]),
        'control_ticks': round(control['sample_time_s'] * 1000),
    }
    values = {**NEUTRAL, **made, **changes}
    return Machine(**{name: value if isinstance(value, np.ndarray) else float(value)
                      for name, value in values.items()})
