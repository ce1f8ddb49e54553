# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A flow meter with a wrong gain."""
from hst_drive.effects.base import Effect, Parameter


def error(flow, gain_error):
    """Return what is added to the flow reading, m^3/s."""
    return gain_error * flow


EFFECT = Effect(
    id='flow_sensor_scale',
    title='the flow reading is off by a factor',
    slot='flow_reading',
    function=error,
    equation='reading = (1 + gain_error) * Q',
    parameters=(
        Parameter('gain_error', '1', -0.6, 0.6, 0.03,
                  'relative error of the flow reading'),
    ),
    telltale='Measured flow is off in proportion to itself, at every pressure, while the '
             'hydromotor turns as it should.',
    source='Sensitivity error of a sensor: IEC 61298-2; flow measurement of hydraulic machines: '
           'ISO 4409.',
    shows_in=('motor_inlet_flow',),
    gauge='a calibrated flow meter in the same line',
)
