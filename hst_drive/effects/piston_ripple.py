# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Torque that swings as piston after piston takes over.

Two amplitudes instead of amplitude and phase: so the torque is linear in both. An odd number of
pistons swings twice as often as its pistons come, too.
"""
import math

from hst_drive.effects.base import Effect, Parameter


def torque(pressure, motor_angle, motor_displacement, pistons, cosine, sine, cosine_2, sine_2,
           count):
    """Return the swing about the mean torque, N.m."""
    angle = (count if count > 0.0 else pistons) * motor_angle
    one, other = math.cos(angle), math.sin(angle)
    swing = (cosine * one + sine * other + cosine_2 * (2.0 * one * one - 1.0)
             + sine_2 * 2.0 * one * other)
    return swing * pressure * motor_displacement


def swings(values, pistons):
    """Return how often in a turn it swings, and its parameters without that."""
    return values['count'] or pistons, {
        **dict.fromkeys(('cosine', 'sine', 'cosine_2', 'sine_2'), 0.0), 'count': values['count']}


EFFECT = Effect(
    id='piston_ripple',
    title='torque ripple at the piston frequency',
    slot='motor_torque',
    function=torque,
    equation='T = (cosine*cos(a) + sine*sin(a) + cosine_2*cos(2*a) + sine_2*sin(2*a)) * P*D_m, '
             'a = count*angle',
    parameters=(
        Parameter('cosine', '1', -0.3, 0.3, 0.02,
                  'amplitude over the ideal torque, in phase with the angle at the start'),
        Parameter('sine', '1', -0.3, 0.3, 0.0,
                  'amplitude over the ideal torque, a quarter period later'),
        Parameter('cosine_2', '1', -0.3, 0.3, 0.0, 'the same at twice that frequency'),
        Parameter('sine_2', '1', -0.3, 0.3, 0.0, 'and a quarter period later'),
        Parameter('count', '1', 0.0, 60.0, 0.0,
                  "swings per turn; 0: the pistons of the rig's file, 7 if it has none",
                  fixed=True),
    ),
    order='count',
    swings=swings,
    telltale='Pressure and speed carry a tone whose frequency is the number of pistons times the '
             'rotation.',
    source='N. D. Manring, Hydraulic Control Systems, Wiley 2005, and J. Ivantysyn and M. '
           'Ivantysynova, Hydrostatic Pumps and Motors, Akademia Books 2001: kinematic ripple of '
           'piston machines.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed', 'load_torque'),
)
