# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The ways to stop a node's drive and to let it go again: a topic and two services."""
from __future__ import annotations

from collections.abc import Callable

from hst_drive.bag.topics import TOPICS
from hst_drive.nodes.endpoints import qos_profile
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger


class StopInputs:
    """
    Topic ``emergency_stop``, services ``~/emergency_stop`` and ``~/reset`` of a node.

    Parameters
    ----------
    node : Node
        Owner.
    on_press : callable
        ``on_press(source, pressed)``.
    on_reset : callable
        Returns what stands against a reset; an empty list if it is done.

    """

    def __init__(self, node, on_press: Callable[[str, bool], None],
                 on_reset: Callable[[], list[str]]):
        self._on_press, self._on_reset = on_press, on_reset
        topic = TOPICS['emergency_stop']
        # A reader that asks for latched messages does not match a writer that offers none, and
        # a stop must never be lost to that: the second reader takes it from anybody.
        for qos in (topic.qos, topic.qos._replace(durability='volatile', depth=10)):
            node.create_subscription(
                Bool, topic.name, lambda message: on_press('topic', message.data),
                qos_profile(qos))
        node.create_service(SetBool, '~/emergency_stop', self._pressed)
        node.create_service(Trigger, '~/reset', self._reset)

    def _pressed(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._on_press('service', request.data)
        response.success = True
        response.message = ('stopping' if request.data
                            else 'released; the drive stays at zero until ~/reset')
        return response

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        against = self._on_reset()
        response.success = not against
        response.message = '; '.join(against) or 'running again'
        return response
