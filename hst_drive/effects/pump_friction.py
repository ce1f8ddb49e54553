# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Friction of the pump: torque that its shaft takes beyond what the oil gets.

Only logs with the torque or the power at that shaft show it.
"""
from hst_drive.effects.base import Effect, Parameter


def torque_loss(pump_pressure, displacement, coulomb, load_share):
    """Return the friction torque at the pump shaft, N.m."""
    return coulomb + load_share * abs(pump_pressure) * displacement


EFFECT = Effect(
    id='pump_friction',
    title='the pump takes more torque than its sheet says',
    slot='pump_torque_loss',
    function=torque_loss,
    equation='T = coulomb + load_share * |P|*D_p',
    parameters=(
        Parameter('coulomb', 'N.m', 0.0, 500.0, 5.0,
                  'friction torque that does not depend on load'),
        Parameter('load_share', '1', 0.0, 0.5, 0.02,
                  'friction torque over the ideal torque of the pump'),
    ),
    telltale='Shaft torque is too high, by the same amount at any pressure or in proportion to '
             'it, while the flow is what it was.',
    source='W. E. Wilson, Positive-Displacement Pumps and Fluid Motors, Pitman 1950; torque and '
           'efficiency of pumps: ISO 4391, ISO 4409.',
    shows_in=('pump_torque', 'pump_power'),
    searched='parts',
)
