# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The publisher of /diagnostics, and of what else is not made of numbers alone."""
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hst_drive.bag.cdr import Codec
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.topics import TOPICS
from hst_drive.nodes.endpoints import BILLION, has_time, message_class, qos_profile
from hst_drive.nodes.parameters import Parameter

OK, WARN, ERROR, STALE = 0, 1, 2, 3
"""Levels of a diagnostic_msgs/DiagnosticStatus."""
HARDWARE = Parameter('hardware_id', '', 'name of the machine in /diagnostics; empty: the '
                     'namespace', form='any text')


class PackedOutput:
    """
    A publisher of a topic of the table that packs its messages itself.

    For rclpy leaves bytes of foreign memory in the padding, and two runs of one seed shall give
    one bag.
    """

    def __init__(self, node, name: str):
        self.topic = TOPICS[name]
        self._codec = Codec(self.topic.type, find_definition(self.topic.type))
        self.publisher = node.create_publisher(
            message_class(self.topic.type), self.topic.name, qos_profile(self.topic.qos))
        self._log = node.get_logger()
        self.published = 0

    def pack(self, stamp: int, content: Mapping[str, Any]) -> None:
        """Publish a message of this content, true at ``stamp`` (ns), behind its header."""
        if not has_time(stamp, self._log):
            return
        seconds, nanoseconds = divmod(stamp, BILLION)
        self.publisher.publish(self._codec.encode({
            'header': {'stamp': {'sec': seconds, 'nanosec': nanoseconds},
                       'frame_id': self.topic.frame}, **content}))
        self.published += 1


class Diagnostics(PackedOutput):
    """The publisher of /diagnostics."""

    def __init__(self, node):
        super().__init__(node, '/diagnostics')
        self._hardware = node.settings['hardware_id'] or node.get_namespace().strip('/')

    def publish(self, stamp: int, name: str, level: int, message: str,
                values: Mapping[str, Any]) -> None:
        """Publish one status that was true at ``stamp``, ns."""
        self.pack(stamp, {'status': [{
            'level': level, 'name': name, 'message': message, 'hardware_id': self._hardware,
            'values': [{'key': key, 'value': str(value)} for key, value in values.items()]}]})
