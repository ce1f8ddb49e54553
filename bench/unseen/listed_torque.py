# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Listed effects by which torque goes elsewhere, in the motor, on the shaft and in the load.

Friction: Olsson et al., Eur. J. Control 4 (1998), Armstrong-Helouvry (1994); drag: Jeong,
Tribology Int. 40 (2007). Lines: Hagen-Poiseuille, Blasius, Borda-Carnot. Gears: load-dependent and
no-load losses, ISO/TR 14179. Shaft: a spring that may harden.
"""
from bench.unseen.fault import Fault

TORQUE = (
    Fault('bearing_friction', 'torque', 'pump_outlet_pressure', 'friction_torque', 'N.m',
          0.001, 0.2, (
              ('coulomb', lambda s, r, c: (s * c.torque, {'coulomb': s * c.torque})),
              ('loaded', lambda s, r, c: (0.6 * s * c.torque, {
                  'coulomb': 0.6 * s * c.torque, 'coulomb_load': 0.6 * s})),
          ), 'A dry bearing of the motor.',
          {'coulomb': ('back_pressure', 'pressure_sensor_bias', 'constant_torque')}),
    Fault('stribeck_friction', 'torque', 'pump_outlet_pressure', 'breakaway_torque', 'N.m',
          0.002, 0.6, (
              ('gauss', lambda s, r, c: (s * c.torque, {'stribeck_gauss': s * c.torque,
                                                        'stribeck_speed': r(2, 6)})),
              ('exponential', lambda s, r, c: (s * c.torque, {'stribeck_exp': s * c.torque,
                                                              'stribeck_speed': r(1.5, 4)})),
              ('hill', lambda s, r, c: (s * c.torque, {'stribeck_hill': s * c.torque,
                                                       'stribeck_speed': r(1.5, 4)})),
          ), 'Friction at low speed that a film of oil takes away.', {}),
    Fault('viscous_drag', 'torque', 'pump_outlet_pressure', 'drag', 'N.m.s/rad', 0.001, 0.3, (
        ('linear', lambda s, r, c: (s * c.torque / c.speed, {'viscous': s * c.torque / c.speed})),
        ('thinning', lambda s, r, c: (s * c.torque / c.speed, {
            'viscous': s * c.torque / c.speed, 'viscous_bend': r(0.005, 0.03)})),
    ), 'Drag in proportion to speed.', {'linear': ('line_loss',)}),
    Fault('hydrodynamic_drag', 'torque', 'pump_outlet_pressure', 'drag', 'N.m.s^2/rad^2',
          0.001, 0.3, (
              ('square', lambda s, r, c: (s * c.torque / c.speed ** 2, {
                  'churning': s * c.torque / c.speed ** 2})),
              ('power', lambda s, r, c: (s * c.torque / c.speed ** 2, {
                  'churning': s * c.torque / c.speed ** 1.8, 'churning_power': 1.8})),
          ), 'The motor churns the oil in its case.', {'': ('line_loss',)}),
    Fault('line_loss', 'torque', 'pump_outlet_pressure', 'drop_at_reference_flow', 'Pa',
          0.001, 0.25, (
              ('both', lambda s, r, c: (s * c.pressure, {
                  'line_laminar': 0.4 * s * c.pressure / c.flow,
                  'line_turbulent': 0.6 * s * c.pressure / c.flow ** 2})),
              ('blasius', lambda s, r, c: (s * c.pressure, {
                  'line_blasius': s * c.pressure / c.flow ** 1.75})),
              ('turbulent', lambda s, r, c: (s * c.pressure, {
                  'line_turbulent': s * c.pressure / c.flow ** 2})),
          ), 'A thin or kinked line between pump and motor.',
          {'blasius': ('hydrodynamic_drag',), 'turbulent': ('hydrodynamic_drag',)}),
    Fault('back_pressure', 'torque', 'pump_outlet_pressure', 'return_pressure', 'Pa',
          0.001, 0.25, (
              ('constant', lambda s, r, c: (s * c.pressure, {'return_pressure': s * c.pressure})),
              ('filter', lambda s, r, c: (s * c.pressure, {
                  'return_pressure': 0.6 * s * c.pressure,
                  'return_square': 0.4 * s * c.pressure / c.speed ** 2})),
          ), 'The return line of the motor is under pressure.',
          {'constant': ('bearing_friction', 'pressure_sensor_bias', 'constant_torque')}),
    Fault('piston_ripple', 'torque', 'motor_speed', 'ripple', '1', 0.001, 0.6, (
        ('sine', lambda s, r, c: (s, {'ripple': s, 'pistons': float(round(r(4.5, 9.5)))})),
        ('rectified', lambda s, r, c: (s, {'ripple': s, 'ripple_rectified': 1.0,
                                           'pistons': float(round(r(2.5, 4.5)))})),
    ), 'The pistons give their torque in turns.', {}, 0.01),
    Fault('shaft_compliance', 'torque', 'motor_speed', 'compliance', 'rad/(N.m)', 0.005, 8, (
        ('spring', lambda s, r, c: (s / (1500 * c.inertia), _shaft(s, r, c, 0.0))),
        ('hardening', lambda s, r, c: (s / (1500 * c.inertia), _shaft(s, r, c, r(0.3, 1.5)))),
    ), 'A long rod between the motor and the load twists.', {}, 0.01),
    Fault('gearbox_loss', 'load', 'load_torque', 'share', '1', 0.001, 0.3, (
        ('share', lambda s, r, c: (s, {'gear_share': s})),
        ('seals', lambda s, r, c: (0.7 * s, {'gear_share': 0.7 * s,
                                             'gear_torque': 0.25 * s * c.torque})),
        ('speed', lambda s, r, c: (0.6 * s, {'gear_share': 0.6 * s,
                                             'gear_share_speed': 0.04 * s})),
    ), 'The gear takes its share of the torque.', {}),
    Fault('constant_torque', 'torque', 'load_torque', 'torque', 'N.m', 0.001, 0.2, (
        ('zero_of_sensor', lambda s, r, c: (s * c.torque, {'sensor.torque_zero': s * c.torque})),
        ('zero_of_sensor_below', lambda s, r, c: (-s * c.torque, {
            'sensor.torque_zero': -s * c.torque})),
        ('hanging', lambda s, r, c: (s * c.torque, {'hanging': s * c.torque})),
    ), 'A torque that does not ask for the direction of rotation.',
          {'hanging': ('gearbox_loss',)}),
)


def _shaft(s, r, c, hardening: float) -> dict:
    """Return a shaft whose compliance is `s` and zero for a rigid one."""
    share = r(0.35, 0.65)
    if s == 0:
        return {}
    stiffness = 1500 * c.inertia / s
    reduced = c.inertia * share * (1 - share)
    return {'shaft_stiffness': stiffness,
            'shaft_hardening': hardening * (stiffness / c.torque) ** 2,
            'motor_share': share,
            'shaft_damping': 2 * r(0.05, 0.2) * (stiffness * reduced) ** 0.5}
