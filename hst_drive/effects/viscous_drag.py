# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Drag of sheared oil films."""
from hst_drive.effects.base import Effect, Parameter


def torque_loss(motor_speed, viscosity_ratio, coefficient, viscosity_share):
    """Return the drag torque that opposes rotation, N.m."""
    return coefficient * abs(motor_speed) * (1.0 + viscosity_share * (viscosity_ratio - 1.0))


EFFECT = Effect(
    id='viscous_drag',
    title='drag in proportion to speed',
    slot='motor_torque_loss',
    function=torque_loss,
    equation='T = coefficient * |w| * (1 + viscosity_share*(nu/nu_0 - 1))',
    parameters=(
        Parameter('coefficient', 'N.m.s/rad', 0.0, 50.0, 0.8,
                  'drag torque per speed at the temperature of the datasheet'),
        Parameter('viscosity_share', '1', 0.0, 1.0, 0.0,
                  'how far it follows the viscosity of the oil: 1 for a film of that oil, 0 where '
                  'the film has a temperature of its own', usual=(0.0, 1.0)),
    ),
    telltale='Pressure is too high in proportion to speed, whatever the load.',
    source='W. E. Wilson, Positive-Displacement Pumps and Fluid Motors, Pitman 1950: viscous '
           'torque loss; H. E. Merritt, Hydraulic Control Systems, Wiley 1967, on torque losses '
           'of pumps and motors.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed'),
    starts=({'viscosity_share': 1.0},),
)
