# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A command that moves the spool but passes no oil: its overlap is wider than the datasheet's."""
import math

from hst_drive.effects.base import Effect, Parameter

SMOOTH = 0.02       # V, over which it changes its sign
FULL = 10.0         # V


def shift(valve_command, width, side, regained):
    """Return what is added to the command, V: nothing of it at standstill."""
    way = math.tanh(valve_command / SMOOTH)
    left = 1.0 - regained * min(abs(valve_command) / FULL, 1.0)
    return -width * way * (1.0 + side * way) * left


EFFECT = Effect(
    id='valve_dead_band',
    title='command that moves the spool but passes no oil',
    slot='valve_command',
    function=shift,
    equation='u_effective = u - width*sign(u)*(1 + side*sign(u)) * (1 - regained*|u|/(10 V))',
    parameters=(
        Parameter('width', 'V', -1.0, 3.0, 0.2, 'taken from the command, mean of both ways'),
        Parameter('side', '1', -1.0, 1.0, 0.0,
                  'how much more forwards than backwards: 1 where one edge alone is worn',
                  usual=(-1.0, 0.0, 1.0)),
        Parameter('regained', '1', 0.0, 1.0, 0.0,
                  'part of it that is made up for up to the full command: 1 where the full '
                  'opening is as it was', usual=(0.0, 1.0)),
    ),
    telltale='Speed is too low by about the same amount at every command, in both directions.',
    source='M. Jelali and A. Kroll, Hydraulic Servo-systems, Springer 2003: overlap of '
           'proportional valves.',
    starts=({'side': 1.0}, {'side': -1.0}, {'side': 1.0, 'regained': 1.0},
            {'side': -1.0, 'regained': 1.0}),
    shows_in=('motor_speed', 'motor_inlet_flow'),
)
