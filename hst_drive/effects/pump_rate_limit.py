# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A swash plate whose control cylinder gets only so much oil."""
from hst_drive.effects.base import Effect, Parameter


def stroke_time(full_stroke_time):
    """Return the shortest time for the full stroke, s."""
    return full_stroke_time


def stroke_asymmetry(full_stroke_time, asymmetry):
    """Return by what share the stroke up is faster than the mean of both ways."""
    return asymmetry if full_stroke_time > 0.0 else 0.0


EFFECT = Effect(
    id='pump_rate_limit',
    title="the swash plate's speed is limited",
    slot='pump_stroke_time',
    function=stroke_time,
    also=(('pump_stroke_asymmetry', stroke_asymmetry),),
    equation='-(1 - asymmetry)*r <= dD_p/dt <= (1 + asymmetry)*r, r = D_max/full_stroke_time',
    parameters=(
        Parameter('full_stroke_time', 's', 0.0, 60.0, 1.8,
                  'shortest time from no to full displacement; 0: no limit'),
        Parameter('asymmetry', '1', -0.8, 0.8, 0.0,
                  'how much faster the plate strokes up than on average: piston areas differ, '
                  'springs help one way'),
    ),
    telltale='After a large step of the command the speed rises on a straight line; small steps '
             'look as they should.',
    source='Saturated control flow of the stroking cylinder: N. D. Manring, Hydraulic Control '
           'Systems, Wiley 2005, on pump control; M. Jelali and A. Kroll, Hydraulic '
           'Servo-systems, Springer 2003.',
    shows_in=('motor_speed', 'motor_inlet_flow', 'pump_displacement'),
)
