# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Play between the command and the swash plate."""
from hst_drive.effects.base import Effect, Parameter


def play(width):
    """Return the width of the play, V."""
    return width


EFFECT = Effect(
    id='pump_hysteresis',
    title='play between command and swash plate',
    slot='pump_play',
    function=play,
    equation='u_effective = min(max(u_effective, u - width/2), u + width/2)',
    parameters=(
        Parameter('width', 'V', 0.0, 3.0, 0.35,
                  'full width of the play'),
    ),
    telltale='The same command gives less flow on the way up than on the way down, and small '
             'corrections do nothing.',
    source='Backlash (play) operator: M. A. Krasnoselskii and A. V. Pokrovskii, Systems with '
           'Hysteresis, Springer 1989; hysteresis of proportional controls: M. Jelali and A. '
           'Kroll, Hydraulic Servo-systems, Springer 2003.',
    shows_in=('motor_speed', 'motor_inlet_flow', 'pump_displacement'),
)
