# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A speed reading that is filtered."""
from hst_drive.effects.base import Effect, Parameter


def lag(time_constant, series):
    """Return the first lag of the speed reading, s."""
    return (1.0 - series) * time_constant


def series_lag(time_constant, series):
    """Return the lag of a second filter behind it, s."""
    return series * time_constant


EFFECT = Effect(
    id='speed_sensor_lag',
    title='the speed reading is filtered',
    slot='speed_reading_lag',
    function=lag,
    also=(('speed_reading_series_lag', series_lag),),
    equation='a lag of (1 - series)*time_constant, and one of series*time_constant behind it: '
             'd(reading)/dt = (w - reading)/lag',
    parameters=(
        Parameter('time_constant', 's', 0.0, 3.0, 0.06,
                  'first-order lag of the speed reading, both filters together'),
        Parameter('series', '1', 0.0, 0.5, 0.0,
                  'part of it that is a second filter: an amplifier behind a tachometer, a '
                  'filter of second order'),
    ),
    telltale='Speed follows late and rounded while flow and pressure are on time; steady values '
             'are right.',
    source='First- and second-order instruments: E. O. Doebelin, Measurement Systems, '
           'McGraw-Hill 2003, ch. 3.',
    shows_in=('motor_speed',),
)
