# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A displacement control that is slower than the datasheet says."""
from hst_drive.effects.base import Effect, Parameter


def lag(time_constant):
    """Return what is added to the displacement lag, s."""
    return time_constant


EFFECT = Effect(
    id='pump_lag',
    title="the actuator is slower than the datasheet's lag",
    slot='pump_lag',
    function=lag,
    equation='lag = lag_datasheet + time_constant',
    parameters=(
        Parameter('time_constant', 's', 0.0, 3.0, 0.08,
                  'added to the first-order lag of the displacement'),
    ),
    telltale='Speed and flow follow every step of the command late, small or large; steady '
             'values are right.',
    source='First-order displacement control: H. E. Merritt, Hydraulic Control Systems, Wiley '
           '1967, on pump-controlled drives; M. Jelali and A. Kroll, Hydraulic Servo-systems, '
           'Springer 2003.',
    shows_in=('motor_speed', 'motor_inlet_flow', 'pump_displacement'),
)
