# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A return line that is not free."""
from hst_drive.effects.base import Effect, Parameter


def outlet(outlet_pressure):
    """Return the pressure at the hydromotor outlet, Pa."""
    return outlet_pressure


EFFECT = Effect(
    id='back_pressure',
    title='the hydromotor discharges against a return pressure',
    slot='back_pressure',
    function=outlet,
    equation='T = eta * (P - outlet_pressure) * D_m',
    parameters=(
        Parameter('outlet_pressure', 'Pa', 0.0, 6e6, 4e5,
                  'gauge pressure at the hydromotor outlet'),
    ),
    telltale='Pressure is too high by the same amount at every speed and load.',
    source='Torque of a hydromotor from the difference of its port pressures: H. E. Merritt, '
           'Hydraulic Control Systems, Wiley 1967; ISO 4409.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed'),
    alike=('bearing_friction', 'pressure_sensor_bias'),
)
