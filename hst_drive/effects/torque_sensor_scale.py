# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A torque sensor with a wrong gain, which may set in with torque."""
from hst_drive.effects.base import Effect, Parameter


def error(load_torque, gain_error, knee):
    """Return what is added to the torque reading, N.m."""
    size = abs(load_torque)
    return gain_error * load_torque * size / (size + knee) if size > 0.0 else 0.0 * load_torque


EFFECT = Effect(
    id='torque_sensor_scale',
    title='the torque reading is off by a factor',
    slot='torque_reading',
    function=error,
    equation='reading = (1 + gain_error*|T|/(|T| + knee)) * T',
    parameters=(
        Parameter('gain_error', '1', -0.6, 0.6, 0.05,
                  'relative error of the torque reading'),
        Parameter('knee', 'N.m', 0.0, 300.0, 3.0,
                  'torque at which half of that has set in; 0: a plain factor'),
    ),
    telltale='Measured torque is off in proportion to itself, while pressure says that the load '
             'is right.',
    source='Sensitivity error of a sensor: IEC 61298-2; E. O. Doebelin, Measurement Systems, '
           'McGraw-Hill 2003.',
    shows_in=('load_torque',),
    gauge='known weights on the torque sensor',
)
