# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A low side that is no longer held: the charge relief opens early, or the pump is worn."""
from hst_drive.effects.base import Effect, Parameter


def relief(drop):
    """Return what is taken from the pressure of the charge relief, Pa."""
    return drop


def wear(worn):
    """Return the share of the charge pump's delivery that leaks at the relief's pressure."""
    return worn


EFFECT = Effect(
    id='charge_pressure_loss',
    title='charge pump or its relief no longer holds the low side',
    slot='charge_pressure',
    function=relief,
    also=(('charge_wear', wear),),
    equation='P_relief = P_datasheet - drop; Q_charge = D_charge*w_p * (1 - worn*P/P_relief)',
    parameters=(
        Parameter('drop', 'Pa', 0.0, 3e6, 4e5, 'what the low side lacks of it'),
        Parameter('worn', '1', 0.0, 0.95, 0.0, 'share of its delivery that '
                  "a worn charge pump leaks at the relief's pressure"),
    ),
    telltale='The low side stands lower than it should, in both directions of rotation.',
    source='J. Ivantysyn and M. Ivantysynova, Hydrostatic Pumps and Motors, Akademia Books 2001, '
           'on charge supply of closed circuits; ISO 4413 on minimum pressures.',
    shows_in=('line_a_pressure', 'line_b_pressure', 'charge_pressure'),
    starts=({'drop': 0.0, 'worn': 0.4},),
)
