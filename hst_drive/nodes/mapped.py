# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Inputs of a live node from where a channel map says: the map of the bags, any type, any name."""
from __future__ import annotations

from collections.abc import Callable
import math
import time

from hst_drive.bag.cdr import Codec, MalformedError
from hst_drive.bag.channels import ChannelMap, Entry, load_channel_map, parts_of
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.diagnostic_values import read_values
from hst_drive.bag.picks import mapped_pick
from hst_drive.bag.stream import Stream
from hst_drive.bag.topics import CHANNEL_FIELDS, DIAGNOSTIC_ARRAY, Qos
from hst_drive.errors import InputError
from hst_drive.nodes.endpoints import Layout, message_class, qos_profile, stamp_of
from hst_drive.nodes.parameters import Parameter, YAML_FILE

CHANNELS = Parameter('channels', '', 'channel map: which topic and field is which of our '
                     'channels; empty: our own topics', form=YAML_FILE)
_SEARCH = 0.1       # s between two looks for a publisher


def map_of(node) -> ChannelMap:
    """
    Return the channel map of a node's parameter; without entries if there is none.

    Raises
    ------
    InputError
        If it cannot be read, or the node takes part in a simulated run, whose nodes wait for
        each other on our own topics.

    """
    path = node.settings['channels']
    if not path:
        return ChannelMap()
    if node.partners:
        raise InputError('parameter channels is for a machine of your own; leave partners empty')
    return load_channel_map(path)


def topics_of(channel_map: ChannelMap) -> list[str]:
    """Return the topics that a map names; its columns of CSV files are left out."""
    return list(dict.fromkeys(entry.topic_and_path()[0] for entry in channel_map.entries.values()
                              if entry.source.startswith('/')))


def search_for(node) -> None:
    """Look for the publishers of the node's mapped inputs until there are all."""
    waiting = [entry for entry in node.inputs.values() if isinstance(entry, MappedInput)]

    def look() -> None:
        waiting[:] = [entry for entry in waiting if not entry.search()]
        if not waiting:
            node.destroy_timer(timer)

    # One for all: rclpy's executor goes through all timers at each that is due.
    timer = node.create_timer(_SEARCH, look, clock=node.wall) if waiting else None


class MappedInput:
    """
    One channel from where the map says; calls ``callback(stamp ns, SI value)``.

    Stands beside ``endpoints.Input``, with the same attributes. The type of a topic is that of
    its publisher: the subscription is opened once there is one (``search_for``). A message
    without a header counts from when it came. NaN stands for an element that a message does not
    have, and for a difference whose second part is older than ``timeout`` (s; 0: never).
    """

    def __init__(self, node, channel_map: ChannelMap, channel: str,
                 callback: Callable[[int, float], None], timeout: float):
        self.topic = CHANNEL_FIELDS[channel][0]
        self.received = 0
        self._callback, self._timeout = callback, timeout or math.inf
        self._parts = [_Part(node, entry, channel_map.source, self._came)
                       for entry in parts_of(channel_map, channel)]
        self.name = self._parts[0].name

    @property
    def refused(self) -> str:
        """Why the last message has no number; '' if it has one."""
        return '; '.join(filter(None, (part.refused for part in self._parts)))

    def found(self) -> str:
        """Return the topics' names and what is there of their publishers."""
        return ', '.join(part.found() for part in self._parts)

    def search(self) -> bool:
        """Subscribe to what has a publisher by now; return whether that is all."""
        return sum(part.search() for part in self._parts) == len(self._parts)

    def _came(self, part: _Part) -> None:
        first, *others = self._parts
        if part is not first or any(math.isinf(other.at) for other in others):
            return
        self.received += 1
        value = first.value
        for other in others:
            value -= other.value if first.at - other.at <= self._timeout else math.nan
        self._callback(first.stamp, value)


class _Part:
    """A number of one topic; ``at`` is when it came, s of the steady clock."""

    def __init__(self, node, entry: Entry, source: str, on_number: Callable[[_Part], None]):
        self.stamp, self.value, self.at = 0, math.nan, -math.inf
        self.refused = ''
        self._node, self._entry, self._source = node, entry, source
        self._on_number = on_number
        self._topic = entry.topic_and_path()[0]
        if not self._topic.startswith('/'):
            raise InputError(f'{source}: channels.{entry.channel}: {self._topic!r} is a column of '
                             'a CSV file; a node reads /topic.field')
        self.name = node.resolve_topic_name(self._topic)
        self._subscription = None
        self._wrong = ''        # why the publisher's type does not do
        self._layout: Layout | None = None

    def search(self) -> bool:
        """Subscribe if there is a publisher; return whether that is done."""
        publishers = [] if self._subscription else self._node.get_publishers_info_by_topic(
            self.name)
        if publishers:
            try:
                self._wrong = ''
                self._subscribe(publishers)
            except (InputError, ImportError, AttributeError) as error:
                self._wrong = str(error)
                self._node.get_logger().error(self._wrong, throttle_duration_sec=5.0)
        return self._subscription is not None

    def _subscribe(self, publishers) -> None:
        kind = publishers[0].topic_type
        text = find_definition(kind)
        _, self._pick = mapped_pick(
            self._entry, [Stream(self._topic, kind, text, 'ros2msg', 'cdr', {})], self._source)
        self._codec = Codec(kind, text)
        self._diagnostic = kind == DIAGNOSTIC_ARRAY
        # Reliable where all offer it: a set point comes once and shall not be lost.
        offered = {entry.qos_profile.reliability.name for entry in publishers}
        self._subscription = self._node.create_subscription(
            message_class(kind), self.name, self._received, qos_profile(
                Qos('reliable' if offered == {'RELIABLE'} else 'best_effort')), raw=True)

    def _received(self, data: bytes) -> None:
        try:
            raw = self._number(data)
        except MalformedError as error:
            self._node.get_logger().warning(f'{self.name}: {error}', throttle_duration_sec=5.0)
            return
        self.stamp = stamp_of(data) if self._codec.has_stamp else self._node.now()
        self.value = self._entry.to_si(raw, self._pick.unit, self._pick.absolute)
        self.at = time.monotonic()
        self._on_number(self)

    def _number(self, data: bytes) -> float:
        path = self._pick.path
        if self._diagnostic:
            return float(read_values([data], [path])[path][0])
        if self._layout is None or not self._layout.fits(data):
            self._layout = Layout(self._codec, data, [path])
            self.refused = '' if self._layout.numbers[0] else (
                f'{self._source}: channels.{self._entry.channel}: a message of {self.name} has '
                f"no '{path}'")
            if self.refused:
                self._node.get_logger().error(self.refused, throttle_duration_sec=5.0)
        return self._layout.read(data)[0]

    def found(self) -> str:
        """Return the topic's name and what is there of its publisher."""
        if self._subscription is None:
            return f'{self.name} ({self._wrong or "nobody publishes it"})'
        return f'{self.name} (it has a publisher, but no usable message came)'
