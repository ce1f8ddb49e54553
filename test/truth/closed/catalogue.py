# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The physics that can be hidden in these campaigns, with forms, typical sizes and what shows it.

Typical sizes are in shares of the rig's rated flow Q, pressure P (200 bar), speed W and torque T;
`unit` of a parameter says by which product of these it is multiplied.
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
        flow, torque, pump_actuator, load or sensor.
    forms : tuple of str
        Functional forms; the first one is the usual textbook form.
    typical : dict
        Parameter to (share, unit) at relative size 1; it grows with the size.
    fixed : dict
        Parameters to (share, unit) that the size does not scale.
    depends_on : tuple of str
        Channels that the missing term depends on.
    needs : tuple of str
        Channels without which the effect cannot be seen.
    inverse : bool
        The typical parameters are divided by the size (a lower limit is more effect).
    warm : bool
        Shows only where the oil temperature varies.

    """

    enters: str
    forms: tuple[str, ...]
    typical: dict[str, tuple[float, str]]
    depends_on: tuple[str, ...]
    needs: tuple[str, ...] = ()
    fixed: dict[str, tuple[float, str]] | None = None
    inverse: bool = False
    warm: bool = False


def _e(enters: str, forms: str, typical: dict, depends_on: str, needs: str = '',
       **more) -> Effect:
    return Effect(enters, tuple(forms.split()), typical, tuple(depends_on.split()),
                  tuple(needs.split()), **more)


A, B, C, W = 'line_a_pressure', 'line_b_pressure', 'charge_pressure', 'motor_speed'
U, T, M, D = 'pump_command', 'oil_temperature', 'motor_torque', 'pump_displacement'
V = 'valve_command'

_BOTH = {
    'motor_leakage': _e('flow', 'laminar mixed speed_dependent', {'g_motor': (0.02, 'Q/P')},
                        f'{A} {B}'),
    'motor_orifice_leakage': _e('flow', 'orifice power', {'g_orifice': (0.02, 'Q/P')},
                                f'{A} {B}'),
    'bearing_friction': _e('torque', 'tanh load_dependent atan', {'t_coul': (0.04, 'T')}, W, M),
    'stribeck_friction': _e('torque', 'exponential gauss lorentz', {'t_strib': (0.05, 'T')}, W, M,
                            fixed={'w_strib': (0.12, 'W')}),
    'viscous_drag': _e('torque', 'linear power', {'b_visc': (0.06, 'T/W')}, W, M),
    'hydrodynamic_drag': _e('torque', 'square threshold', {'b_hydro': (0.07, 'T/WW')}, W, M),
    'constant_torque': _e('torque', 'sensor_zero hanging', {'t_const': (0.03, 'T')}, W, M),
    'gearbox_loss': _e('load', 'proportional with_speed', {'gear_loss': (0.04, '1')}, f'{A} {B}',
                       M),
    'pressure_sensor_bias': _e('sensor', 'constant with_span', {'p_bias': (0.02, 'P')}, A),
    'torque_sensor_scale': _e('sensor', 'factor bent', {'torque_scale': (0.04, '1')}, M, M),
    'speed_sensor_lag': _e('sensor', 'first_order second_order', {'speed_lag': (0.07, '1')}, W),
}

CLOSED: dict[str, Effect] = {
    **_BOTH,
    'pump_leakage': _e('flow', 'laminar mixed orifice', {'g_pump': (0.02, 'Q/P')}, f'{A} {B}'),
    'cross_port_leakage': _e('flow', 'orifice laminar', {'g_cross': (0.02, 'Q/P')}, f'{A} {B}'),
    'charge_pressure_loss': _e('flow', 'relief worn_pump', {'charge_loss': (0.25, '1')},
                               f'{B} {C}'),
    'cross_port_relief_cracking': _e('flow', 'linear quadratic', {'g_crack': (0.06, 'Q/P')},
                                     f'{A} {B}', fixed={'p_crack': (0.55, 'P')}),
    'swash_compliance': _e('pump_actuator', 'proportional shift', {'k_swash': (0.03, '1/P')},
                           f'{A} {B} {U}'),
    'suction_starvation': _e('flow', 'displacement low_pressure', {'starve': (0.07, '1')},
                             f'{U} {B}'),
    'gear_backlash': _e('torque', 'gap soft_gap', {'play': (0.12, '1')}, W, M),
    'pump_command_offset': _e('pump_actuator', 'constant wide_dead_band', {'u_offset': (0.2, '1')},
                              U),
    'pump_hysteresis': _e('pump_actuator', 'play bouc_wen', {'u_play': (0.35, '1')}, U),
    'pump_lag': _e('pump_actuator', 'first_order second_order', {'extra_lag': (0.12, '1')}, U),
    'pump_rate_limit': _e('pump_actuator', 'hard soft asymmetric', {'rate_limit': (0.8, '1')}, U,
                          inverse=True),
    'pump_speed_droop': _e('flow', 'linear induction', {'droop': (0.03, '1')}, f'{A} {B} {U}'),
    'entrained_air': _e('flow', 'polytropic isothermal henry', {'air': (0.02, '1')}, f'{A} {B}'),
    'compressibility_flow': _e('flow', 'displaced dead_volume', {'c_comp': (0.025, '1/P')},
                               f'{A} {B} {U}'),
    'leakage_temperature': _e('flow', 'walther reynolds vogel', {'k_visc': (1.0, '1')},
                              f'{T} {A} {B}', T, warm=True),
    'elastic_leakage': _e('flow', 'cubic_gap quadratic', {'k_elastic': (0.4, '1/P')}, f'{A} {B}'),
    'line_loss': _e('torque', 'laminar_turbulent blasius',
                    {'r_lam': (0.01, 'P/Q'), 'r_turb': (0.02, 'P/QQ')}, W, M),
    'accumulator': _e('flow', 'isothermal polytropic', {'gas': (2.0, 'C')}, A,
                      fixed={'precharge': (0.3, 'P')}),
}

VALVE: dict[str, Effect] = {
    **_BOTH,
    'valve_dead_band': _e('pump_actuator', 'symmetric one_sided', {'u_dead': (0.3, '1')}, V),
    'valve_lag': _e('pump_actuator', 'first_order second_order', {'extra_lag': (0.05, '1')}, V),
    'back_pressure': _e('torque', 'constant flow_dependent', {'p_back': (0.04, 'P')}, f'{A} {B}'),
    'cross_port_leakage': CLOSED['cross_port_leakage'],
    'entrained_air': CLOSED['entrained_air'],
    'leakage_temperature': CLOSED['leakage_temperature'],
    'elastic_leakage': CLOSED['elastic_leakage'],
    'accumulator': CLOSED['accumulator'],
    'gear_backlash': CLOSED['gear_backlash'],
}

_OUTSIDE_BOTH = {
    'missing_pulses': _e('sensor', 'linear', {'miss': (0.05, '1')}, W,
                         fixed={'w_miss': (0.35, 'W')}),
    'bent_shaft': _e('torque', 'once twice', {'t_angle': (0.05, 'T')}, W, M),
    'one_way_drag': _e('torque', 'reverse forward', {'t_oneway': (0.06, 'T')}, W, M),
    'temperature_friction': _e('torque', 'exponential linear', {'t_warm': (0.05, 'T')}, T, M,
                               warm=True),
}

CLOSED_OUTSIDE: dict[str, Effect] = {
    **_OUTSIDE_BOTH,
    'sticking_check_valve': _e('flow', 'late_opening', {'check_stick': (0.045, 'P')}, f'{B} {C}'),
    'leaking_check_valve': _e('flow', 'orifice', {'g_check': (0.02, 'Q/P')}, f'{A} {C}'),
    'flushing_temperature': _e('flow', 'linear', {'flush_warm': (0.06, '1')}, f'{T} {B}',
                               warm=True),
    'servo_supply': _e('pump_actuator', 'charge load', {'servo_load': (1.5, '1')}, f'{U} {A} {C}'),
    'asymmetric_servo': _e('pump_actuator', 'reverse forward', {'servo_gain': (0.05, '1')}, U),
}

VALVE_OUTSIDE: dict[str, Effect] = {
    **_OUTSIDE_BOTH,
    'spool_stiction': _e('pump_actuator', 'stick', {'u_stick': (0.5, '1')}, V),
    'supply_sag': _e('flow', 'linear', {'sag': (0.15, 'P/Q')}, f'{V} {A}'),
}

LISTED = {'closed': CLOSED, 'valve': VALVE}
OUTSIDE = {'closed': CLOSED_OUTSIDE, 'valve': VALVE_OUTSIDE}
EVERY = [*LISTED.values(), *OUTSIDE.values()]


# hidden physics that looks the same unless one of these channels is measured
LOOK_ALIKE = (
    (('motor_leakage', 'pump_leakage', 'cross_port_leakage'), ('case_drain_flow',)),
    (('pump_leakage', 'cross_port_leakage'), ('charge_pressure',)),
    (('motor_orifice_leakage', 'cross_port_leakage'), ('case_drain_flow',)),
    (('swash_compliance', 'compressibility_flow'), ('pump_displacement', 'pump_torque')),
    (('suction_starvation', 'swash_compliance', 'pump_speed_droop', 'compressibility_flow'),
     ('pump_displacement',)),
    (('line_loss', 'viscous_drag', 'hydrodynamic_drag'), ()),
    (('pressure_sensor_bias', 'constant_torque'), ()),
    (('gearbox_loss', 'torque_sensor_scale'), ()),
)


def look_alikes(circuit: str, ident: str, channels: list[str]) -> list[str]:
    """Return what the maker would accept beside `ident` where these channels are measured."""
    found = {other for group, separate in LOOK_ALIKE if ident in group
             and not set(separate) & set(channels) for other in group}
    return sorted((found - {ident}) & set(LISTED[circuit]))


def blank() -> dict[str, float]:
    """Return every parameter and form of every effect at its neutral value."""
    flat = {}
    for group in EVERY:
        for ident, effect in group.items():
            flat[f'f_{ident}'] = 0.0
            flat.update(dict.fromkeys([*effect.typical, *(effect.fixed or {})], 0.0))
    return flat


def resolve(circuit: str, sizes: dict[str, float], rng, scale: dict[str, float],
            forms: dict[str, str] | None = None) -> dict[str, dict]:
    """
    Turn {id: relative size} into forms and SI parameters of a rig.

    `scale` has Q (m^3/s), P (Pa), W (rad/s), T (N m) and C (m^3/Pa). A form that is not given
    is drawn with `rng`.
    """
    known = {**LISTED[circuit], **OUTSIDE[circuit]}
    chosen = {}
    for ident, size in sizes.items():
        if ident not in known:
            raise SystemExit(f'no effect {ident!r} for {circuit}; there are {", ".join(known)}')
        effect = known[ident]
        form = effect.forms[int(rng.integers(len(effect.forms)))]
        form = (forms or {}).get(ident, form)
        power = -1 if effect.inverse else 1
        values = {k: share * size ** power * _scale(unit, scale)
                  for k, (share, unit) in effect.typical.items()}
        values.update({k: share * _scale(unit, scale)
                       for k, (share, unit) in (effect.fixed or {}).items()})
        chosen[ident] = {'size': size, 'form': form, 'si_parameters': values,
                         'enters': effect.enters, 'depends_on': list(effect.depends_on)}
    return chosen


def _scale(unit: str, scale: dict[str, float]) -> float:
    above, _, below = unit.partition('/')
    value = 1.0
    for letter in above.replace('1', ''):
        value *= scale[letter]
    for letter in below:
        value /= scale[letter]
    return value
