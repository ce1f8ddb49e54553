# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Friction that is high near standstill and falls as an oil film builds up."""
import math

from hst_drive.effects.base import Effect, Parameter


def torque_loss(motor_speed, torque, speed, shape, tail):
    """Return the friction torque that opposes rotation, N.m."""
    ratio = abs(motor_speed) / speed
    # The usual shape without a power, which takes as long as the exponential.
    fallen = ratio * ratio if shape == 2.0 else ratio**shape
    if tail < 1e-6:
        return torque * math.exp(-fallen)
    power = 2.0 / (shape * tail)
    return torque * (1.0 + fallen / power)**-power


EFFECT = Effect(
    id='stribeck_friction',
    title='extra friction at low speed that falls as speed rises',
    slot='motor_torque_loss',
    function=torque_loss,
    equation='T = torque * (1 + x/n)^(-n), x = (|w|/speed)^shape, n = 2 / (shape * tail); '
             'with tail = 0: torque * exp(-x)',
    parameters=(
        Parameter('torque', 'N.m', 0.0, 500.0, 14.0,
                  'extra friction torque near standstill'),
        Parameter('speed', 'rad/s', 0.3, 60.0, 4.0,
                  'Stribeck speed: there 37 % of the extra torque are left', neutral=4.0),
        Parameter('shape', '1', 0.5, 4.0, 2.0,
                  'power in the exponent; 2 is the Gaussian form, 1 the exponential one',
                  neutral=2.0, usual=(2.0, 1.0)),
        Parameter('tail', '1', 0.0, 1.0, 0.0,
                  '0: falls exponentially, 1: far out with the square of the speed (with shape 2 '
                  'the Lorentzian form)',
                  usual=(0.0, 1.0)),
    ),
    telltale='Pressure is too high at low speed only; creeping drives jerk (stick-slip).',
    source='B. Armstrong-Helouvry, P. Dupont and C. Canudas de Wit, A survey of models, analysis '
           'tools and compensation methods for the control of machines with friction, Automatica '
           '30 (1994): Stribeck curve with '
           'powers from 0.5 to 2 and beyond.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed'),
    starts=({'shape': 1.0}, {'tail': 1.0}),
)
