# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Churning: parts that stir the oil in the case."""
from hst_drive.effects.base import Effect, Parameter
from hst_drive.effects.slots import DRILLING_SPEED


def torque_loss(motor_speed, coefficient, exponent):
    """Return the drag torque that opposes rotation, N.m."""
    drag = coefficient * motor_speed * motor_speed
    # The usual exponent without a power, which takes long.
    return drag if exponent == 2.0 else drag * (
        max(abs(motor_speed), 1e-3) / DRILLING_SPEED)**(exponent - 2.0)


EFFECT = Effect(
    id='hydrodynamic_drag',
    title='churning: drag in proportion to speed squared',
    slot='motor_torque_loss',
    function=torque_loss,
    equation='T = coefficient * w^2 * (|w| / (10 rad/s))^(exponent - 2)',
    parameters=(
        Parameter('coefficient', 'N.m.s^2/rad^2', 0.0, 10.0, 0.07,
                  'drag torque per speed squared, at 10 rad/s'),
        Parameter('exponent', '1', 1.6, 2.4, 2.0,
                  'power of the speed: 2 where all is turbulent, less along smooth walls',
                  neutral=2.0, usual=(2.0,)),
    ),
    telltale='Pressure is right at low speed and too high at high speed, with the square of the '
             'speed.',
    source='W. M. J. Schloesser, Mathematical Model for Displacement Pumps and Motors, Hydraulic '
           'Power Transmission 1961; J. Ivantysyn and M. Ivantysynova, Hydrostatic Pumps and '
           'Motors, Akademia Books 2001.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed'),
)
