# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Brings managed nodes up in order, watches them, and takes them down in the opposite order."""
from __future__ import annotations

import argparse
import signal
import sys
import time

from hst_drive.errors import InputError
from hst_drive.nodes.parameters import declare, Parameter
from hst_drive.nodes.refusals import CANNOT_START, cannot_start, tell_wrong_input, WRONG_INPUT
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

_GOALS = {'configure': (Transition.TRANSITION_CONFIGURE, State.PRIMARY_STATE_INACTIVE),
          'activate': (Transition.TRANSITION_ACTIVATE, State.PRIMARY_STATE_ACTIVE),
          'deactivate': (Transition.TRANSITION_DEACTIVATE, State.PRIMARY_STATE_INACTIVE),
          'cleanup': (Transition.TRANSITION_CLEANUP, State.PRIMARY_STATE_UNCONFIGURED)}
_ANSWER = 1.0       # s until an answer is taken for lost, or the node for busy
_FAREWELL = 2.0     # s, for each step on the way down
_LOOK = 1.0         # s between two looks at the nodes
_ACTIVE, _SILENT = 'active', 'silent'


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
        Parameter('bring_back', False, 'bring a node up again that was restarted; with a '
                  'controller that may move the bit', at_start=True),
    )

    def __init__(self):
        super().__init__('manager', namespace='drive')
        settings = declare(self, self.parameters)
        self.names, self.patience = settings['nodes'], settings['patience']
        self._bring_back = settings['bring_back']
        self._seen: dict[str, str] = {}     # state by node, where it is not active
        if not self.names:
            raise InputError('manager: parameter nodes is empty; name the nodes to bring up')
        self._spinner = SingleThreadedExecutor()
        self._spinner.add_node(self)
        self.up: list[str] = []
        self._clients_of = {name: (self.create_client(ChangeState, f'{name}/change_state'),
                                   self.create_client(GetState, f'{name}/get_state'))
                            for name in self.names}

    def bring_up(self) -> None:
        """Configure all, then activate all."""
        for step in ('configure', 'activate'):
            for name in self.names:
                self._go(name, step)
                if name not in self.up:
                    self.up.append(name)
                self.get_logger().info(f'{name}: {step}d')

    def watch(self) -> None:
        """Tell what is no longer active; bring up what has come back, if that is asked for."""
        for name in self.names:
            state, before = self._state_of(name), self._seen.pop(name, _ACTIVE)
            if state != _ACTIVE:
                self._seen[name] = state
            if state == before:
                continue
            if state == _ACTIVE:
                self.get_logger().info(f'{name}: is active again')
            elif self._bring_back and state != _SILENT:
                self.get_logger().error(f'{name}: is {state}; it is brought up again')
                self._bring_up_again(name)
            else:
                self.get_logger().error(f'{name}: is {state}' + (
                    '; start it again' if state == _SILENT else
                    '; configure and activate it, or give bring_back:=true'))

    def _bring_up_again(self, name: str) -> None:
        try:
            for step in ('configure', 'activate'):
                self._go(name, step)
        except Refused as problem:
            self.get_logger().error(str(problem))

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
        looked = time.monotonic()
        while not signals:
            time.sleep(0.1)
            if time.monotonic() - looked > _LOOK:
                node.watch()
                looked = time.monotonic()
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
