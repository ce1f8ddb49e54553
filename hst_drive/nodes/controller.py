# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The PI law as a node: speed reading in, pump command out."""
from __future__ import annotations

import sys

from hst_drive.control import PiController
from hst_drive.errors import InputError
from hst_drive.nodes.base import DriveNode, main as run_node
from hst_drive.nodes.endpoints import BILLION
from hst_drive.nodes.parameters import Parameter
from rcl_interfaces.msg import SetParametersResult

_MODES = ('closed_loop', 'open_loop')


class Controller(DriveNode):
    """
    Answers every speed reading with a pump command.

    A new command is formed once per sample time; readings that come faster are answered with
    the command that holds.
    """

    role = 'controller'
    parameters = (
        Parameter('mode', 'closed_loop', 'closed_loop: PI on the speed; open_loop: pass the '
                  'manual command on'),
        Parameter('kp', 0.02, 'proportional gain', 'V.s/rad', 0.0, 10.0, live=True),
        Parameter('ki', 0.45, 'integral gain', 'V/rad', 0.0, 100.0, live=True),
        Parameter('sample_time', 0.01, 'time between two commands', 's', 0.0005, 1.0),
        Parameter('u_clamp_min', 0.0, 'smallest command', 'V', 0.0, 10.0),
        Parameter('u_clamp_max', 10.0, 'largest command', 'V', 0.0, 10.0),
        Parameter('start_command', -1.0, 'first command, for a bumpless start; -1: none', 'V',
                  -1.0, 10.0),
        Parameter('antiwindup_strategy', 'conditional_integration',
                  'conditional_integration, back_calculation or none'),
    )

    def configure(self) -> None:
        """Build the control law."""
        settings = self.settings
        if settings['mode'] not in _MODES:
            raise InputError(f"controller: parameter mode is '{settings['mode']}'; expected one "
                             f'of {", ".join(_MODES)}')
        try:
            self._law = PiController(
                settings['kp'], settings['ki'], settings['sample_time'],
                (settings['u_clamp_min'], settings['u_clamp_max']),
                antiwindup_strategy=settings['antiwindup_strategy'])
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
        self.add_on_set_parameters_callback(self._change)

    def activate(self) -> None:
        """Open the endpoints."""
        self.publish_to('pump_command')
        self.listen_to('motor', self._measured)
        self.listen_to('speed_setpoint', lambda stamp, values: self._wants(
            'speed_setpoint', stamp, values[0]))
        self.listen_to('manual_pump_command', lambda stamp, values: self._wants(
            'manual_pump_command', stamp, values[0]))
        super().activate()

    def _change(self, parameters) -> SetParametersResult:
        """Take new gains over, all at once."""
        for parameter in parameters:
            if parameter.name in ('kp', 'ki'):
                setattr(self._law, parameter.name, parameter.value)
        return SetParametersResult(successful=True)

    def _measured(self, stamp: int, values: tuple[float, ...]) -> None:
        self._reading = (stamp, values[1])
        if not self.lockstep:
            self._answer(self.now())
        elif stamp in self._setpoints:
            self._setpoint = self._setpoints.pop(stamp)
            self._answer(stamp)

    def _wants(self, name: str, stamp: int, value: float) -> None:
        if name != self._wanted:
            return
        if not self.lockstep:
            self._setpoint = value
        elif self._reading and self._reading[0] == stamp:
            self._setpoint = value
            self._answer(stamp)
        else:
            self._setpoints[stamp] = value

    def _answer(self, stamp: int) -> None:
        read_at, speed = self._reading
        # Half a sample of slack: readings of a real clock are never quite on their grid.
        if self._last is None or read_at - self._last > self._sample_time * 0.5:
            self._last = self._due(read_at)
            if self._setpoint is None:
                self._command = self._law.u_clamp_min
            elif self._manual:
                self._command = min(max(self._setpoint, self._law.u_clamp_min),
                                    self._law.u_clamp_max)
            else:
                self._command = self._law.update(self._setpoint, speed)
        self.outputs['pump_command'].publish(stamp, self._command)
        if self.lockstep:
            self.answers.done(stamp)

    def _due(self, read_at: int) -> int:
        """Return the grid time of this sample, so that slack does not add up."""
        if self._last is None or read_at - self._last > 2 * self._sample_time:
            return read_at
        return self._last + self._sample_time


def main() -> int:
    """Run the node."""
    return run_node(Controller)


if __name__ == '__main__':
    sys.exit(main())
