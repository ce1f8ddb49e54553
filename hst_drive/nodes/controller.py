# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The PI law as a node: speed reading in, pump command out."""
from __future__ import annotations

import math
import sys
import time

from hst_drive.control import PiController, SafetySettings, Supervisor
from hst_drive.control.safety import RUNNING
from hst_drive.errors import InputError
from hst_drive.nodes import sync
from hst_drive.nodes.audit import Audit
from hst_drive.nodes.base import DriveNode, main as run_node
from hst_drive.nodes.controller_parameters import PARAMETERS
from hst_drive.nodes.controller_status import Status, STATUS_PERIOD
from hst_drive.nodes.endpoints import BILLION
from hst_drive.nodes.forward import ForwardedOutput
from hst_drive.nodes.mapped import map_of, MappedInput, search_for
from hst_drive.nodes.pace import Pace
from hst_drive.nodes.stopping import StopInputs

_PATIENCE = 1.25   # sample times without a reading after which the last one is used once more


class Controller(DriveNode):
    """
    Answers every speed reading with a pump command.

    A new command is formed once per sample time, in real time with the last reading if no new
    one has come; readings that come faster are answered with the command that holds. A fault
    (``hst_drive.control.safety``) brings the command to 0 V on a ramp, at the readings' pace in
    lockstep, else at its own; /diagnostics says why.
    """

    role = 'controller'
    _command = 0.0
    parameters = PARAMETERS

    def __init__(self):
        super().__init__()
        self._audit = Audit(self, self._tell)
        self._law: PiController | None = None
        self._stops: StopInputs | None = None
        self.add_post_set_parameters_callback(self._change)

    def configure(self) -> None:
        """Build the control law."""
        settings = self.settings
        self._map = map_of(self)
        before = self._watch if self._law else None
        try:
            self._law = PiController(
                settings['kp'], settings['ki'], settings['sample_time'],
                (settings['u_clamp_min'], settings['u_clamp_max']),
                antiwindup_strategy=settings['antiwindup_strategy'],
                dead_band=settings['dead_band'])
            self._watch = Supervisor(
                SafetySettings(**{name: settings[name] for name in vars(SafetySettings())}),
                (settings['u_clamp_min'], settings['u_clamp_max']),
                manual=settings['mode'] == 'open_loop')
            if before:
                self._watch.inherit(before)
        except ValueError as error:
            raise InputError(f'controller: {error}') from None
        start = settings['start_command']
        if settings['u_clamp_min'] <= start <= settings['u_clamp_max'] and not self._watch.held:
            self._law.reset(start)
        self._manual = settings['mode'] == 'open_loop'
        self._wanted = 'manual_pump_command' if self._manual else 'speed_setpoint'
        self._pace = Pace(round(settings['sample_time'] * BILLION), on_grid=self.lockstep)
        self._command = 0.0 if self._watch.held else self._law.command
        self._reading: tuple[int, float] | None = None
        self._setpoint: float | None = None
        self._setpoints: dict[int, float] = {}   # lockstep: by stamp, until their reading comes
        self._runs = False
        self._due = 0.0         # when the timer has something to do
        self._ended = False

    def activate(self) -> None:
        """Open the endpoints."""
        self.publish_to('pump_command')
        if self.settings['forward_to']:
            self.outputs['pump_command'] = ForwardedOutput(self, self.outputs['pump_command'])
        self._listen()
        self._status = Status(self, self._audit, self._wanted)
        self._stops = StopInputs(self, self._audit, self._press, self._reset,
                                 self._watch.start)
        super().activate()
        if not self.lockstep:
            self._timer = self.create_timer(
                self.settings['sample_time'], self._supervise, clock=self.wall)
            self.create_timer(STATUS_PERIOD, self._look, clock=self.wall)

    def _listen(self) -> None:
        if 'motor_speed' in self._map.entries:
            self.inputs['motor'] = MappedInput(
                self, self._map, 'motor_speed', lambda stamp, value: self._measured(
                    stamp, (math.nan, value)), self.settings['feedback_timeout'])
        else:
            self.listen_to('motor', self._measured, 'joint')
        for name in ('speed_setpoint', 'manual_pump_command'):
            if name in self._map.entries:
                self.inputs[name] = MappedInput(
                    self, self._map, name, lambda stamp, value, name=name: self._wants(
                        name, stamp, value), self.settings['setpoint_timeout'])
            else:
                self.listen_to(name, lambda stamp, values, name=name: self._wants(
                    name, stamp, values[0]))
        search_for(self)

    def deactivate(self) -> None:
        """Leave with the pump at zero: nobody else would take the last command back."""
        # In a simulated run the plant ends at the same time.
        if self.lockstep or self.partners or not self.outputs or self._stops is None:
            return
        self._audit.note(f'the drive ends; it was {self._watch.state}, at {self._command:.4g} V')
        if not self._command:
            return
        self._watch.end(self._seconds())
        while self._command:
            self._follow_ramp(self.now())
            time.sleep(min(self.settings['sample_time'], 0.02))
        self._tell()

    def said(self, name: str, word: str, stamp: int, counts: dict[str, int]) -> None:
        """Take the plant's last word: from then on nothing is missing."""
        super().said(name, word, stamp, counts)
        self._ended = self._ended or word == sync.LAST

    def _change(self, parameters) -> None:
        """Take new gains over, all at once and without a jump; rclpy has judged their range."""
        gains = {entry.name: entry.value for entry in parameters if entry.name in ('kp', 'ki')}
        self.settings.update(gains)
        if self._law:
            self._law.retune(gains.get('kp', self._law.kp), gains.get('ki', self._law.ki))
        if gains:
            self.get_logger().info(', '.join(f'{name} is {value:g} now'
                                             for name, value in gains.items()))

    def _seconds(self, stamp: int | None = None) -> float:
        """Return the time of the supervisor: the step's, or one that no clock jump moves."""
        return stamp / BILLION if self.lockstep and stamp is not None else time.monotonic()

    def _measured(self, stamp: int, values: tuple[float, ...]) -> None:
        now = self._seconds(stamp)
        clock = None if self.lockstep else self.now() / BILLION
        usable = self._watch.feedback(now, stamp / BILLION, values[1], clock,
                                      self.inputs['motor'].refused)
        self._reading = (stamp, values[1] if usable else math.nan)
        if not self.lockstep:
            self._go_on()
            if self._watch.fault is None:
                self._due = now + _PATIENCE * self.settings['sample_time']
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
        self._note_start()
        if self._watch.fault:
            if self.lockstep:
                self._follow_ramp(stamp)
                self.answers.done(stamp)
            return
        elapsed = self._pace.due(stamp if self.lockstep else time.monotonic_ns())
        if elapsed and not self._watch.held:
            self._form(self._seconds(stamp), self._reading[1], elapsed)
        self.outputs['pump_command'].publish(stamp, self._command)
        if self.lockstep:
            self.answers.done(stamp)

    def _note_start(self) -> None:
        before, self._runs = self._runs, self._watch.state == RUNNING
        if self._runs and not before and not self.partners:
            self._audit.note(f'the drive starts; {self._wanted} is {self._setpoint:.4g} '
                             f'({self._audit.writers(self.inputs[self._wanted].name)})')

    def _form(self, now: float, speed: float, elapsed: float) -> None:
        """Form a new command; keep the last one if it is none to send."""
        if self._setpoint is None:
            command = max(self._law.u_clamp_min, 0.0)
        elif self._manual:
            command = self._setpoint
        else:
            command = self._law.update(self._setpoint, speed, elapsed)
        controls = self._setpoint is not None and not self._manual
        if self._watch.formed(now, command) and not (
                controls and self._watch.lags(now, self._setpoint, speed, command)):
            self._command = command

    def _go_on(self) -> None:
        """In real time: look for what is missing, and send a command."""
        if not self._ended:
            self._watch.check(self._seconds())
        self._answer(self.now())

    def _supervise(self) -> None:
        """In real time: go on without a new reading, or down the ramp, whatever comes or not."""
        early = self._due - self._seconds()
        if early > 0.0 and not self._watch.fault:
            self._wait(early)
            return
        if self._reading and not self._ended:
            self._go_on()
        if self._watch.fault:
            self._follow_ramp(self.now())
        self._wait(self.settings['sample_time'])

    def _wait(self, seconds: float) -> None:
        """
        Let the timer come after so long.

        Only the timer sets itself anew, no reading does: see ``steady_timers``.
        """
        period = round(seconds * BILLION)
        if self._timer.timer_period_ns != period:   # else it keeps its own time
            self._timer.timer_period_ns = period
            self._timer.reset()

    def _follow_ramp(self, stamp: int) -> None:
        out = self.outputs['pump_command']
        before = self._command if out.published else 0.0     # a start command is not yet sent
        self._command = self._watch.ramp(self._seconds(stamp), before)
        out.publish(stamp, self._command)
        if not self._status.is_told(self._watch):
            self._tell(stamp)

    def _press(self, source: str, pressed: bool) -> bool:
        return self._watch.press(source, pressed, self._seconds(self._stamp()))

    def _reset(self) -> list[str]:
        """End the stop, or return what stands against it; go on from the command that holds."""
        stopped = self._watch.fault
        against = self._watch.reset(self._seconds(self._stamp()))
        if stopped and not against:
            self._law.reset(self._command)
            self._pace.restart()
        return against

    def _stamp(self) -> int:
        return self._reading[0] if self.lockstep and self._reading else self.now()

    def _look(self) -> None:
        """Tell as often as it is known how often messages come."""
        if self._status.count():
            self._tell()

    def _tell(self, stamp: int | None = None) -> None:
        """Say on /diagnostics how it stands."""
        self._status.tell(self._stamp() if stamp is None else stamp,
                          self._seconds(self._stamp()), self._watch, self._command)


def main() -> int:
    """Run the node."""
    return run_node(Controller)


if __name__ == '__main__':
    sys.exit(main())
