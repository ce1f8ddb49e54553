# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What all nodes share: parameters, endpoints, readiness, the spin loop, a clean end."""
from __future__ import annotations

import argparse
from collections.abc import Callable
import gc
import os
import signal
import sys
import threading
import time
import warnings

from hst_drive.bag.topics import NAMESPACE
from hst_drive.errors import InputError
from hst_drive.nodes import sync, wiring
from hst_drive.nodes.endpoints import Input, Output, partners_of, topic_named
from hst_drive.nodes.parameters import COMMON, declare, Parameter, undeclared
from hst_drive.nodes.priority import go_before_others
from hst_drive.nodes.refusals import REFUSALS, tell_refusal
from hst_drive.nodes.session import PARENT
from hst_drive.nodes.steady_timers import steady_timers
from hst_drive.nodes.watchdog import watched
import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args

GATHER = 0.002
_READY_PERIOD, _WATCH_PERIOD, _PATIENCE = 0.02, 0.5, 5.0
_AGAIN = 0.5    # s; from one word that we are ready to the next
_TURN, _CALL = 0.1, 60.0    # s; how soon a signal is seen, and one call of the executor
_LONGEST_DRAIN = 3.0   # s; publishers that go on must not keep a node from its end
_LONGEST_END = 20.0    # s; nor may the middleware


class DriveNode(Node):
    """
    Base of the nodes; ``role`` is the name by which the partners know it.

    A node on which nobody waits in every step may set ``gather`` (s): it then takes messages in
    such batches, which spares the change of process that each message alone would cost.

    Life: ``__init__`` declares the parameters, ``configure`` builds the pure objects from them,
    ``activate`` opens the endpoints, ``started`` is called when the run may begin,
    ``deactivate`` ends it.
    """

    role = ''
    managed = False
    parameters: tuple[Parameter, ...] = ()

    def __init__(self):
        super().__init__(self.role, namespace=NAMESPACE.strip('/'))
        self.settings = declare(self, COMMON + self.parameters, self.managed)
        self._tell_unused(of_topics=False)
        go_before_others(self.settings['priority'])
        self.partners: list[str] = self.settings['partners']
        self.lockstep: bool = self.settings['lockstep']
        self.taken: tuple[str, ...] = ()
        self.outputs: dict[str, Output] = {}
        self.inputs: dict[str, Input] = {}
        self.exit_code: int | None = None
        self.stopped = Future()
        self.gather = 0.0
        self.sync: sync.Sync | None = None
        self.answers: sync.Answers | None = None
        self.wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._parent = int(os.environ.get(PARENT, 0))

    def configure(self) -> None:
        """Build what the node works with from its parameters."""

    def activate(self) -> None:
        """Open the endpoints and begin to wait for the partners."""
        self.sync = sync.Sync(self, self._said)
        outputs = [(self.resolve_topic_name(name), output)
                   for name, output in self.outputs.items()]
        self.answers = sync.Answers(self.sync, lambda: {
            name: output.published for name, output in outputs})
        self.taken = self.taken or wiring.recorded(
            self.partners, circuit=self.settings['circuit'])
        self._tell_unused(of_topics=True)
        self._waited, self._found = 0.0, False
        self._ready_timer = self.create_timer(_READY_PERIOD, self._check_ready, clock=self.wall)
        if self._parent:
            self.create_timer(_WATCH_PERIOD, self._watch_parent, clock=self.wall)

    def started(self) -> None:
        """Do what is due once all partners are connected."""

    def deactivate(self) -> None:
        """Stop working; called once at the end, whatever the reason is."""

    def drain(self) -> bool:
        """Return whether messages under way must still be taken in before the end."""
        return False

    def publish_to(self, *names: str) -> None:
        """Open publishers of these topics of the table."""
        for name in names:
            self.outputs[name] = Output(self, topic_named(name))

    def listen_to(self, name: str, callback: Callable[[int, tuple[float, ...]], None],
                  joint: str = '') -> None:
        """Open a subscription of a topic of the table; ``joint`` as of ``Input``."""
        self.inputs[name] = Input(self, topic_named(name), callback, joint)

    def now(self) -> int:
        """Return the node's time, ns."""
        return self.get_clock().now().nanoseconds

    def _tell_unused(self, of_topics: bool) -> None:
        for line in undeclared(self, of_topics):
            self.get_logger().warning(line)

    def stop(self, code: int, reason: str = '') -> None:
        """End the spin loop and leave with this code."""
        if reason:
            print(f'{self.role}: {reason}', file=sys.stderr, flush=True)
        if self.exit_code is None:
            self.exit_code = code
            self.stopped.set_result(None)

    def not_connected(self) -> list[str]:
        """Return the names of the topics on which a partner is still missing."""
        others = [name for name in self.partners if name != self.role]
        missing = [name for name, entry in self.inputs.items() if entry.topic.publisher in others
                   and partners_of(self, entry.subscription) < 1]
        missing += [name for name, entry in self.outputs.items() if partners_of(
            self, entry.publisher) < wiring.readers(name, others, self.taken)]
        if min(partners_of(self, self.sync.publisher),
               partners_of(self, self.sync.subscription)) < len(self.partners):
            missing.append('sync')
        return missing

    def said(self, name: str, word: str, stamp: int, counts: dict[str, int]) -> None:
        """Take what another node says on ``sync``; a partner answers the plant's questions."""
        if word in (sync.ASK, sync.LAST):
            self.answers.asked(stamp)

    def _said(self, name: str, word: str, stamp: int, counts: dict[str, int]) -> None:
        if word != sync.READY:
            self._ready_timer.cancel()
        self.said(name, word, stamp, counts)

    def _check_ready(self) -> None:
        self._waited += _READY_PERIOD
        if self._found:
            # We see the plant, but it may not have seen us when we said so.
            if self._waited >= _AGAIN:
                self._waited = 0.0
                self.sync.say(sync.READY)
            return
        missing = self.not_connected() if self.partners else []
        if missing:
            if self._waited >= _PATIENCE:
                self._waited = 0.0
                self.get_logger().warning(f'still waiting for a partner on {", ".join(missing)}')
            return
        self._found, self._waited = True, 0.0
        if self.partners:
            self.sync.say(sync.READY)
        else:
            self._ready_timer.cancel()
        self.started()

    def _watch_parent(self) -> None:
        if os.getppid() != self._parent:
            self.stop(0, 'the run that started this node is gone')


