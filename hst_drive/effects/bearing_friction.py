# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Dry friction of bearings and seals.

A constant part, and a part in proportion to the ideal hydraulic torque, which loads the
bearings.
"""
from hst_drive.effects.base import Effect, Parameter


def torque_loss(pressure, motor_displacement, coulomb, load_share):
    """Return the friction torque that opposes rotation, N.m."""
    return coulomb + load_share * abs(pressure) * motor_displacement


EFFECT = Effect(
    id='bearing_friction',
    title='Coulomb friction, with or without a load-dependent part',
    slot='motor_torque_loss',
    function=torque_loss,
    equation='T = coulomb + load_share * |P|*D_m',
    parameters=(
        Parameter('coulomb', 'N.m', 0.0, 500.0, 12.0,
                  'friction torque that does not depend on load'),
        Parameter('load_share', '1', 0.0, 0.3, 0.01,
                  'friction torque over the ideal hydraulic torque'),
    ),
    telltale='Pressure is too high by the same amount at every speed, and gone when the drive '
             'stands still.',
    source='B. Armstrong-Helouvry, P. Dupont and C. Canudas de Wit, A survey of models, analysis '
           'tools and compensation methods for the control of machines with friction, Automatica '
           '30 (1994); bearing torque with constant and load part: J. Ivantysyn and M. '
           'Ivantysynova, Hydrostatic Pumps and Motors, Akademia Books 2001.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed'),
    alike=('back_pressure', 'pressure_sensor_bias'),
)
