# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A prime mover that gives way under load.

The slip is stated at full pump torque: largest displacement at the relief valve's pressure.
"""
from hst_drive.effects.base import Effect, Parameter


def slip(displacement, pump_pressure, max_displacement, rated_pressure, nominal_speed, droop):
    """Return the change of the pump shaft speed, rad/s."""
    load = displacement * pump_pressure / (max_displacement * rated_pressure)
    return -droop * nominal_speed * load


def lag(droop, time_constant):
    """Return how slowly the pump shaft follows, s."""
    return time_constant if droop > 0.0 else 0.0


EFFECT = Effect(
    id='pump_speed_droop',
    title='the prime mover slows down under pump torque',
    slot='pump_speed',
    function=slip,
    also=(('pump_speed_lag', lag),),
    equation='dw_p = -droop * w_nominal * D_p*P/(D_max*P_relief), behind a lag of time_constant',
    parameters=(
        Parameter('droop', '1', 0.0, 0.5, 0.09,
                  'loss of speed at full pump torque, over the nominal speed'),
        Parameter('time_constant', 's', 0.0, 1.0, 0.06,
                  'how slowly the inertia of the prime mover lets the speed follow'),
    ),
    telltale='Flow is missing in proportion to pressure times stroke squared; a recorded pump '
             'speed shows it at once.',
    source='Slip of an induction machine in proportion to torque about the synchronous speed: A. '
           'E. Fitzgerald, C. Kingsley and S. D. Umans, Electric Machinery, McGraw-Hill 2003, '
           'ch. 6; likewise the droop of a diesel governor.',
    shows_in=('pump_speed', 'motor_speed', 'motor_inlet_flow'),
)
