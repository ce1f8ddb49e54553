# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The nodes of a machine, kept up while they are killed: is anything lost but what the guide says.

    python -m bench.soak --minutes 60 --respawn 10

Every so many minutes the controller and the estimator are killed in turn (SIGKILL) and started
again a second later, as launch does with ``respawn``; the manager brings them up, and an operator
starts the drive when it is ready. Lost may be, by the table of faults in docs/integration.md: the
commands from a kill of the controller until it is back, at 0 V, and nothing else.
"""
from __future__ import annotations

from contextlib import ExitStack
from functools import partial
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from hst_drive.bag.cdr import Codec
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.topics import TOPICS
from hst_drive.nodes.priority import go_before_others
from hst_drive.nodes.session import environment
from mcap.reader import make_reader
import numpy as np

KEPT = ('controller', 'estimator')
PERIOD = 0.01       # s, of readings and commands
TOLD = 2.5          # s: by then the manager has told of a kill (docs/integration.md)
SLOW = 1.0          # s that a busy machine may add to that
BACK = 15.0         # s by which a killed node is active again; 4 to 5 s on a quiet machine
_GAP = 0.25         # s without a command: the feedback_timeout; a shorter one is a busy machine
_LAST = 10.0        # s of undisturbed work at the end
_PRIORITY = {'plant': 10, 'controller': 9, 'estimator': 8, 'load_profile': 8, 'recorder': 8,
             'manager': 8}


class Operator:
    """Hears what the nodes say of themselves, and starts the drive when it is ready."""

    def __init__(self, context):
        from diagnostic_msgs.msg import DiagnosticArray
        import rclpy
        from std_srvs.srv import Trigger
        self._request = Trigger.Request()
        self.node = rclpy.create_node('operator', namespace='drive', context=context)
        self._executor = rclpy.executors.SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._told, 100)
        self._start = self.node.create_client(Trigger, 'controller/start')
        self._asked = 0.0
        self.nodes, self.silent_at, self.faults = '', {}, []

    def _told(self, message) -> None:
        for status in message.status:
            values = {entry.key: entry.value for entry in status.values}
            if status.name.endswith('manager: nodes'):
                self.nodes = status.message
                for name in KEPT:
                    if values.get(name) == 'silent':
                        self.silent_at.setdefault(name, time.monotonic())
            elif status.name.endswith('controller: safety'):
                fault = values.get('fault')
                if fault and fault != 'shutdown' and fault not in self.faults:
                    self.faults.append(fault)
                if values.get('state') == 'ready' and time.monotonic() > self._asked + 2.0:
                    self._asked = time.monotonic()
                    self._start.call_async(self._request)

    def work(self, seconds: float, until=lambda: False) -> bool:
        """Go on for so long, or until the condition holds; return whether it did."""
        end = time.monotonic() + seconds
        while time.monotonic() < end and not until():
            self._executor.spin_once(timeout_sec=0.05)
        return until()


def soak(scenario: Path, bag: Path, seconds: float, every: float, first: bool) -> list[str]:
    """
    Run the nodes, kill one every so many seconds, and return what is out.

    ``first``: they go before all other work of the machine.
    """
    import rclpy
    wrong, kills = [], []
    with ExitStack() as stack:
        env = environment(stack)
        os.environ.update({key: env[key] for key in env if key.startswith(('ROS_', 'FAST'))})
        running: dict[str, subprocess.Popen] = {}

        def start(name: str, *parameters: str) -> None:
            managed = ['--managed'] * (name in KEPT)
            given = [part for text in parameters for part in ('-p', text)]
            running[name] = subprocess.Popen(
                [sys.executable, '-m', f'hst_drive.nodes.{name}', *managed, '--ros-args', *given],
                env=env, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                # Not by the parameter: a node that is started again would import without it.
                preexec_fn=partial(go_before_others, _PRIORITY[name] if first else 0))

        stack.callback(lambda: _end(running))
        context = rclpy.Context()
        rclpy.init(context=context, signal_handler_options=rclpy.SignalHandlerOptions.NO)
        stack.callback(lambda: rclpy.shutdown(context=context))
        operator = Operator(context)
        start('recorder', f'output:={bag}')
        for name in KEPT:
            start(name)
        start('load_profile', f'scenario:={scenario}')
        start('plant')
        start('manager', f"nodes:=[{','.join(KEPT)}]", 'bring_back:=true')
        if not operator.work(60.0, lambda: operator.nodes == 'all nodes are active'):
            return [f'the nodes are not active after a minute: {operator.nodes or "no word"}']
        began = time.monotonic()
        while time.monotonic() - began < seconds - _LAST:
            operator.work(min(every, seconds - _LAST - (time.monotonic() - began)))
            if time.monotonic() - began >= seconds - _LAST - BACK:
                break
            name = KEPT[len(kills) % len(KEPT)]
            wrong += _kill(operator, running, name, lambda name=name: start(name))
            kills.append((name, time.time()))
        operator.work(_LAST)
        wrong += [f'a fault: {fault}' for fault in operator.faults]
        wrong += [f'{name} has ended by itself' for name, process in running.items()
                  if process.poll() is not None]
    return wrong + judge(bag, sum(name == 'controller' for name, _ in kills))


def _kill(operator: Operator, running, name: str, start) -> list[str]:
    operator.silent_at.clear()
    at = time.monotonic()
    running[name].kill()
    running[name].wait()
    operator.work(1.0)
    start()
    told = operator.work(TOLD + SLOW, lambda: name in operator.silent_at)
    back = operator.work(BACK, lambda: operator.nodes == 'all nodes are active'
                         and (not told or time.monotonic() > operator.silent_at[name] + 0.6))
    late = operator.silent_at.get(name, at) - at
    print(f'{name} killed: told after {late:.1f} s, active after {time.monotonic() - at:.1f} s')
    # One that is back before it counts as silent was not missed.
    return ([] if told or back else [f'{name}: not told within {TOLD} s']) + (
        [] if back else [f'{name}: not active within {BACK:g} s: {operator.nodes}'])


def _end(running: dict[str, subprocess.Popen]) -> None:
    """End the plant last but the recorder, which has to write all."""
    for name in ('manager', *KEPT, 'load_profile', 'plant', 'recorder'):
        process = running.get(name)
        if process is not None:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(30.0)
            except subprocess.TimeoutExpired:
                process.kill()


def judge(bag: Path, kills: int) -> list[str]:
    """Return what is out in the bag of a soak in which the controller was killed so often."""
    wrong = []
    stamps, _ = _read(bag, 'motor', 'velocity[0]')
    steps = np.round(np.diff(stamps) / PERIOD).astype(int)
    print(f'motor: {len(stamps)} readings, {int((steps - 1).sum())} missing')
    if (steps > 1).any():
        wrong.append(f'motor: {int((steps - 1).sum())} readings are missing')
    stamps, values = _read(bag, 'pump_command', 'vector.x')
    gaps = np.flatnonzero(np.diff(stamps) > _GAP)
    print(f'pump_command: {len(stamps)} commands, {len(gaps)} gaps'
          + ''.join(f', {stamps[i + 1] - stamps[i]:.1f} s' for i in gaps))
    if len(gaps) != kills:
        wrong.append(f'pump_command: {len(gaps)} gaps, the controller was killed {kills} times')
    wrong += [f'pump_command: a gap of {stamps[i + 1] - stamps[i]:.1f} s' for i in gaps
              if stamps[i + 1] - stamps[i] > BACK]
    wrong += [f'pump_command: {values[i + 1]:.3g} V right after a kill' for i in gaps
              if values[i + 1] != 0.0]
    wrong += ['pump_command: the drive was not started again' for i in gaps
              if not (values[i + 1:] > 0.0).any()]
    return wrong


def _read(bag: Path, name: str, path: str) -> tuple[np.ndarray, np.ndarray]:
    """Return stamps (s) and numbers of a topic, by their stamps."""
    kind, found = TOPICS[name].type, []
    for file in sorted(bag.glob('*.mcap')):
        with open(file, 'rb') as stream:
            found += [(message.publish_time, message.data) for _, _, message in make_reader(
                stream).iter_messages(topics=[f'/drive/{name}'], log_time_order=False)]
    found.sort(key=lambda entry: entry[0])
    values = Codec(kind, find_definition(kind)).extract([data for _, data in found], [path])
    return np.array([stamp for stamp, _ in found], dtype=np.int64) / 1e9, values[path]
