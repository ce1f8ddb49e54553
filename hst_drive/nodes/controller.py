# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The PI law as a node: speed reading in, pump command out."""
from __future__ import annotations

import math
import sys
import time

from hst_drive.control import PiController, SafetySettings, Supervisor
from hst_drive.control.safety import RUNNING, STOPPED
from hst_drive.errors import InputError
from hst_drive.nodes import sync
from hst_drive.nodes.base import DriveNode, main as run_node
from hst_drive.nodes.diagnostics import Diagnostics, ERROR, OK, WARN
from hst_drive.nodes.endpoints import BILLION
from hst_drive.nodes.parameters import Parameter
from hst_drive.nodes.stopping import StopInputs
from rcl_interfaces.msg import SetParametersResult

_MODES = ('closed_loop', 'open_loop')
_STATUS_PERIOD = 1.0
_DEFAULTS = SafetySettings()


class Controller(DriveNode):
    """
    Answers every speed reading with a pump command.

    A new command is formed once per sample time; readings that come faster are answered with
    the command that holds. A fault (``hst_drive.control.safety``) brings the command to 0 V on a
    ramp, at the readings' pace in lockstep, else at its own; /diagnostics says why.
    """

    role = 'controller'
    _command = 0.0
    parameters = (
        Parameter('mode', 'closed_loop', 'closed_loop: PI on the speed; open_loop: pass the '
                  'manual command on'),
        Parameter('joint', '', 'joint of the topic motor whose speed is held; empty: the only '
                  'one there is'),
        Parameter('kp', 0.02, 'proportional gain', 'V.s/rad', 0.0, 10.0, live=True),
        Parameter('ki', 0.45, 'integral gain', 'V/rad', 0.0, 100.0, live=True),
        Parameter('sample_time', 0.01, 'time between two commands', 's', 0.0005, 1.0),
        Parameter('u_clamp_min', 0.0, 'smallest command', 'V', 0.0, 10.0),
        Parameter('u_clamp_max', 10.0, 'largest command', 'V', 0.0, 10.0),
        Parameter('start_command', -1.0, 'first command, for a bumpless start; -1: none', 'V',
                  -1.0, 10.0),
        Parameter('antiwindup_strategy', 'conditional_integration',
                  'conditional_integration, back_calculation or none'),
        Parameter('feedback_timeout', _DEFAULTS.feedback_timeout, 'longest time without a usable '
                  'speed reading', 's', 0.002, 60.0),
        Parameter('setpoint_timeout', _DEFAULTS.setpoint_timeout, 'longest time without a set '
                  'point or manual command; 0: the last one holds', 's', 0.0, 3600.0),
        Parameter('stamp_tolerance', _DEFAULTS.stamp_tolerance, 'largest difference between the '
                  "readings' stamps and the clock; 0: not judged", 's', 0.0, 3600.0),
        Parameter('frozen_timeout', _DEFAULTS.frozen_timeout, 'longest time with the very same '
                  'reading other than 0; 0: not judged', 's', 0.0, 3600.0),
        Parameter('bad_readings', _DEFAULTS.bad_readings, 'so many bad readings in a row stop the '
                  'drive', low=1, high=1000),
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
    )

    def __init__(self):
        super().__init__()
        self._law: PiController | None = None
        self.add_on_set_parameters_callback(self._judge_change)
        self.add_post_set_parameters_callback(self._change)

    def configure(self) -> None:
        """Build the control law."""
        settings = self.settings
        if settings['mode'] not in _MODES:
            raise InputError(f"controller: parameter mode is '{settings['mode']}'; expected one "
                             f'of {", ".join(_MODES)}')
        before = self._watch if self._law else None
        try:
            self._law = PiController(
                settings['kp'], settings['ki'], settings['sample_time'],
                (settings['u_clamp_min'], settings['u_clamp_max']),
                antiwindup_strategy=settings['antiwindup_strategy'])
            self._watch = Supervisor(
                SafetySettings(**{name: settings[name] for name in vars(_DEFAULTS)}),
                (settings['u_clamp_min'], settings['u_clamp_max']),
                manual=settings['mode'] == 'open_loop')
            if before:
                self._watch.inherit(before)
        except ValueError as error:
            raise InputError(f'controller: {error}') from None
        if settings['start_command'] >= 0.0:
            self._law.reset(settings['start_command'])
        self._manual = settings['mode'] == 'open_loop'
        self._wanted = 'manual_pump_command' if self._manual else 'speed_setpoint'
        self._sample_time = round(settings['sample_time'] * BILLION)
        self._last: int | None = None
        self._command = self._law.command
        self._reading: tuple[int, float] | None = None
        self._setpoint: float | None = None
        self._setpoints: dict[int, float] = {}   # lockstep: by stamp, until their reading comes
        self._usable = True
        self._told: str | None = None
        self._ended = False

    def activate(self) -> None:
        """Open the endpoints."""
        self.publish_to('pump_command')
        self.listen_to('motor', self._measured, 'joint')
        for name in ('speed_setpoint', 'manual_pump_command'):
            self.listen_to(name, lambda stamp, values, name=name: self._wants(
                name, stamp, values[0]))
        self._diagnostics = Diagnostics(self)
        self._stops = StopInputs(self, self._press, self._reset)
        super().activate()
        if not self.lockstep:
            self.create_timer(self.settings['sample_time'], self._supervise, clock=self._wall)
            self.create_timer(_STATUS_PERIOD, self._tell, clock=self._wall)

    def deactivate(self) -> None:
        """Leave with the pump at zero: nobody else would take the last command back."""
        # In a simulated run the plant ends at the same time.
        if self.lockstep or self.partners or not self._command > 0.0:
            return
        self._watch.end(self._seconds())
        while self._command > 0.0:
            self._follow_ramp(self.now())
            time.sleep(min(self.settings['sample_time'], 0.02))
        self._tell()

    def said(self, name: str, word: str, stamp: int, counts: dict[str, int]) -> None:
        """Take the plant's last word: from then on nothing is missing."""
        super().said(name, word, stamp, counts)
        self._ended = self._ended or word == sync.LAST

    def _judge_change(self, parameters) -> SetParametersResult:
        """Accept a set of new gains as a whole or not at all."""
        bad = [f'{entry.name}={entry.value}' for entry in parameters
               if entry.name in ('kp', 'ki') and not math.isfinite(entry.value)]
        return SetParametersResult(successful=not bad, reason=', '.join(bad) + (
            ': expected finite numbers' if bad else ''))

    def _change(self, parameters) -> None:
        """Take new gains over, all at once and without a jump of the command."""
        gains = {entry.name: entry.value for entry in parameters if entry.name in ('kp', 'ki')}
        self.settings.update(gains)
        if self._law:
            self._law.retune(gains.get('kp', self._law.kp), gains.get('ki', self._law.ki))

    def _seconds(self, stamp: int | None = None) -> float:
        """Return the time of the supervisor: the step's, or one that no clock jump moves."""
        return stamp / BILLION if self.lockstep and stamp is not None else time.monotonic()

    def _measured(self, stamp: int, values: tuple[float, ...]) -> None:
        now = self._seconds(stamp)
        clock = None if self.lockstep else self.now() / BILLION
        self._usable = self._watch.feedback(now, stamp / BILLION, values[1], clock,
                                            self.inputs['motor'].refused)
        self._reading = (stamp, values[1] if self._usable else math.nan)
        if not self.lockstep:
            self._answer(self.now())
        elif stamp in self._setpoints:
            self._take(now, self._setpoints.pop(stamp))
            self._answer(stamp)

    def _wants(self, name: str, stamp: int, value: float) -> None:
        if name != self._wanted:
            return
        if not self.lockstep:
            self._take(self._seconds(), value)
        elif self._reading and self._reading[0] == stamp:
            self._take(self._seconds(stamp), value)
            self._answer(stamp)
        else:
            self._setpoints[stamp] = value

    def _take(self, now: float, value: float) -> None:
        if self._watch.wish(now, value):
            self._setpoint = value

    def _answer(self, stamp: int) -> None:
        if self._watch.fault:
            if self.lockstep:
                self._follow_ramp(stamp)
                self.answers.done(stamp)
            return
        read_at, speed = self._reading
        # Half a sample of slack: readings of a real clock are never quite on their grid.
        if self._last is None or not 0 <= read_at - self._last <= self._sample_time * 0.5:
            self._last = self._due(read_at)
            self._form(self._seconds(stamp), speed)
        self.outputs['pump_command'].publish(stamp, self._command)
        if self.lockstep:
            self.answers.done(stamp)

    def _form(self, now: float, speed: float) -> None:
        """Form a new command; keep the last one if it is none to send."""
        if self._setpoint is None:
            command = self._law.u_clamp_min
        elif self._manual:
            command = self._setpoint
        else:
            command = self._law.update(self._setpoint, speed)
        controls = self._setpoint is not None and not self._manual
        if self._watch.formed(now, command) and not (
                controls and self._watch.lags(now, self._setpoint, speed, command)):
            self._command = command

    def _supervise(self) -> None:
        """In real time: look for what is missing, and go down the ramp, whatever comes or not."""
        if not self._ended:
            self._watch.check(self._seconds())
        if self._watch.fault:
            self._follow_ramp(self.now())

    def _follow_ramp(self, stamp: int) -> None:
        out = self.outputs['pump_command']
        before = self._command if out.published else 0.0     # a start command is not yet sent
        self._command = self._watch.ramp(self._seconds(stamp), before)
        out.publish(stamp, self._command)
        if str(self._watch.fault) + self._watch.state != self._told:
            self._tell(stamp)

    def _press(self, source: str, pressed: bool) -> None:
        self._watch.press(source, pressed, self._seconds(self._stamp()))

    def _reset(self) -> list[str]:
        """End the stop, or return what stands against it; go on from the command that holds."""
        against = self._watch.reset(self._seconds(self._stamp()))
        if not against:
            self._law.reset(self._command)
            self._tell()
        return against

    def _stamp(self) -> int:
        return self._reading[0] if self.lockstep and self._reading else self.now()

    def _tell(self, stamp: int | None = None) -> None:
        """Say on /diagnostics how it stands."""
        watch, fault = self._watch, self._watch.fault
        told, self._told = self._told, str(fault) + watch.state
        ended = fault is not None and fault.kind == 'shutdown'
        if fault and self._told != told and not ended:
            self.get_logger().error(f'{fault}; {watch.state}')
        # In lockstep nobody else takes part.
        crowded = {} if self.lockstep else {
            name: count for name in ('pump_command', self._wanted)
            if (count := self.count_publishers(self.resolve_topic_name(name))) > 1}
        if fault:
            message = f'{watch.state}: {fault}' + ('' if ended else '; reset it with ~/reset')
        else:
            message = self._waits() or 'running'
            message += ''.join(f'; {count} nodes publish {name}: only one may'
                               for name, count in crowded.items())
        against = watch.causes(self._seconds(self._stamp())) if fault and not ended else ()
        self._diagnostics.publish(
            self._stamp() if stamp is None else stamp,
            f'{self.get_fully_qualified_name()}: safety',
            WARN if ended else ERROR if fault else
            OK if watch.state == RUNNING and not crowded else WARN, message, {
                'state': watch.state, 'fault': fault.kind if fault else '',
                'found': fault.found if fault else '', 'against_reset': ', '.join(against),
                'command_v': f'{self._command:.4g}',
                'at_zero': str(watch.state == STOPPED).lower(),
                'readings_passed_over': watch.passed_over})

    def _waits(self) -> str:
        """Return for which topics it still waits, and what is there of them; '' if for none."""
        topics = [self.inputs[name].found() for name, absent in zip(('motor', self._wanted),
                                                                    self._watch.missing) if absent]
        return f'waiting for {", ".join(topics)}' if topics else ''

    def _due(self, read_at: int) -> int:
        """Return the grid time of this sample, so that slack does not add up."""
        if self._last is None or not 0 <= read_at - self._last <= 2 * self._sample_time:
            return read_at
        return self._last + self._sample_time


def main() -> int:
    """Run the node."""
    return run_node(Controller)


if __name__ == '__main__':
    sys.exit(main())
