# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A shaft or drill string that twists.

The kernel splits the inertia into a part at the hydromotor and one behind the shaft.
"""
from hst_drive.effects.base import Effect, Parameter
from hst_drive.effects.slots import USUAL_DAMPING_TIME, USUAL_SHARE


def load_share(compliance, load_side_share):
    """Return by how much more than usual of the inertia lies behind the shaft; rigid: nothing."""
    return load_side_share - USUAL_SHARE if compliance > 0.0 else 0.0


def damping(compliance, damping_time):
    """Return by how much longer than usual the damping time is, s; rigid: nothing."""
    return damping_time - USUAL_DAMPING_TIME if compliance > 0.0 else 0.0


def softness(twist, compliance, hardening):
    """Return the twist per torque, rad/(N.m)."""
    return compliance / (1.0 + hardening * twist * twist)


EFFECT = Effect(
    id='shaft_compliance',
    title='a flexible shaft or drill string between hydromotor and load',
    slot='shaft_compliance',
    function=softness,
    also=(('shaft_load_share', load_share), ('shaft_damping_time', damping)),
    equation='T_shaft = (twist + damping_time*(w - w_load))/compliance*(1 + hardening*twist^2), '
             'load_side_share of the inertia behind it',
    parameters=(
        Parameter('compliance', 'rad/(N.m)', 0.0, 0.1, 0.0031,
                  'twist of the shaft per torque'),
        Parameter('load_side_share', '1', 0.25, 0.9, USUAL_SHARE,
                  'part of the inertia that lies behind the shaft', neutral=USUAL_SHARE),
        Parameter('hardening', '1/rad^2', 0.0, 50.0, 0.1,
                  'how much stiffer a twisted shaft is: rubber couplings, threads that close'),
        Parameter('damping_time', 's', 0.0, 0.1, USUAL_DAMPING_TIME,
                  'damping of the shaft over its stiffness', neutral=USUAL_DAMPING_TIME),
    ),
    # Ringing in step and out of step with the measured one: a valley each.
    starts=tuple({'compliance': compliance, 'load_side_share': share}
                 for share in (0.3, 0.45, 0.6, 0.75)
                 for compliance in (2e-4 * 1.5**k for k in range(11))),
    telltale='After a change of load, torque and speed ring at a frequency that the oil column '
             'does not explain.',
    source='Two-inertia drive: H. E. Merritt, Hydraulic Control Systems, Wiley 1967, on load '
           'resonance; for drill strings J. D. Jansen and L. van den Steen, Active damping of '
           'self-excited torsional vibrations in oil well drillstrings, J. Sound and Vibration '
           '179 (1995).',
    shows_in=('load_torque', 'motor_speed', 'pump_outlet_pressure'),
)
