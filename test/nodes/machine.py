# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What surrounds a controller, for tests of its own process."""
from contextlib import contextmanager
import math
import time

import rclpy

from .processes import PATIENCE, wait_for

ANSWER = 5.0


class Machine:
    """What surrounds the controller: sensor, set point, operator, valve, diagnostics."""

    def __init__(self, namespace='drive', domain=None):
        from diagnostic_msgs.msg import DiagnosticArray
        from geometry_msgs.msg import Vector3Stamped
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Bool
        from std_srvs.srv import SetBool, Trigger
        self.namespace = namespace
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node('machine', namespace=namespace, context=self.context)
        self.executor = rclpy.executors.SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.motor = self.node.create_publisher(JointState, 'motor', 100)
        self.setpoint = self.node.create_publisher(Vector3Stamped, 'speed_setpoint', 100)
        self.manual = self.node.create_publisher(Vector3Stamped, 'manual_pump_command', 100)
        self.stop = self.node.create_publisher(Bool, 'emergency_stop', QoSProfile(
            depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
        self.hasty_stop = self.node.create_publisher(Bool, 'emergency_stop', 1)
        self.node.create_subscription(Vector3Stamped, 'pump_command', self._commanded, 100)
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._told, 100)
        self.stopper = self.node.create_client(SetBool, 'controller/emergency_stop')
        self.resetter = self.node.create_client(Trigger, 'controller/reset')
        self.starter = self.node.create_client(Trigger, 'controller/start')
        self.commands, self.told, self.count = [], {}, 0

    def _commanded(self, message):
        stamp = message.header.stamp
        self.commands.append((stamp.sec + stamp.nanosec * 1e-9, message.vector.x))

    def _told(self, message):
        for status in message.status:
            if status.name == f'/{self.namespace}/controller: safety':
                self.told = {'level': status.level, 'message': status.message,
                             **{entry.key: entry.value for entry in status.values}}

    def tick(self, reading=10.0, wish=19.0, moved=0.0, manual=None, steady=False, others=(),
             name='drill', bare=False, lasts=0.01):
        """
        Send one sample of everything (None: not), and take in what comes for so long (s).

        A reading may be a function that gives it. ``others`` are joints with speeds of their own
        that come before ours in the message; ``bare``: a message that has names and no speeds.
        """
        from geometry_msgs.msg import Vector3Stamped
        from rclpy.duration import Duration
        from sensor_msgs.msg import JointState
        now = self.node.get_clock().now()
        self.count += 1
        if reading is not None:
            value = reading() if callable(reading) else reading
            value += 0.0 if steady else 0.001 * math.sin(self.count)
            names, speeds = [*(other for other, _ in others), name], [
                *(speed for _, speed in others), value]
            self.motor.publish(JointState(
                header=_header(now + Duration(seconds=moved)), name=names,
                velocity=[] if bare else speeds,
                position=[0.0] * len(names), effort=[0.0] * len(names)))
        for publisher, number in ((self.setpoint, wish), (self.manual, manual)):
            if number is not None:
                message = Vector3Stamped(header=_header(now))
                message.vector.x = number
                publisher.publish(message)
        end = time.monotonic() + lasts
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=max(0.0, end - time.monotonic()))

    def until(self, condition, **what):
        """Go on until the condition holds."""
        def go():
            self.tick(**what)
            return condition()

        return wait_for(go)

    def call(self, client, request, **what):
        """
        Call a service while the machine goes on; ask again when no answer comes.

        An answer is lost while the server has not yet found the client's reader (rmw_fastrtps
        waits 100 ms for it): requests must be such that a second one does no harm.
        """
        assert client.wait_for_service(timeout_sec=PATIENCE)
        asked = []

        def answer():
            if not asked or time.monotonic() > asked[-1][1] + ANSWER:
                asked.append((client.call_async(request), time.monotonic()))
            return next((future for future, _ in asked if future.done()), None)

        return self.until(answer, **what).result()

    def reset(self, **what):
        from std_srvs.srv import Trigger
        return self.call(self.resetter, Trigger.Request(), **what)

    def start(self, **what):
        from std_srvs.srv import Trigger
        return self.call(self.starter, Trigger.Request(), **what)

    def run_up(self, **what):
        """Reset and start what is left of the last test; go on until there is a command."""
        def running():
            if self.told.get('fault'):
                self.reset(**what)
                self.told = {}
            if self.told.get('state') == 'ready':
                self.start(**what)
                self.told = {}
            return self.commands and self.commands[-1][1] > 5.0 \
                and self.told.get('state') == 'running'

        self.until(running, **what)


def _header(now):
    from std_msgs.msg import Header
    return Header(stamp=now.to_msg())


@contextmanager
def surroundings(namespace='drive', domain=None):
    """Give a machine and take it down again."""
    made = Machine(namespace, domain)
    try:
        yield made
    finally:
        made.node.destroy_node()
        rclpy.shutdown(context=made.context)
