# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Oil that the pump compresses and takes back: dead volume and soft chambers.

Each stroke compresses the displaced volume and the volume that stays behind; that oil expands
on the suction side and does not reach the line.
"""
from hst_drive.effects.base import Effect, Parameter


def flow_loss(displacement, max_displacement, pump_speed, pump_pressure, bulk_modulus,
              volume_ratio, dead_share):
    """Return the delivery that compression takes, m^3/s."""
    volume = displacement + dead_share * max_displacement
    return volume_ratio * volume * pump_speed * pump_pressure / bulk_modulus


EFFECT = Effect(
    id='compressibility_flow',
    title='flow lost by decompression of the displaced volume',
    slot='pump_flow_loss',
    function=flow_loss,
    equation='Q = volume_ratio * (D_p + dead_share*D_max)*w_p * P/K',
    parameters=(
        Parameter('volume_ratio', '1', 0.0, 15.0, 3.0,
                  'compressed volume (displaced and dead, at the bulk modulus of the line) over '
                  'the displaced volume'),
        Parameter('dead_share', '1', 0.0, 1.0, 0.3,
                  'part of the volume that no stroke changes, over the largest displacement: the '
                  'pistons of a swash plate turn about the middle of their stroke'),
    ),
    telltale='The flow meter reads less than the pump should give, in proportion to pressure and '
             'to the flow itself.',
    source='J. Ivantysyn and M. Ivantysynova, Hydrostatic Pumps and Motors, Akademia Books 2001: '
           'volumetric losses by compressibility; N. D. Manring, Hydraulic Control Systems, '
           'Wiley 2005.',
    shows_in=('motor_speed', 'motor_inlet_flow'),
)
