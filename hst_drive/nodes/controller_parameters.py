# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of the controller's node."""
from __future__ import annotations

from hst_drive.control import SafetySettings
from hst_drive.control.pi import ANTIWINDUP_STRATEGIES
from hst_drive.nodes.diagnostics import HARDWARE
from hst_drive.nodes.forward import PARAMETERS as FORWARD
from hst_drive.nodes.mapped import CHANNELS
from hst_drive.nodes.parameters import JOINT, Parameter

_DEFAULTS = SafetySettings()
PARAMETERS = (
    Parameter('mode', 'closed_loop', 'closed_loop: PI on the speed; open_loop: pass the '
              'manual command on', choices=('closed_loop', 'open_loop')),
    HARDWARE,
    Parameter('joint', '', 'joint of the topic motor whose speed is held; empty: the only '
              'one there is', form=JOINT),
    CHANNELS,
    *FORWARD,
    Parameter('kp', 0.02, 'proportional gain', 'V.s/rad', 0.0, 10.0, live=True),
    Parameter('ki', 0.45, 'integral gain', 'V/rad', 0.0, 100.0, live=True),
    Parameter('sample_time', 0.01, 'time between two commands', 's', 0.0005, 1.0),
    Parameter('u_clamp_min', 0.0, 'smallest command; below 0 the drive turns either way', 'V',
              -10.0, 10.0),
    Parameter('u_clamp_max', 10.0, 'largest command', 'V', 0.0, 10.0),
    Parameter('dead_band', 0.0, 'to either side of 0 V, in which the pump gives nothing: the '
              'command steps over it', 'V', 0.0, 5.0),
    Parameter('start_command', -100.0, 'first command, for a bumpless start; beyond '
              'u_clamp_min and u_clamp_max: none', 'V', -100.0, 100.0),
    Parameter('antiwindup_strategy', 'conditional_integration', 'what the integral does while the '
              'command is at its limit', choices=ANTIWINDUP_STRATEGIES),
    Parameter('feedback_timeout', _DEFAULTS.feedback_timeout, 'longest time without a usable '
              'speed reading', 's', 0.002, 60.0),
    Parameter('setpoint_timeout', _DEFAULTS.setpoint_timeout, 'longest time without a set '
              'point or manual command; 0: the last one holds', 's', 0.0, 3600.0),
    Parameter('stamp_tolerance', _DEFAULTS.stamp_tolerance, 'largest difference between the '
              "readings' stamps and the clock; 0: not judged", 's', 0.0, 3600.0),
    Parameter('frozen_timeout', _DEFAULTS.frozen_timeout, 'longest time with the very same '
              'reading other than 0; 0: not judged', 's', 0.0, 3600.0),
    Parameter('bad_readings', _DEFAULTS.bad_readings, 'so many bad readings stop the drive; four '
              'good ones in between make up for one', low=1, high=1000),
    Parameter('speed_limit', _DEFAULTS.speed_limit, 'readings and set points beyond it are '
              'wrong', 'rad/s', 0.1, 1e4),
    Parameter('acceleration_limit', _DEFAULTS.acceleration_limit, 'readings that change '
              'faster are wrong', 'rad/s^2', 1.0, 1e7),
    Parameter('following_error_limit', _DEFAULTS.following_error_limit, 'largest difference '
              'between set point and speed that may last', 'rad/s', 0.01, 1e4),
    Parameter('following_error_timeout', _DEFAULTS.following_error_timeout, 'longest time '
              'with a larger one, while the command is at its limit or moves on; 0: not '
              'judged', 's', 0.0, 3600.0),
    Parameter('stop_time', _DEFAULTS.stop_time, 'ramp from the largest command to 0 V', 's',
              0.01, 60.0),
    Parameter('emergency_stop_time', _DEFAULTS.emergency_stop_time, 'the same for an '
              'emergency stop', 's', 0.01, 60.0),
    Parameter('start_after_reset', _DEFAULTS.start_after_reset, 'after a reset the drive waits at '
              '0 V for a start: set point back at rest, or ~/start'),
    Parameter('wait_for_start', _DEFAULTS.wait_for_start, 'it waits for that start from the '
              'beginning on; a manager sets this for a controller that it brings back'),
)
