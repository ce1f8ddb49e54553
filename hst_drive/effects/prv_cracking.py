# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A relief valve that weeps before it opens.

The valve starts to pass oil at a share of its set pressure; from the set pressure on, the rig's
own valve equation takes over.
"""
from hst_drive.effects.base import Effect, Parameter

SHARP = 0.01   # of the set pressure: the shortest way from rest into a straight line


def flow_loss(pump_pressure, relief_pressure, gradient, cracking_ratio, rounding):
    """Return the relief flow below the set pressure, m^3/s: from rest into a straight line."""
    over = max(min(pump_pressure, relief_pressure) - cracking_ratio * relief_pressure, 0.0)
    return gradient * over * over * (1.0 + rounding) / (over + rounding * relief_pressure)


EFFECT = Effect(
    id='prv_cracking',
    title='the relief valve starts to pass oil below its set pressure',
    slot='pump_flow_loss',
    function=flow_loss,
    equation='Q = gradient * x^2*(1 + rounding)/(x + rounding*P_set), '
             'x = P - cracking_ratio*P_set, 0 below',
    parameters=(
        Parameter('gradient', 'm^3/(s.Pa)', 0.0, 1e-10, 3e-12,
                  'relief flow per pressure above the cracking pressure, far above it'),
        Parameter('cracking_ratio', '1', 0.15, 0.98, 0.3,
                  'cracking pressure over set pressure; a valve that leaks from still less on '
                  'acts like a worn pump', neutral=0.3),
        Parameter('rounding', '1', SHARP, 3.0, 0.05,
                  'over set pressure: where the flow has come half-way from a square to a '
                  'straight line over pressure', neutral=SHARP),
    ),
    telltale='Flow is missing above a certain pressure only; below it the drive is as it should '
             'be.',
    source='H. E. Merritt, Hydraulic Control Systems, Wiley 1967, on relief valves: flow in '
           'proportion to the pressure above cracking; J. Watton, Fundamentals of Fluid Power '
           'Control, Cambridge 2009.',
    shows_in=('motor_speed', 'motor_inlet_flow'),
)
