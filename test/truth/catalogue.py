# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The physics that can be hidden in a campaign: identifiers, functional forms and typical sizes.

Every effect has at least two forms, so that a fit is tried with a form that is not the one that
made the data. A relative size of 1 is the typical size: clearly visible, not silly.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Effect:
    """
    One kind of hidden physics.

    Attributes
    ----------
    enters : str
        Balance that it enters: flow, torque, pump_actuator, load or sensor.
    forms : tuple of str
        Functional forms; the first one is the usual textbook form.
    typical : dict
        Parameter name to its value in SI units at relative size 1 (times the relative size).
    fixed : dict
        Parameters that the size does not scale.
    depends_on : tuple of str
        Measured channels that the missing term depends on.
    inverse : tuple of str
        Parameters that are divided by the size instead (limits: a lower limit is more effect).

    """

    enters: str
    forms: tuple[str, ...]
    typical: dict[str, float]
    fixed: dict[str, float]
    depends_on: tuple[str, ...]
    inverse: tuple[str, ...] = ()


def _e(enters: str, forms: str, typical: dict[str, float], depends_on: str,
       fixed: dict[str, float] | None = None, inverse: tuple[str, ...] = ()) -> Effect:
    return Effect(enters, tuple(forms.split()), typical, fixed or {},
                  tuple(depends_on.split()), inverse)


P, W, U, T = 'pump_outlet_pressure', 'motor_speed', 'pump_command', 'oil_temperature'
V, L, Q = 'pprv_command', 'load_torque', 'motor_inlet_flow'

EFFECTS: dict[str, Effect] = {
    'leakage_temperature': _e('flow', 'walther reynolds vogel', {'k_visc': 1.0}, f'{T} {P}'),
    'elastic_leakage': _e('flow', 'cubic_gap quadratic', {'k_elastic': 2.5e-8}, P),
    'pump_leakage': _e('flow', 'laminar orifice mixed', {'g_pump': 4 / 3 * 1e-12}, P),
    'motor_leakage': _e('flow', 'laminar speed_dependent mixed', {'g_motor': 4 / 3 * 1e-12}, P),
    'entrained_air': _e('flow', 'polytropic isothermal henry', {'air_frac': 0.015}, P),
    'compressibility_flow': _e('flow', 'pump_displaced pump_dead_volume', {'c_comp': 2.8e-9},
                               f'{P} {U}'),
    'prv_cracking': _e('flow', 'linear quadratic', {'g_crack': 3.0e-12}, P,
                       {'p_crack': 60e5}),
    'pump_speed_droop': _e('flow', 'linear induction', {'droop': 1.0e-3}, f'{P} {U}'),
    'pump_command_offset': _e('pump_actuator', 'constant wide_dead_band', {'u_offset': 0.12}, U),
    'pump_hysteresis': _e('pump_actuator', 'play bouc_wen prandtl', {'play': 0.35}, U),
    'pump_rate_limit': _e('pump_actuator', 'hard soft asymmetric', {'rate_limit': 2.4e-6}, U,
                          inverse=('rate_limit',)),
    'pump_lag': _e('pump_actuator', 'first_order second_order', {'extra_lag': 0.08}, U),
    'bearing_friction': _e('torque', 'tanh load_dependent atan', {'t_coul': 12.0}, W),
    'stribeck_friction': _e('torque', 'exponential gauss lorentz', {'t_strib': 14.0}, W,
                            {'w_strib': 4.0}),
    'viscous_drag': _e('torque', 'linear power', {'b_visc': 0.8}, W),
    'hydrodynamic_drag': _e('torque', 'square threshold', {'b_hydro': 0.07}, W),
    'line_loss': _e('torque', 'laminar_turbulent blasius',
                    {'r_lam': 3.6e8, 'r_turb': 2.88e12}, Q),
    'back_pressure': _e('torque', 'constant flow_dependent', {'p_back': 4e5}, W),
    'piston_ripple': _e('torque', 'sine rectified', {'ripple': 0.02}, P, {'pistons': 7.0}),
    'shaft_compliance': _e('torque', 'linear hardening', {'stiffness': 320.0}, L,
                           {'shaft_damping': 0.9, 'shaft_share': 0.6}, inverse=('stiffness',)),
    'gearbox_loss': _e('load', 'proportional affine', {'gear_loss': 0.06}, L),
    'pressure_sensor_bias': _e('sensor', 'constant with_span', {'p_bias': 2e5}, P),
    'speed_sensor_lag': _e('sensor', 'first_order second_order', {'speed_lag': 0.06}, W),
    'torque_sensor_scale': _e('sensor', 'factor bent', {'torque_scale': 0.05}, L),
    'flow_sensor_scale': _e('sensor', 'factor bent', {'flow_scale': 0.03}, Q),
}

