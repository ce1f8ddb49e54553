# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Brings managed nodes up in order, watches them, and takes them down in the opposite order."""
from __future__ import annotations

import argparse
import math
import signal
import sys
import time

from hst_drive.errors import InputError
from hst_drive.nodes.diagnostics import Diagnostics, ERROR, HARDWARE, OK, WARN
from hst_drive.nodes.parameters import declare, Parameter
from hst_drive.nodes.refusals import CANNOT_START, cannot_start, tell_wrong_input, WRONG_INPUT
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import GetParameters, SetParameters
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args
from std_srvs.srv import Trigger

_GOALS = {'configure': (Transition.TRANSITION_CONFIGURE, State.PRIMARY_STATE_INACTIVE),
          'activate': (Transition.TRANSITION_ACTIVATE, State.PRIMARY_STATE_ACTIVE),
          'deactivate': (Transition.TRANSITION_DEACTIVATE, State.PRIMARY_STATE_INACTIVE),
          'cleanup': (Transition.TRANSITION_CLEANUP, State.PRIMARY_STATE_UNCONFIGURED)}
_ANSWER = 1.0       # s until an answer is taken for lost, or the node for busy
_FAREWELL = 2.0     # s, for each step on the way down
_BEAT = 0.5         # s between two questions to the nodes, and between two looks at the answers
_TURN = 0.1         # s; how soon a signal is seen
_ACTIVE, _SILENT = 'active', 'silent'
_NEW = 'unconfigured'   # of a process that was started anew, or cleaned up by hand
_HELD = 'wait_for_start'    # the controller's parameter


