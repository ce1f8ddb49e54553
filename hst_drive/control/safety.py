# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What takes the drive to standstill when the controller may no longer be trusted.

``Supervisor`` judges every reading and every wish before the law sees them. A fault is latched:
from then on the command falls on a straight line to 0 V (no displacement), and nothing but
``reset`` ends that, once the cause is gone. A reset does not start the drive: it stays at 0 V
until the set point has been back at rest, or ``start`` is called.
"""
from __future__ import annotations

import math
from typing import NamedTuple

from hst_drive.control.faults import Fault, FAULTS, SafetySettings
from hst_drive.control.ramp import Ramp

WAITING, READY, RUNNING = 'waiting', 'ready', 'running'
STOPPING, STOPPED = 'stopping', 'stopped'
_FORGIVEN = 0.25   # of a bad reading by each good one: more than one in five trips in the end
_SHARE = 0.5       # of the set point: loaded, at full stroke, the drive turns slower, but it turns
_NEARER = 0.9      # an error that falls to this share of itself is a drive that follows slowly
_MOVED = 0.01      # of the command's range, one way: less is the speed's noise times kp


class _Apart(NamedTuple):
    """Since when (s) the speed is apart, how far (rad/s, with sign), at which command (V)."""

    since: float
    error: float
    command: float


class Supervisor:
    """
    Watches readings and wishes; holds the fault and the ramp.

    All times are seconds of one clock that never runs back: the steady clock, or in simulated
    time the steps' stamps.

    Parameters
    ----------
    settings : SafetySettings
        Limits and times.
    limits : (float, float)
        Smallest and largest command, V; a manual command beyond them is a fault. With a negative
        one the drive turns either way. Zero stroke is at 0 V.
    manual : bool
        The wishes are pump commands (V), not set points (rad/s).

    """

    def __init__(self, settings: SafetySettings, limits: tuple[float, float] = (0.0, 10.0),
                 manual: bool = False):
        self.settings, self.limits, self.manual = settings, limits, manual
        self._wishes = limits if manual else (
            -settings.speed_limit if limits[0] < 0.0 else 0.0, settings.speed_limit)
        self.rest = max(self._wishes[0], 0.0)   # the wish for standstill
        self.fault: Fault | None = None
        self.held = settings.wait_for_start     # at 0 V, not started
        self.passed_over = 0               # bad readings that led to no fault
        self._pressed: set[str] = set()
        self._bad: tuple[str, str] | None = None
        self._score = 0.0
        self._good = 0                     # good readings in a row
        self._stamp = self._compared = self._value = -math.inf
        self._same_since = math.inf
        self._usable_at: float | None = None
        self._wanted_at: float | None = None
        self._wish_fault: tuple[str, str] | None = None
        self._at_rest = False              # as the last wish is
        self._apart: _Apart | None = None
        self._ramp: Ramp | None = None
        self._ending = False

    @property
    def missing(self) -> tuple[bool, bool]:
        """Whether the first usable reading, and the first wish, are still to come."""
        return self._usable_at is None, self._wanted_at is None

    @property
    def state(self) -> str:
        """
        'waiting' (for reading and wish), 'ready' (for a start), 'running', 'stopping', 'stopped'.

        It is 'stopped' once the ramp has given 0 V, not before.
        """
        if self.fault:
            return STOPPED if self._ramp and self._ramp.command == 0.0 else STOPPING
        return WAITING if any(self.missing) else READY if self.held else RUNNING

    def feedback(self, now: float, stamp: float, value: float, clock: float | None = None,
                 refused: str = '') -> bool:
        """
        Judge a speed reading and return whether it may be used.

        Parameters
        ----------
        now, stamp : float
            When it came; when it was taken, of its own clock, s.
        value : float
            rad/s.
        clock : float, optional
            What the clock of the stamps says now, s; None: not to be compared.
        refused : str
            Why the message does not tell the reading; '' if it does.

        """
        self._bad = bad = self._judge(now, stamp, value, clock, refused)
        if bad is None:
            self._score = max(0.0, self._score - _FORGIVEN)
            self._good += 1
            self._usable_at = now
            return True
        self._good = 0
        self._score += 1.0
        self.passed_over += self.fault is None
        if self._score >= self.settings.bad_readings or bad[0] == 'feedback_frozen':
            self._trip(*bad, now)
        return False

    def _judge(self, now: float, stamp: float, value: float, clock: float | None, refused: str
               ) -> tuple[str, str] | None:
        settings = self.settings
        before, self._stamp = self._stamp, stamp
        if refused:
            return 'feedback_joint', refused
        if not math.isfinite(value):
            return 'feedback_not_finite', f'{value}'
        if stamp <= before:
            return 'feedback_time', f'{stamp:.3f} s after {before:.3f} s'
        if clock is not None and 0.0 < settings.stamp_tolerance < abs(clock - stamp):
            return 'feedback_time', (
                f'{abs(clock - stamp):.3g} s {"old" if stamp < clock else "in the future"}'
                + ('' if clock else ': the clock stands at 0; does anybody publish /clock?'))
        if abs(value) > settings.speed_limit:
            return 'feedback_out_of_range', f'{value:.4g} rad/s, limit {settings.speed_limit:g}'
        # A reading that was passed over as no number in its range gives the next one its time.
        last, passed = self._value, stamp - min(before, self._compared)
        self._compared = stamp
        if abs(value - last) > settings.acceleration_limit * passed and math.isfinite(last):
            if self.fault:
                self._value = value    # so that a new level is taken in before the reset
            return 'feedback_jumps', f'from {last:.4g} to {value:.4g} rad/s'
        if value != last or value == 0.0:
            self._same_since = now
        self._value = value
        if 0.0 < settings.frozen_timeout < now - self._same_since:
            return 'feedback_frozen', f'{value:.6g} rad/s for {now - self._same_since:.3g} s'
        return None

    def wish(self, now: float, value: float) -> bool:
        """Judge a set point (rad/s), or manual command (V); return whether it may be used."""
        self._wanted_at = now
        self._wish_fault = None
        low, high = self._wishes
        if not low <= value <= high:      # a comparison with NaN is false
            unit = 'V' if self.manual else 'rad/s'
            self._wish_fault = ('command_invalid' if self.manual else 'setpoint_invalid',
                                f'{value:.4g} {unit}, expected {low:g} to {high:g}')
            self._trip(*self._wish_fault, now)
        self._at_rest = value == self.rest
        self.held = self.held and not self._at_rest
        return self._wish_fault is None

    def press(self, source: str, pressed: bool, now: float) -> bool:
        """Take an emergency stop, or its release, from a source; return whether it is new."""
        new = pressed != (source in self._pressed)
        if pressed:
            self._pressed.add(source)
            self._trip('emergency_stop', f'by {source}', now)
        else:
            self._pressed.discard(source)
        return new

    def end(self, now: float) -> None:
        """Go to 0 V for good, as fast as after an emergency stop."""
        self._ending = True
        if self.fault is None:
            self.fault = Fault('shutdown', '', now)

    def inherit(self, before: Supervisor) -> None:
        """Go on with the stop that an earlier supervisor of the same drive was in."""
        self._pressed, self.held = before._pressed, self.held or before.held
        if before.fault and before.fault.kind != 'shutdown':
            self.fault = before.fault

    def formed(self, now: float, command: float) -> bool:
        """Judge what the law has made as a command (V); return whether it may be sent."""
        if not self.limits[0] <= command <= self.limits[1]:
            self._trip('command_invalid', f'the law gives {command:.4g} V', now)
            return False
        return not self.held

    def lags(self, now: float, setpoint: float, speed: float, command: float) -> bool:
        """
        Judge what no single reading shows: that the speed does not follow the set point.

        It does not if it stays apart, comes no nearer, and the command sits at its limit or
        moves on all the same: a motor that does not turn, a sensor on another shaft, a stall.

        Parameters
        ----------
        now : float
            s.
        setpoint, speed : float
            rad/s; a speed that is not a number (a reading passed over) changes nothing.
        command : float
            What the law made of them, V.

        """
        settings, (low, high) = self.settings, self.limits
        error, apart = setpoint - speed, self._apart
        if math.isnan(error) or not settings.following_error_timeout:
            return False
        if abs(error) <= max(settings.following_error_limit, _SHARE * abs(setpoint)):
            self._apart = None
            return False
        if apart is None or error * apart.error <= _NEARER * apart.error**2:
            self._apart = _Apart(now, error, command)
        elif (lasts := now - apart.since) > settings.following_error_timeout:
            moved = math.copysign(1.0, error) * (command - apart.command)
            at_limit = command == (high if error > 0.0 else low)
            if at_limit or moved > _MOVED * (high - max(low, 0.0)):
                self._trip('following_error', f'{speed:.4g} rad/s where {setpoint:.4g} rad/s is '
                           f'set, at {command:.4g} V, for {lasts:.3g} s', now)
            self._apart = _Apart(now, error, command)
        return self.fault is not None

    def check(self, now: float) -> None:
        """Look for what has not come in time."""
        if self.fault is None and not any(self.missing):
            for cause in self._overdue(now):
                self._trip(*cause, now)

    def _overdue(self, now: float) -> list[tuple[str, str]]:
        settings, found = self.settings, []
        if self._usable_at is not None and now - self._usable_at > settings.feedback_timeout:
            found.append(('feedback_lost', f'for {now - self._usable_at:.3g} s'))
        if settings.setpoint_timeout and self._wanted_at is not None and (
                now - self._wanted_at > settings.setpoint_timeout):
            found.append(('setpoint_lost', f'for {now - self._wanted_at:.3g} s'))
        return found

    def _trip(self, kind: str, found: str, now: float) -> None:
        # A first fault is the one to tell; only an emergency stop outranks it: it is faster.
        if self.fault is None or (kind == 'emergency_stop' != self.fault.kind):
            self.fault = Fault(kind, found, now)

    def ramp(self, now: float, command: float) -> float:
        """
        Return the command (V) of the ramp to 0 V.

        Parameters
        ----------
        now : float
            s.
        command : float
            What was sent last, V.

        """
        settings = self.settings
        if self._ramp is None:
            self._ramp = Ramp(min(self.fault.time, now), command)
        time = (settings.emergency_stop_time if self._ending or self.fault.kind == 'emergency_stop'
                else settings.stop_time)
        return self._ramp.follow(now, max(self.limits[1], -self.limits[0]) / time)

    def causes(self, now: float) -> list[str]:
        """Return what stands against a reset; empty if nothing does."""
        found = [f'emergency stop is pressed ({name})' for name in sorted(self._pressed)]
        found += [FAULTS[kind] for kind, _ in self._overdue(now)]
        if self._bad:
            found.append(FAULTS[self._bad[0]])
        elif self._usable_at is not None and self._good < self.settings.bad_readings:
            found.append('too few good readings yet')
        if self._wish_fault:
            found.append(FAULTS[self._wish_fault[0]])
        if self.settings.start_after_reset and self.state == STOPPING:
            found.append('the command is not at 0 V yet')
        return found

    def reset(self, now: float) -> list[str]:
        """End the fault if its cause is gone; return what stands against it, else nothing."""
        found = self.causes(now)
        if self.fault and not found:
            self.held = not self._at_rest and (self.held or self.settings.start_after_reset)
            self.fault = self._ramp = self._apart = None
            self._score = 0.0
            self._same_since = now
        return found

    def start(self) -> list[str]:
        """Let the drive go after a reset; return what stands against it, else nothing."""
        if self.fault:
            return [f'{self.state}: {self.fault}']
        if any(self.missing):
            return ['no reading or no set point has come yet']
        self.held = False
        return []
