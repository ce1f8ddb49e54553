# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Timers after the executor has had no turn for a while: each is called once, and goes on."""
import time

from hst_drive.nodes.base import _executor
from hst_drive.nodes.steady_timers import steady_timers
import pytest
import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.task import Future

pytest.importorskip('rclpy.experimental.events_executor')
PERIOD, PAUSE = 0.1, 1.0


def test_after_a_pause_no_timer_is_silent():
    """Each call puts the next one off by a period; twenty at once would silence it for 2 s."""
    rclpy.init()
    node = rclpy.create_node('paused')
    clock, over, left = Clock(clock_type=ClockType.STEADY_TIME), Future(), []

    def work():
        left.append(timer.time_until_next_call() * 1e-9)
        if len(left) == 3:
            time.sleep(PAUSE)
        elif len(left) == 30:
            over.set_result(None)

    timer = node.create_timer(PERIOD, work, clock=clock)
    executor = _executor()
    executor.add_node(node)
    with steady_timers(node, executor, clock):
        executor.spin_until_future_complete(over, timeout_sec=60.0)
    node.destroy_node()
    rclpy.shutdown()
    assert len(left) == 30
    # A look at the timers may still fall between another one and its calls.
    assert max(left) < 0.5 * PAUSE
