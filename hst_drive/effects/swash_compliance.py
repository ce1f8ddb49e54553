# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A swash plate that yields to pressure.

The pistons push the plate back against its control; a power limiter that acts early does the
same from some pressure on. Unlike leakage it is gone from the stroke itself, and follows pressure
no faster than the plate moves.
"""
from hst_drive.effects.base import Effect, Parameter

REFERENCE = 1e7     # Pa


def pump_yield(pump_pressure, displacement, max_displacement, share_at_100_bar, begins_at,
               with_stroke, as_limiter, at_once):
    """Return what pressure takes from the displacement, m^3/rad."""
    yielding = (1.0 - with_stroke) * max_displacement + with_stroke * displacement
    # Where the pump brakes, the pistons press the other way; a power limiter does not.
    braking = (1.0 - 2.0 * as_limiter) * (max(-pump_pressure, begins_at) - begins_at)
    beyond = max(pump_pressure, begins_at) - begins_at - braking
    return (1.0 - at_once) * share_at_100_bar * yielding * beyond / REFERENCE


def gives(pressure, displacement, max_displacement, share_at_100_bar, with_stroke, at_once):
    """Return what comes to the displacement behind the control, m^3/rad."""
    yielding = (1.0 - with_stroke) * max_displacement + with_stroke * abs(displacement)
    return -at_once * share_at_100_bar * yielding * pressure / REFERENCE


EFFECT = Effect(
    id='swash_compliance',
    title='the swash plate yields to pressure',
    slot='pump_yield',
    function=pump_yield,
    also=(('displacement_at_once', gives),),
    equation='D = D(command) - share_at_100_bar * max(P - begins_at, 0)/(100 bar) * '
             '((1 - with_stroke)*D_max + with_stroke*D); where the pump brakes P is below 0 and D '
             'grows, with as_limiter it falls; at_once = 1: at each P, behind the lag',
    parameters=(
        Parameter('share_at_100_bar', '1', 0.0, 0.5, 0.04,
                  'of the largest displacement, lost in 100 bar'),
        Parameter('begins_at', 'Pa', 0.0, 2.5e7, 0.0, 'pressure from which on it yields',
                  usual=(0.0,)),
        Parameter('with_stroke', '1', 0.0, 1.0, 0.0,
                  'part of it that goes with the stroke: the moment of the pistons on the plate '
                  'goes with both', usual=(0.0, 1.0)),
        Parameter('as_limiter', '1', 0.0, 1.0, 0.0, 'in a closed circuit: 1 if the stroke falls '
                  'whichever side drives, as under a power limiter', needs='line_b_pressure'),
        Parameter('at_once', '1', 0.0, 1.0, 0.0, 'in a closed circuit: part of it that does not '
                  'wait for the control, in the linkage of a servo', fixed=True,
                  needs='line_b_pressure', usual=(0.0, 1.0)),
    ),
    telltale='Displacement, and with it flow, falls with pressure whatever the command; after a '
             'step of load it falls as slowly as the plate moves.',
    source='Moment of the pistons on a swash plate and its control: N. D. Manring, Fluid Power '
           'Pumps and Motors, McGraw-Hill 2013; G. Zeiger and A. Akers, Torque on the swashplate '
           'of an axial piston pump, J. Dyn. Sys. Meas. Control 107 (1985).',
    shows_in=('motor_speed', 'motor_inlet_flow', 'pump_displacement'),
    starts=({'with_stroke': 1.0}, {'begins_at': 6e6}, {'as_limiter': 1.0},
            {'with_stroke': 1.0, 'at_once': 1.0}),
)
