# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What an audit asks of a controller: who has stopped, released, reset and started the drive."""
from __future__ import annotations

from collections.abc import Callable

from rclpy.node import NodeNameNonExistentError


class Audit:
    """
    Logs what was done to the drive, one line each at INFO, and keeps the last one.

    ROS 2 does not sign messages and tells no service who calls: named are the nodes that could
    have, as the graph knows them in that moment. ``on_note`` is called after each line.
    """

    def __init__(self, node, on_note: Callable[[], None]):
        self._node, self._on_note = node, on_note
        self.last = ''

    def note(self, what: str) -> None:
        """Log a line, keep it, and let the node tell of it."""
        self.last = what
        self._node.get_logger().info(what)
        self._on_note()

    def writers(self, topic: str) -> str:
        """Return which nodes publish a topic."""
        # The middleware may know a publisher before it knows whose it is.
        return _listed(_full(entry.node_namespace, entry.node_name) for entry in
                       self._node.get_publishers_info_by_topic(
                           self._node.resolve_topic_name(topic))
                       if entry.node_name != '_NODE_NAME_UNKNOWN_')

    def callers(self, service: str) -> str:
        """Return which nodes have a client of a service."""
        service, found = self._node.resolve_service_name(service), []
        for name, namespace in self._node.get_node_names_and_namespaces():
            try:
                clients = self._node.get_client_names_and_types_by_node(name, namespace)
            except NodeNameNonExistentError:    # it has gone meanwhile
                continue
            if service in dict(clients):
                found.append(_full(namespace, name))
        return _listed(found)


def _full(namespace: str, name: str) -> str:
    return f"{namespace.rstrip('/')}/{name}"


def _listed(names) -> str:
    return ', '.join(sorted(set(names))) or 'a node unknown by now'
