# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Torque that swings as piston after piston takes over.

Two amplitudes instead of amplitude and phase: so the torque is linear in both.
"""
import math

from hst_drive.effects.base import Effect, Parameter


def torque(pressure, motor_angle, motor_displacement, pistons, cosine, sine, count):
    """Return the swing about the mean torque, N.m."""
    angle = (count if count > 0.0 else pistons) * motor_angle
    swing = cosine * math.cos(angle) + sine * math.sin(angle)
    return swing * max(pressure, 0.0) * motor_displacement


EFFECT = Effect(
    id='piston_ripple',
    title='torque ripple at the piston frequency',
    slot='motor_torque',
    function=torque,
    equation='T = (cosine*cos(z*angle) + sine*sin(z*angle)) * P*D_m, z pistons',
    parameters=(
        Parameter('cosine', '1', -0.3, 0.3, 0.02,
                  'amplitude over the ideal torque, in phase with the angle at the start'),
        Parameter('sine', '1', -0.3, 0.3, 0.0,
                  'amplitude over the ideal torque, a quarter period later'),
        Parameter('count', '1', 0.0, 60.0, 0.0,
                  "swings per turn; 0: the pistons of the rig's file, 7 if it has none",
                  fixed=True),
    ),
    order='count',
    telltale='Pressure and speed carry a tone whose frequency is the number of pistons times the '
             'rotation.',
    source='N. D. Manring, Hydraulic Control Systems, Wiley 2005, and J. Ivantysyn and M. '
           'Ivantysynova, Hydrostatic Pumps and Motors, Akademia Books 2001: kinematic ripple of '
           'piston machines.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed', 'load_torque'),
)
