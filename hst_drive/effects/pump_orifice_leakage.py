# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Wear of the pump that acts like an orifice: a nick or an edge instead of a gap.

In logs of a whole drive and of other circuits ``pump_leakage`` has an exponent for it; the two
are told apart in logs of a part, where pressure spans far enough.
"""
from hst_drive.effects.base import Effect, Parameter

REFERENCE = 1e7     # Pa


def flow_loss(pump_pressure, flow_at_100_bar):
    """Return the additional turbulent leakage of the pump, m^3/s."""
    return flow_at_100_bar * (max(pump_pressure, 0.0) / REFERENCE)**0.5


EFFECT = Effect(
    id='pump_orifice_leakage',
    title='the pump leaks more than its table, as through an orifice',
    slot='pump_flow_loss',
    function=flow_loss,
    equation='Q = flow_at_100_bar * sqrt(P / 100 bar)',
    parameters=(
        Parameter('flow_at_100_bar', 'm^3/s', 0.0, 3e-4, 1.3e-5,
                  'additional turbulent leakage at 100 bar'),
    ),
    telltale='Flow is missing in proportion to the root of pressure: most of it is gone at low '
             'pressure already.',
    source='Orifice equation: H. E. Merritt, Hydraulic Control Systems, Wiley 1967, ch. 3; '
           'turbulent slip of pumps: W. M. J. Schloesser, Ein mathematisches Modell fuer '
           'Verdraengerpumpen und -motoren, Oelhydraulik und Pneumatik 5, 1961.',
    shows_in=('motor_speed', 'motor_inlet_flow'),
    searched='parts',
    form_of=('pump_leakage', 'exponent'),
)
