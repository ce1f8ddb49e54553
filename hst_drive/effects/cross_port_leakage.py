# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Oil that passes from line to line: a flushing valve, a cross-port relief, a worn valve plate.

Unlike what leaks into a case it does not leave the circuit: the charge pump need not replace it.
"""
from hst_drive.effects.base import Effect, Parameter


REFERENCE = 1e7     # Pa


def flow(pressure, viscosity_ratio, conductance, viscosity_share, exponent):
    """Return the flow from the high line to the low one, m^3/s."""
    through = conductance * REFERENCE * (max(pressure, 0.0) / REFERENCE)**exponent
    return through / (1.0 + viscosity_share * (viscosity_ratio - 1.0))


EFFECT = Effect(
    id='cross_port_leakage',
    title='oil passes from line to line',
    slot='cross_port_flow',
    function=flow,
    equation='Q = conductance * 100 bar * (|P_a - P_b| / 100 bar)^exponent / '
             '(1 + viscosity_share*(nu/nu_0 - 1))',
    parameters=(
        Parameter('conductance', 'm^3/(s.Pa)', 0.0, 2e-10, 4e-12,
                  'flow per pressure difference, at 100 bar'),
        Parameter('viscosity_share', '1', 0.0, 1.0, 0.0,
                  'how far it follows the viscosity of the oil: 1 through a narrow gap',
                  usual=(0.0, 1.0)),
        Parameter('exponent', '1', 0.5, 1.0, 1.0, 'power of the pressure difference: 1 through a '
                  'gap, 0.5 through an orifice', neutral=1.0, usual=(1.0, 0.5)),
    ),
    starts=({'exponent': 0.5},),
    telltale='Speed falls with load in both directions; case drains and the charge supply are as '
             'they should be.',
    source='N. D. Manring, Fluid Power Pumps and Motors, McGraw-Hill 2013: internal leakage '
           'across a valve plate; laminar gap flow; orifice equation: H. E. Merritt, Hydraulic '
           'Control Systems, Wiley 1967, ch. 3.',
    shows_in=('line_a_pressure', 'line_b_pressure'),
)
