# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A speed reading that is filtered."""
from hst_drive.effects.base import Effect, Parameter


def lag(time_constant):
    """Return the time constant of the speed reading, s."""
    return time_constant


EFFECT = Effect(
    id='speed_sensor_lag',
    title='the speed reading is filtered',
    slot='speed_reading_lag',
    function=lag,
    equation='d(reading)/dt = (w - reading)/time_constant',
    parameters=(
        Parameter('time_constant', 's', 0.0, 3.0, 0.06,
                  'first-order lag of the speed reading'),
    ),
    telltale='Speed follows late and rounded while flow and pressure are on time; steady values '
             'are right.',
    source='First-order instrument: E. O. Doebelin, Measurement Systems, McGraw-Hill 2003, ch. 3.',
    shows_in=('motor_speed',),
)
