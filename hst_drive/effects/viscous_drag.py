# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Drag of sheared oil films."""
from hst_drive.effects.base import Effect, Parameter


def torque_loss(motor_speed, coefficient):
    """Return the drag torque that opposes rotation, N.m."""
    return coefficient * abs(motor_speed)


EFFECT = Effect(
    id='viscous_drag',
    title='drag in proportion to speed',
    slot='motor_torque_loss',
    function=torque_loss,
    equation='T = coefficient * |w|',
    parameters=(
        Parameter('coefficient', 'N.m.s/rad', 0.0, 50.0, 0.8,
                  'drag torque per speed'),
    ),
    telltale='Pressure is too high in proportion to speed, whatever the load.',
    source='W. E. Wilson, Positive-Displacement Pumps and Fluid Motors, Pitman 1950: viscous '
           'torque loss; H. E. Merritt, Hydraulic Control Systems, Wiley 1967, on torque losses '
           'of pumps and motors.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed'),
)
