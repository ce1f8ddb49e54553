# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A displacement control that is slower than the datasheet says."""
from hst_drive.effects.base import Effect, Parameter


def lag(time_constant, series):
    """Return what is added to the displacement lag, s."""
    return (1.0 - series) * time_constant


def series_lag(time_constant, series):
    """Return the lag of what stands before the swash plate, a valve or an amplifier, s."""
    return series * time_constant


EFFECT = Effect(
    id='pump_lag',
    title="the actuator is slower than the datasheet's lag",
    slot='pump_lag',
    function=lag,
    also=(('pump_series_lag', series_lag),),
    equation='lag = lag_datasheet + (1 - series)*time_constant, and a lag of '
             'series*time_constant before it',
    parameters=(
        Parameter('time_constant', 's', 0.0, 3.0, 0.08,
                  'added to the first-order lag of the displacement'),
        Parameter('series', '1', 0.0, 1.0, 0.0,
                  'part of it that is a lag of its own, before the swash plate'),
    ),
    telltale='Speed and flow follow every step of the command late, small or large; steady '
             'values are right.',
    source='First-order displacement control: H. E. Merritt, Hydraulic Control Systems, Wiley '
           '1967, on pump-controlled drives; M. Jelali and A. Kroll, Hydraulic Servo-systems, '
           'Springer 2003.',
    shows_in=('motor_speed', 'motor_inlet_flow', 'pump_displacement'),
    # In one row with the displacement's own lag, which the unit's tolerance may take up instead.
    starts=({'series': 0.5},),
)
