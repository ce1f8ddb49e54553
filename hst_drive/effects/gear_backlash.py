# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Play of the gear: the load is free for an angle whenever the torque changes its sign.

While the play is passed the hydromotor takes oil and turns, the shaft behind the gear does not.
Over a small band of torque about zero that is a very soft shaft, which keeps the equations
smooth.
"""
import math

from hst_drive.effects.base import Effect, Parameter

FAR = 20.0      # bands of torque: beyond it nothing of the play is left


def twist(pressure, motor_displacement, angle, band):
    """Return how far the hydromotor turns against the shaft per torque, rad/(N.m)."""
    torque = min(abs(pressure) * motor_displacement / band, FAR)
    return 0.5 * angle / (band * math.cosh(torque)**2)


def turned(load_torque, angle, band):
    """Return how far the hydromotor has turned against the shaft behind its gear, rad."""
    return 0.5 * angle * math.tanh(load_torque / band)


EFFECT = Effect(
    id='gear_backlash',
    title='play of the gear',
    slot='gear_twist',
    function=twist,
    also=(('gear_angle', turned),),
    equation='d(angle)/dT = angle/(2*band) / cosh(T/band)^2, T the measured torque or '
             '|P_a - P_b|*D_m',
    parameters=(
        Parameter('angle', 'rad', 0.0, 0.5, 0.02, 'play, at the measured shaft'),
        Parameter('band', 'N.m', 1.0, 5000.0, 20.0,
                  'torque over which it is passed: what the gear drags by itself', neutral=20.0,
                  fixed=True),
    ),
    telltale='Pressure stays low for a moment at each change of the torque sign while oil flows '
             'and the shaft stands; then it jumps.',
    source='M. Nordin and P.-O. Gutman, Controlling mechanical systems with backlash, a survey, '
           'Automatica 38 (2002).',
    shows_in=('line_a_pressure', 'line_b_pressure'),
)
