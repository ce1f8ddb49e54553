# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Oil that a machine compresses and takes along: dead volume and soft chambers.

Each stroke of the pump compresses the displaced volume and the volume that stays behind; that oil
expands on the suction side and does not reach the line. So does the hydromotor's on its way out.
"""
from hst_drive.effects.base import Effect, Parameter


def flow_loss(displacement, max_displacement, pump_speed, pump_pressure, bulk_modulus,
              volume_ratio, dead_share, in_motor):
    """Return the delivery that compression takes, m^3/s."""
    volume = (1.0 - in_motor) * volume_ratio * (displacement + dead_share * max_displacement)
    return volume * pump_speed * pump_pressure / bulk_modulus


def motor_flow_loss(motor_displacement, motor_speed, pressure, bulk_modulus, volume_ratio,
                    in_motor):
    """Return what the hydromotor takes in beside what turns it, m^3/s."""
    volume = in_motor * volume_ratio * motor_displacement
    return volume * abs(motor_speed) * pressure / bulk_modulus


EFFECT = Effect(
    id='compressibility_flow',
    title='flow lost by decompression of the displaced volume',
    slot='pump_flow_loss',
    function=flow_loss,
    also=(('motor_flow_loss', motor_flow_loss),),
    equation='Q = volume_ratio * (D_p + dead_share*D_max)*w_p * P/K, or with in_motor = 1 '
             'volume_ratio * D_m*|w| * P/K in the hydromotor',
    parameters=(
        Parameter('volume_ratio', '1', 0.0, 15.0, 3.0,
                  'compressed volume (displaced and dead, at the bulk modulus of the line) over '
                  'the displaced volume'),
        Parameter('dead_share', '1', 0.0, 1.0, 0.3,
                  'part of the volume that no stroke changes, over the largest displacement: the '
                  'pistons of a swash plate turn about the middle of their stroke'),
        Parameter('in_motor', '1', 0.0, 1.0, 0.0, 'where: 0 in the pump, 1 in the hydromotor',
                  fixed=True),
    ),
    telltale='The flow meter reads less than the pump should give, or more than turns the '
             'hydromotor, in proportion to pressure and to the flow itself.',
    source='J. Ivantysyn and M. Ivantysynova, Hydrostatic Pumps and Motors, Akademia Books 2001: '
           'volumetric losses by compressibility; N. D. Manring, Hydraulic Control Systems, '
           'Wiley 2005.',
    shows_in=('motor_speed', 'motor_inlet_flow'),
    kept=True,
    starts=({'in_motor': 1.0},),
)
