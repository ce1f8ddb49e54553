# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Fitted sizes beside the true ones, where the truth's form is the same formula as ours."""
from __future__ import annotations

from test.truth import Campaign

from hst_drive.diagnose.result import Diagnosis
from hst_drive.rig import Rig

# Effect: (form of the truth, our parameter, its value from the truth's numbers, factors of the
# unit among them, and the rig).
SAME = {
    'leakage_temperature': ('walther', 'exponent', lambda p, rig: p['k_visc']),
    'elastic_leakage': ('cubic_gap', 'stretch', lambda p, rig: p['k_elastic']),
    'pump_leakage': ('laminar', 'conductance', lambda p, rig: p['g_pump']),
    'motor_leakage': ('laminar', 'conductance', lambda p, rig: p['g_motor']),
    'entrained_air': ('polytropic', 'fraction', lambda p, rig: p['air_frac']),
    'compressibility_flow': ('pump_displaced', 'volume_ratio',
                             lambda p, rig: p['c_comp'] * rig.line.bulk_modulus
                             * p['line.bulk_modulus']),
    'prv_cracking': ('linear', 'gradient', lambda p, rig: p['g_crack']),
    'pump_speed_droop': ('linear', 'droop', lambda p, rig: p['droop'] * rig.pump.max_displacement
                         * rig.relief_valve.set_pressure),
    'pump_command_offset': ('constant', 'offset', lambda p, rig: -p['u_offset']),
    'pump_hysteresis': ('play', 'width', lambda p, rig: p['play']),
    'pump_rate_limit': ('hard', 'full_stroke_time',
                        lambda p, rig: rig.pump.max_displacement / p['rate_limit']),
    'bearing_friction': ('tanh', 'coulomb', lambda p, rig: p['t_coul']),
    'stribeck_friction': ('gauss', 'torque', lambda p, rig: p['t_strib']),
    'viscous_drag': ('linear', 'coefficient', lambda p, rig: p['b_visc']),
    'hydrodynamic_drag': ('square', 'coefficient', lambda p, rig: p['b_hydro']),
    'back_pressure': ('constant', 'outlet_pressure', lambda p, rig: p['p_back']),
    'gearbox_loss': ('proportional', 'fraction', lambda p, rig: p['gear_loss']),
    'pressure_sensor_bias': ('constant', 'bias', lambda p, rig: p['p_bias']),
    'speed_sensor_lag': ('first_order', 'time_constant', lambda p, rig: p['speed_lag']),
    'torque_sensor_scale': ('factor', 'gain_error', lambda p, rig: p['torque_scale']),
    'flow_sensor_scale': ('factor', 'gain_error', lambda p, rig: p['flow_scale']),
}


def true_size(effect: str, made: Campaign, rig: Rig) -> float:
    """Return the size (SI) in our formula of an effect that is hidden in the same form."""
    return SAME[effect][2]({**made.truth['scatter'], **made.truth['si_parameters']}, rig)


def sizes(found: Diagnosis, made: Campaign, rig: Rig) -> dict[str, list[float]]:
    """Return value, low, high and truth (SI) of the effects that were hidden and found."""
    values = {}
    for entry in found.effects:
        form, name, _ = SAME.get(entry.id, ('', '', None))
        if form and made.truth['forms'].get(entry.id) == form:
            fitted = entry.parameters[name]
            values[entry.id] = [fitted.value, fitted.low, fitted.high,
                                true_size(entry.id, made, rig)]
    return values
