# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A clock that is set while the drive runs in real time."""
from hst_drive.nodes.controller import Controller
from hst_drive.nodes.load_profile import LoadProfile
from hst_drive.nodes.plant import Plant
import numpy as np
import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor

HOUR = 3600 * 10**9


@pytest.mark.parametrize('jump', [HOUR, -HOUR])
def test_the_drive_goes_on_through_it(jump):
    rclpy.init(args=['--ros-args', '-p', 'setpoint_timeout:=20.0', '-p', 'feedback_timeout:=20.0',
                     '-p', 'bad_readings:=10'])
    nodes = [kind() for kind in (Controller, LoadProfile, Plant)]
    controller, _, plant = nodes
    executor, moved, stamps, true_now = SingleThreadedExecutor(), [0], [], {}
    # One or two readings that are under way when the clock is set are passed over.
    try:
        for node in nodes:
            true_now[node] = node.now
            node.now = lambda node=node: true_now[node]() + moved[0]
            node.configure()
            node.activate()
            executor.add_node(node)
        plant.outputs['motor'].publish = spied(plant.outputs['motor'].publish, stamps)
        for count in (100, 200):
            while len(stamps) < count:
                executor.spin_once(timeout_sec=1.0)
            moved[0] = jump
        steps = np.diff(stamps)
        assert np.count_nonzero(np.abs(steps) > HOUR / 2) == 1
        assert set(steps[np.abs(steps) < HOUR / 2]) == {10**7}
        assert controller._watch.fault is None
        assert controller._watch.passed_over < 5 and controller._command > 0.0
    finally:
        for node in nodes:
            node.destroy_node()
        rclpy.shutdown()


def spied(publish, stamps):
    """Return the function, which notes the stamps as well."""
    def both(stamp, *values):
        stamps.append(stamp)
        publish(stamp, *values)

    return both
