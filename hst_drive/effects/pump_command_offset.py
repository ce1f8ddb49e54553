# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A displacement curve that lies elsewhere along the command axis."""
from hst_drive.effects.base import Effect, Parameter


def shift(offset):
    """Return what is added to the pump command, V."""
    return offset


EFFECT = Effect(
    id='pump_command_offset',
    title='the displacement curve is shifted along the command axis',
    slot='pump_command',
    function=shift,
    equation='u_effective = u + offset',
    parameters=(
        Parameter('offset', 'V', -3.0, 3.0, 0.12,
                  'added to the pump command; negative: a wider dead band'),
    ),
    telltale='Replayed commands give a speed that is off by the same amount everywhere above the '
             'dead band; the controller hides it.',
    source='Null shift and dead band of proportional controls: M. Jelali and A. Kroll, Hydraulic '
           'Servo-systems, Springer 2003.',
    shows_in=('motor_speed', 'motor_inlet_flow', 'pump_displacement'),
)
