# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""An executor that stands still is woken, and if that is in vain the process ends."""
from contextlib import nullcontext
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

from hst_drive.nodes import watchdog
import pytest

from .processes import environment, PATIENCE

pytest.importorskip('rclpy')

STANDS = """
import sys
from hst_drive.nodes import controller, watchdog
watchdog.BEAT = 0.05
# Whatever the loop does, it is not seen to turn.
watchdog.Watchdog.turned = lambda self: None
sys.exit(controller.main())
"""


def watchdog_with(idle):
    done = []
    return done, watchdog.Watchdog(lambda: done.append('woken'), idle, lambda: done.append('end'))


def test_a_loop_that_waits_is_woken_again_and_again_and_then_ended():
    done, dog = watchdog_with(lambda: True)
    for _ in range(watchdog.WOKEN - 1):
        dog.look()
    assert not done
    for _ in range(watchdog.WOKEN - 1, watchdog.ENDED):
        dog.look()
    assert done == ['woken'] * (watchdog.ENDED // watchdog.WOKEN - 1) + ['end']


def test_a_loop_that_turns_or_works_is_left_alone():
    busy = []
    done, dog = watchdog_with(lambda: not busy)
    for _ in range(10):
        for _ in range(watchdog.WOKEN - 1):
            dog.look()
        dog.turned()
    busy.append(True)
    for _ in range(2 * watchdog.ENDED):
        dog.look()
    assert not done


class Deaf:
    """An executor that hears nothing but a task given from outside; then its timers are due."""

    def __init__(self):
        self.given, self.timers, self.calls = threading.Event(), [], 0

    def create_task(self, callback):
        self.given.set()

    def spin_until_future_complete(self, future, timeout_sec):
        self.given.wait(30.0)
        self.given.clear()
        self.calls += 1
        for callback in self.timers:
            callback()


def test_the_spin_loop_of_a_node_goes_on_once_it_is_woken(monkeypatch):
    from hst_drive.nodes import base
    executor, said = Deaf(), []

    def create_timer(period, callback, clock):
        executor.timers.append(callback)
        return SimpleNamespace(reset=lambda: None)

    node = SimpleNamespace(
        role='stub', gather=0.0, exit_code=None, stopped=None, wall=None,
        create_timer=create_timer, get_logger=lambda: SimpleNamespace(warning=said.append))
    executor.timers.append(lambda: executor.calls < 3 or setattr(node, 'exit_code', 0))
    monkeypatch.setattr(base.rclpy, 'ok', lambda: True)
    monkeypatch.setattr(base, 'steady_timers', lambda *_: nullcontext())
    monkeypatch.setattr(watchdog, 'BEAT', 0.01)
    began = time.monotonic()
    base._work(executor, node, [])
    assert executor.calls == 3 and said == ['the executor stands still; it is woken'] * 3
    assert time.monotonic() - began < 10.0


def test_a_node_that_stands_still_for_good_ends_and_says_where():
    done = subprocess.run([sys.executable, '-c', STANDS], env=environment(), capture_output=True,
                          text=True, timeout=PATIENCE)
    assert done.returncode == 1
    assert 'the executor stands still; it is woken' in done.stderr
    assert 'controller: the executor stood still for' in done.stderr
    assert 'in _work' in done.stderr
