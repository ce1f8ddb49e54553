# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A torque that does not change its sign with the rotation.

A torque sensor that is off at zero, a hanging load, an amplifier with an offset. Where a drive
turns one way only, a torque at the shaft looks like dry friction and is named beside it.
"""
from hst_drive.effects.base import Effect, Parameter


def added(torque, in_sensor, in_load):
    """Return the torque that drives the hydromotor beyond its own, N.m."""
    return -torque * (1.0 - in_sensor - in_load)


def hanging(torque, in_load, motor_speed):
    """Return what is added to the load, which brakes whichever way it turns, N.m."""
    return torque * in_load * (1.0 if motor_speed >= 0.0 else -1.0)


def zero(torque, in_sensor):
    """Return what is added to the torque reading, N.m."""
    return -torque * in_sensor


EFFECT = Effect(
    id='constant_torque',
    title='a torque that does not change its sign with the rotation',
    slot='motor_torque',
    function=added,
    also=(('torque_reading', zero), ('load_torque', hanging)),
    equation='T = -torque, whichever way it turns; with in_sensor = 1 in the reading, with '
             'in_load = 1 in the load',
    parameters=(
        Parameter('torque', 'N.m', -500.0, 500.0, 12.0,
                  'what works against the positive direction'),
        Parameter('in_sensor', '1', 0.0, 1.0, 0.0,
                  'where: 0 at the shaft, 1 in the reading of its torque alone', fixed=True,
                  whole_drive=True),
        Parameter('in_load', '1', 0.0, 1.0, 0.0,
                  'where: 1 behind the torque sensor, which reads it (a hanging load)', fixed=True,
                  whole_drive=True),
    ),
    telltale='Torque is off by the same amount in both directions: more than it should be in one, '
             'less in the other.',
    source='Drive torque with an offset beside Coulomb and viscous friction: M. Gautier, A. Janot '
           'and P. O. Vandanjon, A new closed-loop output error method for parameter '
           'identification of robot dynamics, IEEE Trans. Control Systems Technology 21 (2013).',
    shows_in=('motor_torque', 'load_torque'),
    alike=('bearing_friction', 'back_pressure', 'pressure_sensor_bias'),
    both_ways=True,
    starts=({'in_sensor': 1.0}, {'in_load': 1.0}),
)