OUTSIDE: dict[str, Effect] = {
    'pprv_stiction': _e('load', 'stick play', {'pprv_stick': 0.35}, V),
    'pprv_creep': _e('load', 'exponential', {'creep': 0.05}, V, {'creep_time': 6.0}),
    'bit_eccentricity': _e('load', 'proportional constant', {'eccentric': 0.10}, f'{L} {W}'),
    'temperature_friction': _e('torque', 'exponential linear', {'t_warm': 9.0}, T),
    'speed_band_drag': _e('torque', 'bell', {'t_band': 12.0}, W,
                          {'w_band': 8.4, 'w_width': 1.2}),
    'command_leakage': _e('flow', 'ramp square', {'g_command': 1.2e-12}, f'{U} {P}'),
    'angle_leakage': _e('flow', 'once twice', {'g_angle': 1.5e-12}, f'{P} {W}'),
    'pump_dead_time': _e('pump_actuator', 'pure', {'dead_time': 0.10}, U),
    'pump_asymmetric_lag': _e('pump_actuator', 'down up', {'lag_ratio': 1.5}, U),
    'pressure_sensor_drift': _e('sensor', 'linear', {'p_drift': 0.12e5}, T),
    'flow_sensor_square': _e('sensor', 'square', {'flow_square': 0.04}, Q),
}

ALL = {**EFFECTS, **OUTSIDE}
# how a typical size goes with the rig's torque, flow and speed (exponents), for other rigs
SCALES = {
    't_coul': (1, 0, 0), 't_strib': (1, 0, 0), 't_warm': (1, 0, 0), 't_band': (1, 0, 0),
    'b_visc': (1, 0, -1), 'b_hydro': (1, 0, -2), 'shaft_damping': (1, 0, -1),
    'stiffness': (1, 0, 0), 'w_strib': (0, 0, 1), 'w_band': (0, 0, 1), 'w_width': (0, 0, 1),
    'g_pump': (0, 1, 0), 'g_motor': (0, 1, 0), 'g_crack': (0, 1, 0), 'g_command': (0, 1, 0),
    'g_angle': (0, 1, 0), 'droop': (0, -1, 0), 'rate_limit': (0, 1, 0), 'r_lam': (0, -1, 0),
    'r_turb': (0, -2, 0),
}
TEMPERATURE = ('leakage_temperature', 'temperature_friction', 'pressure_sensor_drift')


def parameters() -> list[str]:
    """Return the names of all parameters of all effects, in a fixed order."""
    return [name for effect in ALL.values() for name in (*effect.typical, *effect.fixed)]


def resolve(effects: dict, rng, scale: tuple[float, float, float]) -> dict[str, dict]:
    """
    Turn {id: relative size, or {'size', 'form'}} into sizes, forms and SI parameters.

    A form that is not given is drawn with `rng` (numpy Generator). `scale` is the rig's torque,
    flow and speed relative to the test rig's.

    Raises
    ------
    KeyError
        An identifier or form that is not in the catalogue.

    """
    chosen = {}
    for ident, given in effects.items():
        name = ident.removeprefix('unknown:')
        if name not in ALL:
            raise KeyError(f'no effect {name!r}; there are {", ".join(ALL)}')
        effect = ALL[name]
        drawn = effect.forms[int(rng.integers(len(effect.forms)))]
        asked = given if isinstance(given, dict) else {'size': given}
        form = asked.get('form') or drawn
        if form not in effect.forms:
            raise KeyError(f'{name} has no form {form!r}; it has {", ".join(effect.forms)}')
        size = float(asked.get('size', 1.0))
        values = {k: v / size if k in effect.inverse else v * size
                  for k, v in effect.typical.items()}
        values.update(effect.fixed)
        for key in values:
            for base, power in zip(scale, SCALES.get(key, (0, 0, 0))):
                values[key] *= base ** power
        values.update({k: float(v) for k, v in asked.get('parameters', {}).items()})
        chosen[name] = {'size': size, 'form': form, 'si_parameters': values,
                        'enters': effect.enters, 'depends_on': list(effect.depends_on)}
    return chosen
