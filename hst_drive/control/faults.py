# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What may go wrong with a controlled drive, and from where on it counts as wrong."""
from __future__ import annotations

from dataclasses import dataclass, fields
import math
from typing import NamedTuple

FAULTS = {
    'emergency_stop': 'emergency stop',
    'feedback_lost': 'no usable speed reading',
    'feedback_joint': 'it is not clear which joint of the message to read',
    'feedback_not_finite': 'the speed reading is not a number',
    'feedback_out_of_range': 'the speed reading is outside its range',
    'feedback_jumps': 'the speed reading jumps faster than the drive can',
    'feedback_frozen': 'the speed reading does not change at all',
    'feedback_time': 'the time stamps of the speed reading are wrong',
    'following_error': 'the speed does not follow the set point',
    'setpoint_lost': 'no set point',
    'setpoint_invalid': 'the set point is not a number in its range',
    'command_invalid': 'the command is not a number within its limits',
    'shutdown': 'the controller is being ended',
}
"""What each fault means."""
_MAY_BE_OFF = ('setpoint_timeout', 'stamp_tolerance', 'frozen_timeout', 'following_error_timeout',
               'start_after_reset', 'wait_for_start')


@dataclass(frozen=True)
class SafetySettings:
    """
    Limits and times of the supervisor.

    Attributes
    ----------
    feedback_timeout : float
        Longest time without a usable reading, s.
    setpoint_timeout : float
        Longest time without a set point (or manual command), s; 0: the last one holds for ever.
    stamp_tolerance : float
        Largest difference between a reading's stamp and the clock, s; 0: not judged.
    frozen_timeout : float
        Longest time with the same reading, other than 0, to the last bit, s; 0: not judged.
    bad_readings : int
        So many bad readings are a fault, fewer are passed over; four good ones in between make up
        for one.
    speed_limit : float
        Readings are within +- this, set points between 0 (where commands have either sign:
        minus this) and this, rad/s.
    acceleration_limit : float
        Largest change of the reading, rad/s^2.
    following_error_limit : float
        Largest difference between set point and speed that may last, rad/s.
    following_error_timeout : float
        Longest time with a larger one that the command does not end, s; 0: not judged.
    stop_time, emergency_stop_time : float
        Time of the ramp from the largest command, either way, to 0 V, s.
    start_after_reset : bool
        A reset is refused above 0 V, and the drive stays there until it is started: by a set
        point (manual command) that is back at rest, or by ``Supervisor.start``.
    wait_for_start : bool
        The drive stays at 0 V from the beginning on until it is started in that way.

    """

    feedback_timeout: float = 0.25
    setpoint_timeout: float = 0.5
    stamp_tolerance: float = 1.0
    frozen_timeout: float = 1.0
    bad_readings: int = 3
    speed_limit: float = 30.0
    acceleration_limit: float = 1500.0
    following_error_limit: float = 3.0
    following_error_timeout: float = 5.0
    stop_time: float = 1.0
    emergency_stop_time: float = 0.3
    start_after_reset: bool = True
    wait_for_start: bool = False

    def __post_init__(self):
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not math.isfinite(value) or value < 0 or (
                    value == 0 and entry.name not in _MAY_BE_OFF):
                raise ValueError(f'{entry.name}={value}: expected a positive number')


class Fault(NamedTuple):
    """A fault: one of ``FAULTS``, what was found, and when (s)."""

    kind: str
    found: str
    time: float

    def __str__(self) -> str:
        return f'{self.kind}: {FAULTS[self.kind]}' + (f' ({self.found})' if self.found else '')