class Refused(Exception):
    """A node is not where it should be; the text says which and where."""


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
        HARDWARE._replace(at_start=True),
    )

    def __init__(self):
        super().__init__('manager', namespace='drive')
        self.settings = settings = declare(self, self.parameters)
        self.names, self.patience = settings['nodes'], settings['patience']
        self._bring_back = settings['bring_back']
        if not self.names:
            raise InputError('manager: parameter nodes is empty; name the nodes to bring up')
        self._spinner = SingleThreadedExecutor()
        self._spinner.add_node(self)
        self.up: list[str] = []
        self._clients_of = {name: (self.create_client(ChangeState, f'{name}/change_state'),
                                   self.create_client(GetState, f'{name}/get_state'))
                            for name in self.names}
        self._parameters_of = {
            name: (self.create_client(GetParameters, f'{name}/get_parameters'),
                   self.create_client(SetParameters, f'{name}/set_parameters'))
            for name in self.names}
        # State as last told, and when it was (s of the steady clock).
        self._answers = {name: (_SILENT, -math.inf) for name in self.names}
        self._asked: dict[str, tuple[Future, float]] = {}   # and when
        self._states = dict.fromkeys(self.names, _SILENT)
        self._diagnostics = Diagnostics(self)
        self._brought_back, self._next = 0, 0.0
        self.create_service(Trigger, '~/is_active', self._say_active)

    def bring_up(self) -> None:
        """Configure all, then activate all."""
        for step in ('configure', 'activate'):
            for name in self.names:
                self._go(name, step)
                if name not in self.up:
                    self.up.append(name)
                self.get_logger().info(f'{name}: {step}d')
        self._answers = {name: (_ACTIVE, time.monotonic()) for name in self.names}
        self._states = dict.fromkeys(self.names, _ACTIVE)

    def watch(self) -> None:
        """
        Work until the next beat: tell what is not active, bring up what has come back.

        All nodes are asked in each beat; one that is dead keeps the others from nothing.
        """
        end = min(time.monotonic() + _TURN, self._next)
        while (left := end - time.monotonic()) > 0.0:
            self._spinner.spin_once(timeout_sec=left)
        if time.monotonic() < self._next:
            return
        self._next = time.monotonic() + _BEAT
        for name in self.names:
            self._look(name)
        self._tell()

    def _look(self, name: str) -> None:
        state, at = self._answers[name]
        if time.monotonic() - at > self.settings['heartbeat_timeout']:
            state = _SILENT
        before, self._states[name] = self._states[name], state
        self._ask(name)
        if state == before:
            return
        if state == _ACTIVE:
            self.get_logger().info(f'{name}: is active again')
        elif self._bring_back and state == _NEW:
            self.get_logger().error(f'{name}: is {state}; it is brought up again')
            self._bring_up_again(name)
        else:
            self.get_logger().error(f'{name}: is {state}' + (
                '; start it again' if state == _SILENT else
                '; configure and activate it' + ', or give bring_back:=true' * (
                    not self._bring_back)))

    def _ask(self, name: str) -> None:
        client, now = self._clients_of[name][1], time.monotonic()
        asked, since = self._asked.get(name, (None, -math.inf))
        if asked and not asked.done():
            if now - since < _ANSWER:
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
            ERROR if _SILENT in self._states.values() else WARN if absent else OK,
            absent or 'all nodes are active',
            {**self._states, 'brought_back': self._brought_back})

    def absent(self) -> str:
        """Return which nodes are not active, and what they are; '' if all are."""
        return ', '.join(f'{name} is {state}' for name, state in self._states.items()
                         if state != _ACTIVE)

    def _say_active(self, request, response):
        absent = self.absent()
        response.success, response.message = not absent, absent or 'all nodes are active'
        return response

    def _bring_up_again(self, name: str) -> None:
        try:
            self._hold(name)
            for step in ('configure', 'activate'):
                self._go(name, step)
            self._brought_back += 1
        except Refused as problem:
            self.get_logger().error(str(problem))
        # Nobody was asked meanwhile.
        now = time.monotonic()
        self._answers = {other: (state, now) for other, (state, _) in self._answers.items()}

    def _hold(self, name: str) -> None:
        """Let a controller that was started anew wait for a start: nobody expects a motion."""
        ask, put = self._parameters_of[name]
        if self._answer(name, ask, GetParameters.Request(names=[_HELD])).values and not (
                self._answer(name, put, SetParameters.Request(parameters=[RosParameter(
                    _HELD, value=True).to_parameter_msg()])).results[0].successful):
            # As it is configured already: by somebody else.
            raise Refused(f'{name}: {_HELD} cannot be set; configure and activate it yourself')

    def _answer(self, name: str, client, request):
        """Return the answer to what may be asked twice."""
        end = time.monotonic() + self.patience
        while time.monotonic() < end:
            if client.wait_for_service(timeout_sec=_ANSWER):
                asked = client.call_async(request)
                if self._wait(asked):
                    return asked.result()
                client.remove_pending_request(asked)
        raise Refused(f'{name}: does not answer {client.srv_name}')

    def _state_of(self, name: str) -> str:
        ask = self._clients_of[name][1]
        if not ask.service_is_ready():
            return _SILENT
        asked = ask.call_async(GetState.Request())
        if self._wait(asked):
            return asked.result().current_state.label
        ask.remove_pending_request(asked)
        return _SILENT

    def bring_down(self) -> None:
        """Deactivate and clean up what is up and still there, last things first."""
        # A launch that ends sends all of them home at once and gives us five seconds.
        self.patience = min(self.patience, _FAREWELL)
        for name in reversed(self.up):
            for step in ('deactivate', 'cleanup'):
                if not self._clients_of[name][0].service_is_ready():
                    break
                try:
                    self._go(name, step)
                except Refused as problem:
                    # What a launch has ended meanwhile went home by itself.
                    if self._state_of(name) != _SILENT:
                        self.get_logger().warning(str(problem))
                    break
        self.up.clear()

    def _go(self, name: str, step: str) -> None:
        number, goal = _GOALS[step]
        change, ask = self._clients_of[name]
        for client in (change, ask):
            if not client.wait_for_service(timeout_sec=self.patience):
                raise Refused(f'{name}: no such managed node; start it with --managed')
        future = change.call_async(ChangeState.Request(transition=Transition(id=number)))
        end, state = time.monotonic() + self.patience, None
        while time.monotonic() < end:
            # An answer may be lost while endpoints find each other: what counts is the state.
            if self._wait(future) and future.result().success:
                return
            asked = ask.call_async(GetState.Request())
            state = asked.result().current_state if self._wait(asked) else None
            if state is not None and state.id == goal:
                return
            if future.done() and state is not None:
                break
            if state is not None:
                # It answers, but not this: one that was restarted may have found only one of the
                # two clients by then. A second transition that does not fit does no harm.
                future = change.call_async(ChangeState.Request(transition=Transition(id=number)))
        raise Refused(f'{name}: does not {step}; it is {state.label if state else "silent"}, '
                      'its log says why')

    def _wait(self, future) -> bool:
        self._spinner.spin_until_future_complete(future, timeout_sec=min(self.patience, _ANSWER))
        return future.done()


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
        node.bring_up()
        print('all nodes are active', flush=True)
        while not signals:
            node.watch()
    except Refused as problem:
        print(f'manager: {problem}', file=sys.stderr, flush=True)
        code = 1
    except WRONG_INPUT as error:
        tell_wrong_input('manager', error)
        code = 2
    except CANNOT_START as error:
        if node is not None:
            raise
        print(f'manager: {cannot_start(str(error))}', file=sys.stderr, flush=True)
        code = 1
    finally:
        if node is not None:
            node.bring_down()
            node.destroy_node()
        rclpy.try_shutdown()
    return code


if __name__ == '__main__':
    sys.exit(main())
