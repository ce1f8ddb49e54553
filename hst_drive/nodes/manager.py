# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Brings managed nodes up in order, watches them, and takes them down in the opposite order."""
from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import suppress
import math
import signal
import sys
import time

from hst_drive.errors import InputError
from hst_drive.nodes.attempts import Attempts
from hst_drive.nodes.diagnostics import Diagnostics, ERROR, HARDWARE, OK, WARN
from hst_drive.nodes.parameters import declare, Parameter, PRIORITY
from hst_drive.nodes.priority import go_before_others
from hst_drive.nodes.refusals import REFUSALS, tell_refusal
from hst_drive.nodes.transitions import ANSWER, Refused, SILENT, Transitions
from lifecycle_msgs.srv import GetState
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args
from std_srvs.srv import Trigger

_FAREWELL = 2.0     # s, for each step on the way down
_BEAT = 0.5         # s between two questions to the nodes, and between two looks at the answers
_TURN = 0.1         # s; how soon a signal is seen
_ACTIVE, _INACTIVE = 'active', 'inactive'
_NEW = 'unconfigured'   # of a process that was started anew, or cleaned up by hand


class Manager(Node):
    """Takes the nodes of its parameter, in its own namespace, through their states."""

    role = 'manager'
    parameters = (
        Parameter('nodes', [], 'nodes to bring up, in this order', at_start=True,
                  form='names of managed nodes in the same namespace'),
        Parameter('patience', 20.0, 'how long to wait for a node and for its answer', 's', 0.1,
                  3600.0, at_start=True),
        Parameter('heartbeat_timeout', 2.0, 'a node that has not answered for so long is told as '
                  'silent', 's', 1.5, 60.0, at_start=True),
        Parameter('bring_back', False, 'bring a node up again that was restarted; a controller '
                  'then waits for a start', at_start=True),
        Parameter('attempts', 5, 'with bring_back: how often in a row a node that refuses is '
                  'brought up', low=1, high=1000, at_start=True),
        Parameter('retry_delay', 2.0, 'from the first such attempt to the second; it doubles each '
                  'time, up to 30 s', 's', 0.1, 30.0, at_start=True),
        HARDWARE._replace(at_start=True),
        PRIORITY,
    )

    def __init__(self):
        super().__init__('manager', namespace='drive')
        self.settings = settings = declare(self, self.parameters)
        self.names: list[str] = settings['nodes']
        self._bring_back = settings['bring_back']
        if not self.names:
            raise InputError('manager: parameter nodes is empty; name the nodes to bring up')
        go_before_others(settings['priority'])
        self._spinner = SingleThreadedExecutor()
        self._spinner.add_node(self)
        self.up: list[str] = []
        self._transitions = Transitions(self, self._spinner, self.names, settings['patience'])
        # State as last told, and when it was (s of the steady clock).
        self._answers = {name: (SILENT, -math.inf) for name in self.names}
        self._asked: dict[str, tuple[Future, float]] = {}   # and when
        self._states = dict.fromkeys(self.names, SILENT)
        self._diagnostics = Diagnostics(self)
        self._brought_back, self._next = 0, 0.0
        self._attempts = Attempts(settings['attempts'] if self._bring_back else 1,
                                  settings['retry_delay'])
        self.create_service(Trigger, '~/is_active', self._say_active)

    def bring_up(self, wanted: Callable[[], bool]) -> None:
        """
        Configure all, then activate all, from the start as often as the parameters allow.

        Raises
        ------
        Refused
            If the last attempt fails too, or none is ``wanted`` any more.

        """
        while True:
            try:
                for step in ('configure', 'activate'):
                    for name in self.names:
                        self._transitions.go(name, step)
                        if name not in self.up:
                            self.up.append(name)
                        self.get_logger().info(f'{name}: {step}d')
            except Refused as problem:
                said = self._attempts.refused(self.role, str(problem), time.monotonic())
                if self._attempts.given_up():
                    raise Refused(said if self._bring_back else str(problem)) from None
                self.get_logger().error(f'bring-up: {said}')
                self._take_down()
                self._wait_for_attempt(wanted, problem)
            else:
                break
        self._attempts.forget(self.role)
        self._answers = {name: (_ACTIVE, time.monotonic()) for name in self.names}
        self._states = dict.fromkeys(self.names, _ACTIVE)

    def _wait_for_attempt(self, wanted: Callable[[], bool], problem: Refused) -> None:
        """Tell how it stands until the next attempt is due."""
        while not self._attempts.is_due(self.role, time.monotonic()):
            if not wanted():
                raise problem
            if self._beats():
                self._tell()

    def watch(self) -> None:
        """
        Work until the next beat: tell what is not active, bring up what has come back.

        All nodes are asked in each beat; one that is dead keeps the others from nothing.
        """
        if self._beats():
            for name in self.names:
                self._look(name)
            self._tell()

    def _beats(self) -> bool:
        """Work for a turn, at most until the next beat; return whether it is there."""
        end = min(time.monotonic() + _TURN, self._next)
        while (left := end - time.monotonic()) > 0.0:
            self._spinner.spin_once(timeout_sec=left)
        if time.monotonic() < self._next:
            return False
        self._next = time.monotonic() + _BEAT
        return True

    def _look(self, name: str) -> None:
        state, at = self._answers[name]
        if time.monotonic() - at > self.settings['heartbeat_timeout']:
            state = SILENT
        before, self._states[name] = self._states[name], state
        self._ask(name)
        if state == before:
            if state == _NEW and self._attempts.is_due(name, time.monotonic()):
                self._bring_up_again(name)
            return
        # Another state is somebody else's doing, or another process: attempts count from there.
        self._attempts.forget(name)
        if state == _ACTIVE:
            self.get_logger().info(f'{name}: is active again')
        elif self._bring_back and state == _NEW:
            self.get_logger().error(f'{name}: is {state}; it is brought up again')
            self._bring_up_again(name)
        else:
            self.get_logger().error(f'{name}: is {state}' + (
                '; start it again' if state == SILENT else
                '; configure and activate it' + ', or give bring_back:=true' * (
                    not self._bring_back)))

    def _ask(self, name: str) -> None:
        client, now = self._transitions.clients[name][1], time.monotonic()
        asked, since = self._asked.get(name, (None, -math.inf))
        if asked and not asked.done():
            if now - since < ANSWER:
                return
            # It is lost, or the node that was to give it is dead.
            client.remove_pending_request(asked)
        if client.service_is_ready():
            asked = client.call_async(GetState.Request())
            asked.add_done_callback(lambda done: self._answered(name, done))
            self._asked[name] = asked, now

    def _answered(self, name: str, done: Future) -> None:
        self._answers[name] = done.result().current_state.label, time.monotonic()

    def _tell(self) -> None:
        """Say on /diagnostics how all stand together."""
        absent = self.absent()
        self._diagnostics.publish(
            self.get_clock().now().nanoseconds, f'{self.get_fully_qualified_name()}: nodes',
            ERROR if SILENT in self._states.values() or self._attempts.given_up() else
            WARN if absent else OK, absent or 'all nodes are active',
            {**self._states, 'brought_back': self._brought_back,
             'refused': self._attempts.refusals})

    def absent(self) -> str:
        """Return which nodes are not active, and what they are; '' if all are."""
        absent = [' '.join(filter(None, (f'{name} is {state}', self._attempts.told(name))))
                  for name, state in self._states.items() if state != _ACTIVE]
        return ', '.join(filter(None, (self._attempts.told(self.role), *absent)))

    def _say_active(self, request, response):
        absent = self.absent()
        response.success, response.message = not absent, absent or 'all nodes are active'
        return response

    def _bring_up_again(self, name: str) -> None:
        try:
            self._transitions.hold(name)
            for step in ('configure', 'activate'):
                self._transitions.go(name, step)
            self._brought_back += 1
            self._attempts.forget(name)
        except Refused as problem:
            said = self._attempts.refused(name, str(problem), time.monotonic())
            self.get_logger().error(f'{name}: {said}')
            if self._transitions.state_of(name) == _INACTIVE:
                # It could not be activated: from the start again, with its parameters as they are.
                with suppress(Refused):
                    self._transitions.go(name, 'cleanup')
        # Nobody was asked meanwhile.
        now = time.monotonic()
        self._answers = {other: (state, now) for other, (state, _) in self._answers.items()}

    def bring_down(self) -> None:
        """Deactivate and clean up what is up and still there, last things first."""
        # A launch that ends sends all of them home at once and gives us five seconds.
        self._transitions.patience = min(self._transitions.patience, _FAREWELL)
        self._take_down()

    def _take_down(self) -> None:
        for name in reversed(self.up):
            for step in ('deactivate', 'cleanup'):
                if not self._transitions.clients[name][0].service_is_ready():
                    break
                try:
                    self._transitions.go(name, step)
                except Refused as problem:
                    # What a launch has ended meanwhile went home by itself.
                    if self._transitions.state_of(name) != SILENT:
                        self.get_logger().warning(str(problem))
                    break
        self.up.clear()


def main(args: list[str] | None = None) -> int:
    """Bring the nodes up, wait for SIGINT or SIGTERM, bring them down."""
    signals: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda received, _: signals.append(received))
    node, code = None, 0
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        parser = argparse.ArgumentParser(
            prog='ros2 run hst_drive manager', allow_abbrev=False, description=Manager.__doc__,
            epilog='Parameters: --ros-args -p NAME:=VALUE; docs/parameters.md lists them.')
        own = remove_ros_args(sys.argv if args is None else args)[1:]
        if unknown := parser.parse_known_args(own)[1]:
            raise InputError(f"unknown argument '{unknown[0]}'; give parameters as "
                             '--ros-args -p NAME:=VALUE')
        node = Manager()
        node.bring_up(lambda: not signals)
        print('all nodes are active', flush=True)
        while not signals:
            node.watch()
    except Refused as problem:
        print(f'manager: {problem}', file=sys.stderr, flush=True)
        code = 1
    except REFUSALS as error:
        code = tell_refusal('manager', error, node is not None)
    finally:
        if node is not None:
            node.bring_down()
            node.destroy_node()
        rclpy.try_shutdown()
    return code


if __name__ == '__main__':
    sys.exit(main())
