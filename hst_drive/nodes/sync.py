# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How the nodes of a run find each other and keep step.

Before the run, every node says 'ready' on the topic ``sync`` once its endpoints are matched by
the partners that it was told of; the plant says 'start' when all have.

In lockstep the plant publishes ``/clock`` and its readings for step k, load_profile and
controller answer with messages of the same stamp, and the plant goes on when it has them. Every
``INTERVAL`` steps it asks all partners on ``sync`` how far they are; each answers when it is
through with that step and says how many messages it has published on each topic until then. The
recorder answers when it has received all of those: then it writes them in one fixed order,
whatever the order in which they came. The plant never runs more than ``INTERVAL`` steps ahead of
the slowest answer, so no queue overflows and no message is lost.

When time runs as fast as it goes, load_profile does not answer the clock but plays in bursts,
``LOOKAHEAD`` steps beyond each question: what it publishes depends on time alone, and a third of
all changes of process are spared. For the same reason the plant sends the readings that nobody
answers in bursts of ``readings.BURST`` steps. Stamps and content of the messages are the same.
"""
from __future__ import annotations

from collections.abc import Callable

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hst_drive.bag.topics import TOPICS
from hst_drive.nodes.endpoints import qos_profile

INTERVAL = 40
"""Steps between two questions."""
LOOKAHEAD = 60
"""Steps that load_profile may play ahead of the question that it answers; together with
``INTERVAL`` they must fit into a topic's queue."""
SLOW = 10
"""In lockstep, the oil temperature is set once in so many steps: it hardly moves in between."""
SIMULATED_START = 1_000_000_000
"""Simulated time of step 0, ns; not 0, which ROS and MCAP read as 'no time yet'."""
READY, START, ASK, LAST, DONE = 'ready', 'start', 'ask', 'last', 'done'


class Sync:
    """
    The ``sync`` topic of one node.

    Parameters
    ----------
    node : DriveNode
        Its role is the name that it answers with.
    on_said : callable
        ``on_said(node name, word, stamp, counts)`` for every message of another node.

    """

    def __init__(self, node, on_said: Callable[[str, str, int, dict[str, int]], None]):
        topic = TOPICS['sync']
        self._node = node
        self._name = node.role
        self._on_said = on_said
        self.publisher = node.create_publisher(
            DiagnosticArray, topic.name, qos_profile(topic.qos))
        self.subscription = node.create_subscription(
            DiagnosticArray, topic.name, self._received, qos_profile(topic.qos))

    def say(self, word: str, stamp: int = 0, counts: dict[str, int] | None = None) -> None:
        """Tell the others: a word, the stamp (ns) of a step, messages published by topic."""
        values = [KeyValue(key='stamp', value=str(stamp))]
        values += [KeyValue(key=name, value=str(count)) for name, count in (counts or {}).items()]
        status = DiagnosticStatus(name=self._name, message=word, values=values)
        self.publisher.publish(DiagnosticArray(status=[status]))

    def _received(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == self._name:
                continue
            try:
                numbers = {value.key: int(value.value) for value in status.values}
                stamp = numbers.pop('stamp')
            except (KeyError, ValueError):
                self._node.get_logger().warning(
                    f"{self.subscription.topic_name}: what '{status.name}' says is not ours; left "
                    'out', throttle_duration_sec=5.0)
                continue
            self._on_said(status.name, status.message, stamp, numbers)


class Answers:
    """A partner's side: answers the plant's questions once the step asked for is done."""

    def __init__(self, sync: Sync, counts: Callable[[], dict[str, int]]):
        self._sync = sync
        self.counts = counts
        self._history: dict[int, dict[str, int]] = {}
        self._asked: int | None = None
        self._done = 0

    def asked(self, stamp: int) -> None:
        """Take the plant's question."""
        self._asked = stamp
        self._answer()

    def done(self, stamp: int) -> None:
        """Note that all messages of the step with this stamp have been published."""
        self._done = stamp
        self._history[stamp] = self.counts()
        if len(self._history) > 2 * INTERVAL:
            del self._history[next(iter(self._history))]
        self._answer()

    def _answer(self) -> None:
        if self._asked is not None and self._asked <= self._done:
            self._sync.say(DONE, self._asked, self._history[self._asked])
            self._asked = None
