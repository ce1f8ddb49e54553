# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A pump that no longer fills.

Beyond some flow the pressure in the suction line falls so far that the chambers take in vapour
and air: the delivery falls behind displacement times speed.
"""
from hst_drive.effects.base import Effect, Parameter


def flow_loss(displacement, pump_speed, max_displacement, nominal_speed, share_at_full,
              begins_at, exponent):
    """Return the delivery that is missing, m^3/s."""
    full = max_displacement * nominal_speed
    if full <= 0.0:
        return 0.0      # the rig file of a part gives none
    beyond = max(displacement * pump_speed / full - begins_at, 0.0) / (1.0 - begins_at)
    return share_at_full * full * beyond**exponent


EFFECT = Effect(
    id='suction_starvation',
    title='the pump no longer fills at large displacement and speed',
    slot='pump_flow_loss',
    function=flow_loss,
    equation='Q = share_at_full * Q_full * (max(D*w_p/Q_full - begins_at, 0) / '
             '(1 - begins_at))^exponent, Q_full = D_max * w_nominal',
    parameters=(
        Parameter('share_at_full', '1', 0.0, 0.8, 0.12, 'of the full flow that is missing there'),
        Parameter('begins_at', '1', 0.05, 0.9, 0.5, 'share of the full flow up to which it fills',
                  neutral=0.5),
        Parameter('exponent', '1', 1.0, 2.0, 1.0, 'how it grows from there', neutral=1.0,
                  usual=(1.0, 2.0)),
    ),
    telltale='At a large command the pump delivers less than it should, whatever the pressure; '
             'below some command all is well.',
    source='Filling of chambers and the speed limit of self-priming pumps: J. Ivantysyn and M. '
           'Ivantysynova, Hydrostatic Pumps and Motors, Akademia Books 2001; loss of delivery '
           'by cavitation: N. D. Manring, Fluid Power Pumps and Motors, McGraw-Hill 2013.',
    shows_in=('motor_speed', 'motor_inlet_flow'),
    kept=True,
    starts=({'begins_at': 0.2}, {'begins_at': 0.7}),
)
