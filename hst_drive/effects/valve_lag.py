# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A spool that is slower than its datasheet."""
from hst_drive.effects.base import Effect, Parameter


def lag(time_constant):
    """Return what is added to the lag of the valve, s."""
    return time_constant


EFFECT = Effect(
    id='valve_lag',
    title='the spool is slower than its datasheet',
    slot='valve_lag',
    function=lag,
    equation='lag = lag_datasheet + time_constant',
    parameters=(
        Parameter('time_constant', 's', 0.0, 2.0, 0.04, 'added to the first-order lag'),
    ),
    telltale='Speed follows every step of the command late; steady values are right.',
    source='M. Jelali and A. Kroll, Hydraulic Servo-systems, Springer 2003: first-order valve '
           'dynamics.',
    shows_in=('motor_speed', 'motor_inlet_flow'),
)
