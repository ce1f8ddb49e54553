# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Gaps of the hydromotor that open under pressure."""
from hst_drive.effects.base import Effect, Parameter


def flow_loss(motor_leakage, pressure, stretch):
    """Return the leakage that the opened gaps add to the table's, m^3/s."""
    return motor_leakage * ((1.0 + stretch * pressure)**3 - 1.0)


EFFECT = Effect(
    id='elastic_leakage',
    title='gaps grow with pressure: motor leakage rises faster than pressure',
    slot='motor_flow_loss',
    function=flow_loss,
    equation='Q = Q_table * ((1 + stretch*P)^3 - 1)',
    parameters=(
        Parameter('stretch', '1/Pa', 0.0, 2e-07, 2.5e-08,
                  'relative growth of the gap height per pressure'),
    ),
    telltale='The hydromotor leaks as its table says at low pressure, and ever more than that as '
             'pressure rises.',
    source='Laminar gap flow goes with the cube of the gap height, and pressure deforms the gap: '
           'J. Ivantysyn and M. Ivantysynova, Hydrostatic Pumps and Motors, Akademia Books 2001.',
    shows_in=('motor_speed', 'case_drain_flow'),
)
