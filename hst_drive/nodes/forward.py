# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The pump command to a forward_command_controller of ros2_control as well."""
from __future__ import annotations

from hst_drive.nodes.endpoints import Output
from hst_drive.nodes.parameters import JOINT, Parameter
from rcl_interfaces.srv import GetParameters
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64MultiArray

PARAMETERS = (
    Parameter('forward_to', '', 'name of a forward_command_controller of ros2_control that takes '
              'the pump command as well; empty: none', form='name of a node'),
    Parameter('forward_joint', '', 'the joint that it has to have, and no other; empty: not asked',
              form=JOINT),
    Parameter('forward_scale', 1.0, 'unit of its interface for each volt; 0.1: 10 V are 1', '1/V',
              -1e6, 1e6),
)
_PERIOD = 1.0       # s between two questions for its joints


class ForwardedOutput:
    """
    An ``Output`` of one number whose values go to a forward_command_controller besides.

    Its topic is ``~/commands``, std_msgs/Float64MultiArray with a number for each of its
    ``joints`` in their order. It passes over messages of another length without a word, so it is
    asked for its joints.

    Attributes
    ----------
    names : tuple of str
        Topics that it publishes.
    wrong : str
        Why it does not take the command; '' if it does, or it is not known.

    """

    def __init__(self, node, output: Output):
        settings = node.settings
        self.topic, self.publisher = output.topic, output.publisher
        self.wrong = ''
        self._output, self._scale = output, settings['forward_scale']
        name = settings['forward_to'].rstrip('/')
        self._name, self._joint = name, settings['forward_joint']
        # As rclcpp's SystemDefaultsQoS, which it asks for.
        self.names = (*output.names, node.resolve_topic_name(f'{name}/commands'))
        self._commands = node.create_publisher(Float64MultiArray, f'{name}/commands',
                                               QoSProfile(depth=1))
        self._asked = None
        if self._joint:
            self._ask = node.create_client(GetParameters, f'{name}/get_parameters')
            self._timer = node.create_timer(_PERIOD, self._look, clock=node.wall)

    @property
    def published(self) -> int:
        """Messages published until now."""
        return self._output.published

    def publish(self, stamp: int, value: float) -> None:
        """Publish a command, V, that was formed at ``stamp``, ns."""
        before = self._output.published
        self._output.publish(stamp, value)
        if self._output.published > before:
            self._commands.publish(Float64MultiArray(data=[self._scale * value]))

    def _look(self) -> None:
        if self._asked and self._asked.done():
            self._timer.cancel()
            joints = [joint for value in self._asked.result().values
                      for joint in value.string_array_value]
            if joints != [self._joint]:
                self.wrong = (f"{self._name} has the joints {', '.join(joints) or 'none'}; "
                              f"expected '{self._joint}' and no other")
        elif self._ask.service_is_ready():
            if self._asked:
                self._ask.remove_pending_request(self._asked)
            self._asked = self._ask.call_async(GetParameters.Request(names=['joints']))
