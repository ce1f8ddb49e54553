# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A cross-port relief that opens below its set pressure."""
from hst_drive.effects.base import Effect, Parameter


def flow(pressure, cross_port_pressure, gradient, cracking_ratio):
    """Return what passes below the set pressure, m^3/s; above it the valve's own law goes on."""
    over = min(pressure, cross_port_pressure) - cracking_ratio * cross_port_pressure
    return gradient * max(over, 0.0)


EFFECT = Effect(
    id='cross_port_relief_cracking',
    title='a cross-port relief opens below its set pressure',
    slot='cross_port_flow',
    function=flow,
    equation='Q = gradient * max(|P_a - P_b| - cracking_ratio*P_set, 0) up to P_set',
    parameters=(
        Parameter('gradient', 'm^3/(s.Pa)', 0.0, 1e-9, 3e-11,
                  'flow per pressure above the cracking pressure'),
        Parameter('cracking_ratio', '1', 0.1, 0.98, 0.4, 'cracking pressure over set pressure',
                  neutral=0.4),
    ),
    telltale='Speed is missing above a certain pressure difference only; below it the drive is as '
             'it should be.',
    source='H. E. Merritt, Hydraulic Control Systems, Wiley 1967, on relief valves: flow in '
           'proportion to the pressure above cracking.',
    shows_in=('line_a_pressure', 'line_b_pressure'),
    starts=({'cracking_ratio': 0.25}, {'cracking_ratio': 0.6}),
)
