# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Wear of the hydromotor: laminar gap flow beyond its leakage table."""
from hst_drive.effects.base import DRILLING_SPEED, Effect, Parameter


def flow_loss(pressure, motor_speed, conductance, with_speed):
    """Return the additional laminar leakage of the hydromotor, m^3/s."""
    return conductance * pressure * (
        1.0 + with_speed * (abs(motor_speed) / DRILLING_SPEED - 1.0))


EFFECT = Effect(
    id='motor_leakage',
    title='the hydromotor leaks more than its table: wear',
    slot='motor_flow_loss',
    function=flow_loss,
    equation='Q = conductance * P * (1 - with_speed + with_speed*|w|/(10 rad/s))',
    parameters=(
        Parameter('conductance', 'm^3/(s.Pa)', 0.0, 3e-11, 1.3e-12,
                  'additional laminar leakage conductance of the hydromotor, at 10 rad/s'),
        Parameter('with_speed', '1', 0.0, 0.5, 0.0,
                  'share of it that goes with the speed: what moving walls drag through the gaps',
                  whole_drive=True, usual=(0.0,)),
    ),
    telltale='The flow meter reads more than the hydromotor turns away, in proportion to '
             'pressure, hardly with the speed.',
    source='W. E. Wilson, Positive-Displacement Pumps and Fluid Motors, Pitman 1950: slip flow '
           'in proportion to pressure over viscosity; what moving walls drag: J. Ivantysyn and '
           'M. Ivantysynova, Hydrostatic Pumps and Motors, Akademia Books 2001.',
    shows_in=('motor_speed', 'case_drain_flow'),
)
