# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A long or narrow hose between the pump outlet and the hydromotor.

Straight hose in laminar flow, and bends, couplings and turbulent flow.
"""
from hst_drive.effects.base import Effect, Parameter
from hst_drive.effects.slots import USUAL_UPSTREAM


def drop(flow, viscosity_ratio, laminar, turbulent, viscosity_share):
    """Return the pressure lost between the pump outlet sensor and the hydromotor, Pa."""
    thicker = 1.0 + viscosity_share * (viscosity_ratio - 1.0)
    return (laminar * thicker + turbulent * abs(flow)) * flow


def place(laminar, turbulent, upstream_share):
    """Return by how much more than usual of the line's volume lies before the resistance."""
    return upstream_share - USUAL_UPSTREAM if laminar > 0.0 or turbulent > 0.0 else 0.0


EFFECT = Effect(
    id='line_loss',
    title='pressure drop between the pump outlet sensor and the motor inlet',
    slot='line_drop',
    function=drop,
    also=(('line_upstream_share', place),),
    equation='dP = laminar*(1 + viscosity_share*(nu/nu_0 - 1))*Q + turbulent*Q*|Q|, '
             'upstream_share of the volume before it',
    parameters=(
        Parameter('laminar', 'Pa.s/m^3', 0.0, 2e10, 3.6e8,
                  'resistance of the straight hose (Hagen-Poiseuille)'),
        Parameter('turbulent', 'Pa.s^2/m^6', 0.0, 2e14, 2.9e12,
                  'resistance of bends and couplings'),
        Parameter('viscosity_share', '1', 0.0, 1.0, 0.0,
                  'how far the first follows the viscosity of the oil: 1 where the hose is as '
                  'warm as the oil', usual=(0.0, 1.0)),
        Parameter('upstream_share', '1', 0.0, 1.0, USUAL_UPSTREAM,
                  'part of the oil that lies before the resistance: what flows through that is '
                  'what the pump delivers, less what this part takes up',
                  neutral=USUAL_UPSTREAM, whole_drive=True),
    ),
    telltale='Pump pressure is too high by an amount that grows with flow, whatever the load; a '
             'second pressure sensor at the hydromotor reads less.',
    source='H. E. Merritt, Hydraulic Control Systems, Wiley 1967, ch. 3: laminar and turbulent '
           'flow in pipes, minor losses.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure'),
    starts=({'viscosity_share': 1.0},),
)
