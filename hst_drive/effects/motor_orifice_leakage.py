# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Leakage of the hydromotor through an opening rather than a gap.

A scored port plate, a damaged seal: the flow is turbulent, so oil temperature hardly matters.
"""
from hst_drive.effects.base import Effect, Parameter

REFERENCE = 1e7     # Pa


def flow_loss(pressure, flow_at_100_bar):
    """Return the additional turbulent leakage of the hydromotor, m^3/s."""
    return flow_at_100_bar * (max(pressure, 0.0) / REFERENCE)**0.5


EFFECT = Effect(
    id='motor_orifice_leakage',
    title='the hydromotor leaks more than its table, as through an orifice',
    slot='motor_flow_loss',
    function=flow_loss,
    equation='Q = flow_at_100_bar * sqrt(P / 100 bar)',
    parameters=(
        Parameter('flow_at_100_bar', 'm^3/s', 0.0, 3e-4, 1.3e-5,
                  'additional turbulent leakage at 100 bar'),
    ),
    telltale='The flow meter reads more than the hydromotor turns away, in proportion to the '
             'root of pressure: most of it at low pressure already.',
    source='Orifice equation: H. E. Merritt, Hydraulic Control Systems, Wiley 1967, ch. 3; '
           'turbulent slip of motors: W. M. J. Schloesser, Ein mathematisches Modell fuer '
           'Verdraengerpumpen und -motoren, Oelhydraulik und Pneumatik 5, 1961.',
    shows_in=('motor_speed', 'case_drain_flow'),
)
