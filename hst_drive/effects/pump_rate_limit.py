# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A swash plate whose control cylinder gets only so much oil."""
from hst_drive.effects.base import Effect, Parameter


def stroke_time(full_stroke_time):
    """Return the shortest time for the full stroke, s."""
    return full_stroke_time


EFFECT = Effect(
    id='pump_rate_limit',
    title="the swash plate's speed is limited",
    slot='pump_stroke_time',
    function=stroke_time,
    equation='|dD_p/dt| <= D_max/full_stroke_time',
    parameters=(
        Parameter('full_stroke_time', 's', 0.0, 60.0, 1.8,
                  'shortest time from no to full displacement; 0: no limit'),
    ),
    telltale='After a large step of the command the speed rises on a straight line; small steps '
             'look as they should.',
    source='Saturated control flow of the stroking cylinder: N. D. Manring, Hydraulic Control '
           'Systems, Wiley 2005, on pump control; M. Jelali and A. Kroll, Hydraulic '
           'Servo-systems, Springer 2003.',
    shows_in=('motor_speed', 'motor_inlet_flow', 'pump_displacement'),
)