def _executor():
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()


def _is_managed(args: list[str], node_class: type[DriveNode]) -> bool:
    """Return whether the node waits for transitions; refuse other arguments than ROS's."""
    parser = argparse.ArgumentParser(
        prog=f'ros2 run hst_drive {node_class.role}', allow_abbrev=False, exit_on_error=False,
        description=(node_class.__doc__ or '').strip(),
        epilog='Parameters: --ros-args -p NAME:=VALUE; config/drive.yaml lists them with their '
               "units, 'ros2 param describe' says what each means.")
    parser.add_argument('--managed', nargs='?', const='true', default='false',
                        choices=('true', 'false'),
                        help='a lifecycle node: it waits to be configured and activated')
    try:
        found, unknown = parser.parse_known_args(remove_ros_args(args)[1:])
    except argparse.ArgumentError as error:
        raise InputError(str(error)) from None
    if unknown:
        raise InputError(f"unknown argument '{unknown[0]}'; a node takes --managed, and its "
                         'parameters as --ros-args -p NAME:=VALUE')
    return found.managed == 'true'


def _work(executor, node: DriveNode, signals: list[int]) -> None:
    """
    Let a node work until it stops or a signal comes.

    Calls are few and long: rclpy 7.1 loses 32 bytes in each, 14 MB in an hour of 125 calls a
    second. Only a node that gathers, so in lockstep, asks that often. (A timer that waits
    instead starves EventsExecutor's messages.) Without a timeout it never runs a callback.
    """
    def look() -> None:
        watchdog.turned()
        # Only while Python code runs, as here, is the handler of a signal called.
        if (signals or node.gather) and not node.stopped.done():
            node.stopped.set_result(None)

    # What is there by now stays: going through it for garbage is the longest pause of all, 40 ms.
    gc.collect()
    gc.freeze()
    node.create_timer(_TURN, look, clock=node.wall)
    with steady_timers(node, executor, node.wall), watched(node, executor, _work) as watchdog:
        while rclpy.ok() and node.exit_code is None and not signals:
            # Each time a new one, as a call leaves something hanging on it.
            node.stopped = Future()
            executor.spin_until_future_complete(
                node.stopped, timeout_sec=0.0 if node.gather else _CALL)
            if node.gather:
                time.sleep(node.gather)


def _leave_anyway(role: str, code: int) -> None:
    """End the process if the middleware, which has to close what is open, never returns."""
    def leave() -> None:
        print(f'{role}: the middleware did not close within {_LONGEST_END:g} s; left without it',
              file=sys.stderr, flush=True)
        os._exit(code)

    timer = threading.Timer(_LONGEST_END, leave)
    timer.daemon = True
    timer.start()


def main(node_class: type[DriveNode], args: list[str] | None = None) -> int:
    """
    Run a node until it ends, is told to (SIGINT, SIGTERM) or fails.

    ``args`` are as in ``sys.argv``, the program first. With ``--managed`` among them the node
    waits for the transitions of the lifecycle.

    Returns
    -------
    int
        0 done or told to stop, 1 failed, 2 wrong parameters.

    """
    signals: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda received, _: signals.append(received))
    node = executor = None
    code = 0
    try:
        # Our own handlers: rclpy's would shut the context down at once, and what is still under
        # way to the recorder would be lost.
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        # Said of a node that could not start, before the reason itself.
        warnings.filterwarnings('ignore', 'Failed to fini', RuntimeWarning)
        if _is_managed(sys.argv if args is None else args, node_class):
            from hst_drive.nodes.lifecycle import managed
            node = managed(node_class)()
        else:
            node = node_class()
            node.configure()
            node.activate()
        executor = _executor()
        executor.add_node(node)
        _work(executor, node, signals)
        end = time.monotonic() + _LONGEST_DRAIN
        while rclpy.ok() and node.drain() and time.monotonic() < end:
            executor.spin_once(timeout_sec=0.05)
        code = node.exit_code or 0
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except REFUSALS as error:
        code = tell_refusal(node_class.role, error, executor is not None)
    finally:
        if node is not None:
            node.deactivate()
            _leave_anyway(node_class.role, code)
            node.destroy_node()
        rclpy.try_shutdown()
    return code
