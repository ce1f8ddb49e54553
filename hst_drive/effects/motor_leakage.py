# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Wear of the hydromotor: laminar gap flow beyond its leakage table."""
from hst_drive.effects.base import Effect, Parameter


def flow_loss(pressure, conductance):
    """Return the additional laminar leakage of the hydromotor, m^3/s."""
    return conductance * pressure


EFFECT = Effect(
    id='motor_leakage',
    title='the hydromotor leaks more than its table: wear',
    slot='motor_flow_loss',
    function=flow_loss,
    equation='Q = conductance * P',
    parameters=(
        Parameter('conductance', 'm^3/(s.Pa)', 0.0, 3e-11, 1.3e-12,
                  'additional laminar leakage conductance of the hydromotor'),
    ),
    telltale='The flow meter reads more than the hydromotor turns away, in proportion to '
             'pressure and whatever the speed.',
    source='W. E. Wilson, Positive-Displacement Pumps and Fluid Motors, Pitman 1950: slip flow '
           'in proportion to pressure over viscosity.',
    shows_in=('motor_speed', 'case_drain_flow'),
)
