# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Wear of the pump: leakage beyond its table.

Laminar through gaps, turbulent through nicks and edges, and on a real pump something between.
"""
from hst_drive.effects.base import Effect, OIL_POWER, Parameter

REFERENCE = 7e6     # Pa: about where a drive works, so that size and exponent are told apart


def flow_loss(pump_pressure, viscosity_ratio, conductance, exponent, oil_power,
              oil_viscosity_ratio):
    """Return the additional leakage of the pump, m^3/s."""
    if oil_power > 0.0:
        conductance = conductance * (oil_viscosity_ratio / viscosity_ratio)**oil_power
    if exponent == 1.0:
        return conductance * pump_pressure
    return conductance * REFERENCE * (max(pump_pressure, 0.0) / REFERENCE)**exponent


EFFECT = Effect(
    id='pump_leakage',
    title='the pump leaks more than its table: wear',
    slot='pump_flow_loss',
    function=flow_loss,
    equation='Q = conductance * 70 bar * (P / 70 bar)^exponent * '
             '(oil_viscosity_ratio / (nu/nu_0))^oil_power',
    parameters=(
        Parameter('conductance', 'm^3/(s.Pa)', 0.0, 3e-11, 1.3e-12,
                  'additional leakage over pressure, at 70 bar'),
        Parameter('exponent', '1', 0.35, 1.65, 1.0,
                  'power of the pressure: 1 laminar, 0.5 like an orifice', neutral=1.0,
                  whole_drive=True, usual=(1.0, 0.5)),
        *OIL_POWER,
    ),
    telltale='The flow meter reads less than the pump should give, in proportion to pressure and '
             'whatever the stroke; the hydromotor turns what the meter reads.',
    source='W. E. Wilson, Positive-Displacement Pumps and Fluid Motors, Pitman 1950: slip flow '
           'in proportion to pressure over viscosity; turbulent slip: W. M. J. Schloesser, Ein '
           'mathematisches Modell fuer Verdraengerpumpen und -motoren, Oelhydraulik und '
           'Pneumatik 5, 1961.',
    shows_in=('motor_speed', 'motor_inlet_flow'),
)
