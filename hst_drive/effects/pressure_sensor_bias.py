# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A pressure sensor whose zero has moved."""
from hst_drive.effects.base import Effect, Parameter


def error(bias):
    """Return what is added to the pressure reading, Pa."""
    return bias


EFFECT = Effect(
    id='pressure_sensor_bias',
    title='the pressure reading is off by a constant',
    slot='pressure_reading',
    function=error,
    equation='reading = P + bias',
    parameters=(
        Parameter('bias', 'Pa', -3e6, 3e6, 2e5,
                  'reading minus true pump outlet pressure'),
    ),
    telltale='The pressure reading is off by the same amount always, at standstill as well.',
    source='Zero-measured output, the constant part of a sensor error: IEC 61298-2; E. O. '
           'Doebelin, Measurement Systems, McGraw-Hill 2003.',
    shows_in=('pump_outlet_pressure',),
    alike=('back_pressure', 'bearing_friction'),
    gauge='a calibrated gauge beside the pressure sensor',
    zero_of=('pump_outlet_pressure', 'line_a_pressure'),
)
