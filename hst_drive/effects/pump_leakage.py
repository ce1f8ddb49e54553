# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Wear of the pump: laminar gap flow beyond its leakage table."""
from hst_drive.effects.base import Effect, Parameter


def flow_loss(pump_pressure, conductance):
    """Return the additional laminar leakage of the pump, m^3/s."""
    return conductance * pump_pressure


EFFECT = Effect(
    id='pump_leakage',
    title='the pump leaks more than its table: wear',
    slot='pump_flow_loss',
    function=flow_loss,
    equation='Q = conductance * P',
    parameters=(
        Parameter('conductance', 'm^3/(s.Pa)', 0.0, 3e-11, 1.3e-12,
                  'additional laminar leakage conductance of the pump'),
    ),
    telltale='The flow meter reads less than the pump should give, in proportion to pressure and '
             'whatever the stroke; the hydromotor turns what the meter reads.',
    source='W. E. Wilson, Positive-Displacement Pumps and Fluid Motors, Pitman 1950: slip flow '
           'in proportion to pressure over viscosity.',
    shows_in=('motor_speed', 'motor_inlet_flow'),
)
