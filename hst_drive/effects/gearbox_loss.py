# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A gear that takes its share of the torque."""
from hst_drive.effects.base import Effect, Parameter


def torque(load_torque, fraction, no_load):
    """Return the torque that the gear adds to the load, N.m."""
    return fraction * (load_torque + no_load)


EFFECT = Effect(
    id='gearbox_loss',
    title='the gear takes its share of the torque',
    slot='load_torque',
    function=torque,
    equation='T = fraction * (T_load + no_load)',
    parameters=(
        Parameter('fraction', '1', 0.0, 0.6, 0.06,
                  'lost torque over the torque of the loading pump'),
        # At most about a rated load: a gear that takes more when idle than under load is dragging.
        Parameter('no_load', 'N.m', 0.0, 200.0, 3.0,
                  'load that costs as much as the gear takes without load'),
    ),
    telltale="Pressure and measured torque are both higher than the loading pump's pressure "
             'explains, in proportion to load.',
    source='Load-dependent gear losses: G. Niemann and H. Winter, Maschinenelemente vol. 2, '
           'Springer 2003; ISO/TR 14179-1.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'load_torque'),
)
