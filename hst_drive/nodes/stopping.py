# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The ways to stop a node's drive and to let it go again: a topic and three services."""
from __future__ import annotations

from collections.abc import Callable

from hst_drive.bag.topics import TOPICS
from hst_drive.nodes.audit import Audit
from hst_drive.nodes.endpoints import qos_profile
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger


class StopInputs:
    """
    Topic ``emergency_stop``, services ``~/emergency_stop``, ``~/reset`` and ``~/start`` of a node.

    Parameters
    ----------
    node : Node
        Owner.
    audit : Audit
        Is told of all that comes.
    on_press : callable
        ``on_press(source, pressed)`` returns whether that is new.
    on_reset, on_start : callable
        Return what stands against a reset, or start; an empty list if it is done.

    """

    def __init__(self, node, audit: Audit, on_press: Callable[[str, bool], bool],
                 on_reset: Callable[[], list[str]], on_start: Callable[[], list[str]]):
        self._audit, self._on_press = audit, on_press
        topic = TOPICS['emergency_stop']
        # A reader that asks for latched messages does not match a writer that offers none, and
        # a stop must never be lost to that: the second reader takes it from anybody.
        for qos in (topic.qos, topic.qos._replace(durability='volatile', depth=10)):
            node.create_subscription(Bool, topic.name, lambda message: self._press(
                'topic', message.data, lambda: audit.writers(topic.name)), qos_profile(qos))
        node.create_service(SetBool, '~/emergency_stop', self._pressed)
        for name, action in (('reset', on_reset), ('start', on_start)):
            node.create_service(Trigger, f'~/{name}', lambda _, response, name=name, action=action:
                                self._act(name, action, response))

    def _press(self, source: str, pressed: bool, who: Callable[[], str]) -> None:
        if self._on_press(source, pressed):
            self._audit.note(f'emergency stop {"pressed" if pressed else "released"} by {source} '
                             f'({who()})')

    def _pressed(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._press('service', request.data, lambda: self._audit.callers('~/emergency_stop'))
        response.success = True
        response.message = ('stopping' if request.data
                            else 'released; the drive stays at zero until ~/reset')
        return response

    def _act(self, name: str, action: Callable[[], list[str]], response: Trigger.Response
             ) -> Trigger.Response:
        against = '; '.join(action())
        response.success = not against
        response.message = against or f'{name} done'
        self._audit.note(f'{name} by service ({self._audit.callers(f"~/{name}")}): '
                         + (f'refused: {against}' if against else 'done'))
        return response
