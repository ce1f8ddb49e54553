# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Simulated time that nobody publishes: no message may carry the stamp 0."""
from builtin_interfaces.msg import Time
from rosgraph_msgs.msg import Clock

from .machine import surroundings
from .processes import node


def test_the_controller_sends_nothing_without_a_time():
    """And says so; with the first /clock it begins."""
    with surroundings() as machine, node(
            'controller', '-p', 'use_sim_time:=true', '-p', 'stamp_tolerance:=0.0') as process:
        machine.until(lambda: machine.motor.get_subscription_count())
        for _ in range(100):
            machine.tick()
        assert not machine.commands and not machine.told
        clock = machine.node.create_publisher(Clock, '/clock', 1)

        def commanded():
            clock.publish(Clock(clock=Time(sec=5 + machine.count // 100,
                                           nanosec=machine.count % 100 * 10**7)))
            return len(machine.commands) > 20

        machine.until(commanded)
        assert all(stamp >= 5.0 for stamp, _ in machine.commands)
    assert 'nobody publishes /clock' in process.err
