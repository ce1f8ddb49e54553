# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Publishers and subscriptions made from the table of topics."""
from __future__ import annotations

from array import array
from collections.abc import Callable
from importlib import import_module
import math
import re
import struct

from hst_drive.bag.topics import Qos, Topic, TOPICS
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message

TRUTH = 'truth/'
"""Sub-namespace of the noise-free values that a real rig could not publish."""
BILLION = 1_000_000_000
_STAMP, _NUMBER = struct.Struct('<iI'), struct.Struct('<d')
_STAMP_AT = 4   # behind the encapsulation
_MARKER = -1.2345678901234567e-300


def topic_named(name: str) -> Topic:
    """Return the row of the table; ``truth/motor`` is the row of ``motor`` without its noise."""
    if name.startswith(TRUTH):
        return TOPICS[name[len(TRUTH):]]._replace(name=name)
    return TOPICS[name]


def message_class(type_name: str):
    """Return the Python class of ``package/msg/Type``."""
    package, _, name = type_name.split('/')
    return getattr(import_module(f'{package}.msg'), name)


def qos_profile(qos: Qos, depth: int | None = None) -> QoSProfile:
    """Return the table's quality of service as rclpy's, with another depth if given."""
    return QoSProfile(
        depth=depth or qos.depth, durability=DurabilityPolicy[qos.durability.upper()],
        reliability=ReliabilityPolicy[qos.reliability.upper()])


def stamp_of(data: bytes) -> int:
    """Return the time stamp (ns) of a serialised message that begins with a header."""
    seconds, nanoseconds = _STAMP.unpack_from(data, _STAMP_AT)
    return seconds * BILLION + nanoseconds


def _place(message, path: str) -> tuple[object, str, int | None]:
    """Return the object, attribute and index that a path such as ``velocity[0]`` points to."""
    owner, name, index = re.fullmatch(r'(?:([\w.]+)\.)?(\w+)(?:\[(\d+)\])?', path).groups()
    for part in owner.split('.') if owner else ():
        message = getattr(message, part)
    return message, name, None if index is None else int(index)


class Layout:
    """
    Where the numbers lie in the serialised form of messages like this one.

    Packing them in place costs a tenth of what rclpy's conversion does, and lockstep lives on
    that. Found by putting a marker into each number in turn, so it holds for any message type.
    """

    def __init__(self, message, paths: list[str]):
        self.offsets = []
        for path in paths:
            owner, name, index = _place(message, path)
            values = owner if index is None else getattr(owner, name)
            known = getattr(owner, name) if index is None else values[index]
            _assign(values, name, index, _MARKER)
            self.offsets.append(serialize_message(message).index(_NUMBER.pack(_MARKER)))
            _assign(values, name, index, known)
        data = serialize_message(message)
        ends = sorted(_spans(self.offsets))
        self._length = len(data)
        self._between = [(end, start, data[end:start]) for (_, end), (start, _) in zip(
            ends, [*ends[1:], (len(data), None)])]

    def fits(self, data: bytes) -> bool:
        """Return whether a serialised message has this layout."""
        return len(data) == self._length and all(
            data[start:end] == same for start, end, same in self._between)


def _spans(offsets: list[int]) -> list[tuple[int, int]]:
    """Return begin and end of what may differ: encapsulation's end to stamp, and numbers."""
    return [(_STAMP_AT, _STAMP_AT + _STAMP.size), *((at, at + 8) for at in offsets)]


def _assign(owner, name: str, index: int | None, value: float) -> None:
    if index is None:
        setattr(owner, name, value)
    else:
        owner[index] = value


class Output:
    """
    A publisher of one topic of the table.

    Attributes
    ----------
    published : int
        Messages published until now.

    """

    def __init__(self, node, topic: Topic, variance: float = 0.0):
        self.topic = topic
        message = message_class(topic.type)()
        message.header.frame_id = topic.frame
        if hasattr(message, 'name'):
            message.name = [topic.frame]
        if hasattr(message, 'variance'):
            message.variance = variance
        paths = [field.path for field in topic.fields]
        for path in paths:
            owner, name, index = _place(message, path)
            if index is not None:
                setattr(owner, name, array('d', [0.0] * (index + 1)))
        self._data = bytearray(serialize_message(message))
        self._layout = Layout(message, paths)
        self._convert = [field.from_channel for field in topic.fields]
        self.publisher = node.create_publisher(
            type(message), topic.name, qos_profile(topic.qos))
        self.published = 0

    def publish(self, stamp: int, *values: float) -> None:
        """Publish values (SI, in the order of the table's fields) that were true at stamp, ns."""
        data = self._data
        _STAMP.pack_into(data, _STAMP_AT, *divmod(stamp, BILLION))
        for offset, convert, value in zip(self._layout.offsets, self._convert, values):
            _NUMBER.pack_into(data, offset, convert(value))
        self.publisher.publish(bytes(data))
        self.published += 1

    def connected(self, readers: int) -> bool:
        """Return whether as many subscriptions are matched."""
        return self.publisher.get_subscription_count() >= readers


class Input:
    """
    A subscription of one topic of the table; calls ``callback(stamp ns, SI values)``.

    Another publisher's messages may be laid out differently: then rclpy decodes them. NaN
    stands for an element that a message does not have.
    """

    def __init__(self, node, topic: Topic, callback: Callable[[int, tuple[float, ...]], None]):
        self.topic = topic
        self._callback = callback
        self._type = message_class(topic.type)
        self._layout: Layout | None = None
        self.subscription = node.create_subscription(
            self._type, topic.name, self._received, qos_profile(topic.qos), raw=True)

    def _received(self, data: bytes) -> None:
        if self._layout is None or not self._layout.fits(data):
            values = self._decode(data)
        else:
            values = [_NUMBER.unpack_from(data, offset)[0] for offset in self._layout.offsets]
        self._callback(stamp_of(data), tuple([
            field.to_channel(value) for field, value in zip(self.topic.fields, values)]))

    def _decode(self, data: bytes) -> list[float]:
        message = deserialize_message(data, self._type)
        values = []
        for field in self.topic.fields:
            owner, name, index = _place(message, field.path)
            value = getattr(owner, name)
            if index is not None:
                value = value[index] if index < len(value) else math.nan
            values.append(value)
        if not any(map(math.isnan, values)):
            self._layout = Layout(message, [field.path for field in self.topic.fields])
        return values

    def connected(self) -> bool:
        """Return whether a publisher is matched."""
        return self.subscription.get_publisher_count() > 0
