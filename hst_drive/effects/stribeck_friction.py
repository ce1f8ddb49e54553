# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Friction that is high near standstill and falls as an oil film builds up."""
import math

from hst_drive.effects.base import Effect, Parameter


def torque_loss(motor_speed, torque, speed):
    """Return the friction torque that opposes rotation, N.m."""
    return torque * math.exp(-(motor_speed / speed)**2)


EFFECT = Effect(
    id='stribeck_friction',
    title='extra friction at low speed that falls as speed rises',
    slot='motor_torque_loss',
    function=torque_loss,
    equation='T = torque * exp(-(w/speed)^2)',
    parameters=(
        Parameter('torque', 'N.m', 0.0, 500.0, 14.0,
                  'extra friction torque near standstill'),
        Parameter('speed', 'rad/s', 0.3, 60.0, 4.0,
                  'Stribeck speed: there 37 % of the extra torque are left', neutral=4.0),
    ),
    telltale='Pressure is too high at low speed only; creeping drives jerk (stick-slip).',
    source='B. Armstrong-Helouvry, P. Dupont and C. Canudas de Wit, A survey of models, analysis '
           'tools and compensation methods for the control of machines with friction, Automatica '
           '30 (1994): Gaussian Stribeck curve.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed'),
)
