# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Wear of the hydromotor: leakage beyond its table, laminar and what real gaps make of that."""
from hst_drive.effects.base import Effect, OIL_POWER, Parameter

REFERENCE = 7e6     # Pa: about where a drive works, so that size and exponent are told apart


def flow_loss(pressure, viscosity_ratio, conductance, exponent, oil_power, oil_viscosity_ratio):
    """Return the additional leakage of the hydromotor, m^3/s."""
    if oil_power > 0.0:
        conductance = conductance * (oil_viscosity_ratio / viscosity_ratio)**oil_power
    if exponent == 1.0:
        return conductance * pressure
    return conductance * REFERENCE * (max(pressure, 0.0) / REFERENCE)**exponent


EFFECT = Effect(
    id='motor_leakage',
    title='the hydromotor leaks more than its table: wear',
    slot='motor_flow_loss',
    function=flow_loss,
    equation='Q = conductance * 70 bar * (P / 70 bar)^exponent * '
             '(oil_viscosity_ratio / (nu/nu_0))^oil_power',
    parameters=(
        Parameter('conductance', 'm^3/(s.Pa)', 0.0, 3e-11, 1.3e-12,
                  'additional leakage of the hydromotor over pressure, at 70 bar'),
        Parameter('exponent', '1', 0.65, 1.35, 1.0, 'power of the pressure: 1 laminar',
                  neutral=1.0, whole_drive=True, usual=(1.0,)),
        *OIL_POWER,
    ),
    telltale='The flow meter reads more than the hydromotor turns away, in proportion to '
             'pressure and whatever the speed.',
    source='W. E. Wilson, Positive-Displacement Pumps and Fluid Motors, Pitman 1950: slip flow '
           'in proportion to pressure over viscosity.',
    shows_in=('motor_speed', 'case_drain_flow'),
)
