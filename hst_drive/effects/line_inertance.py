# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The oil in a long line has mass.

Pressure waves run between pump and hydromotor; the first of them is that of a mass of oil between
two volumes, one at each end. ``inertance`` is density times length over area: 3e7 for 10 m of
20 mm hose.
"""
from hst_drive.effects.base import Effect, Parameter
from hst_drive.effects.slots import USUAL_FAR


def mass(inertance):
    """Return the mass of the oil over the area of the line squared, Pa.s^2/m^3."""
    return inertance


def behind(inertance, far_share):
    """Return what is added to the usual share of the volume behind that mass."""
    return far_share - USUAL_FAR if inertance > 0.0 else 0.0


def decay(inertance, damping):
    """Return how fast a wave dies out, 1/s."""
    return damping if inertance > 0.0 else 0.0


EFFECT = Effect(
    id='line_inertance',
    title='the oil in a long line has mass: pressure waves',
    slot='line_inertance',
    function=mass,
    also=(('line_far_share', behind), ('line_damping', decay)),
    equation='inertance * (dQ/dt + damping * (Q - Q_motor)) = P_pump - P_motor - losses, with '
             'far_share of the volume behind it',
    parameters=(
        Parameter('inertance', 'Pa.s^2/m^3', 0.0, 1e9, 6e7,
                  'density times length over area of the line'),
        Parameter('far_share', '1', 0.05, 0.95, USUAL_FAR,
                  "share of the line's volume that lies behind the mass", neutral=USUAL_FAR),
        Parameter('damping', '1/s', 0.0, 300.0, 20.0,
                  'decay by friction that goes with the change of flow, and by the wall'),
    ),
    telltale='After each step pressure rings by itself, faster than the load with its oil, and '
             'the far end of the line is late.',
    source='Lumped model of a line: H. E. Merritt, Hydraulic Control Systems, Wiley 1967; '
           'friction that depends on frequency: W. Zielke, Frequency-dependent friction in '
           'transient pipe flow, J. Basic Engineering 90 (1968).',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_inlet_flow'),
    starts=({'inertance': 3e8}, {'inertance': 8e6}),
)
