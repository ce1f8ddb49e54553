# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Publishers and subscriptions made from the table of topics."""
from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
import math
import struct

from hst_drive.bag.cdr import Codec, MalformedError
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.joints import JointChoice
from hst_drive.bag.topics import (ATMOSPHERE, Field, FLUID_PRESSURE, JOINT_STATE, Qos,
                                  TEMPERATURE, Topic, TOPICS, TRUTH)
from hst_drive.errors import InputError
from hst_drive.nodes.wiring import SENSORS
from hst_drive.units import canonical, UNITS
from rclpy.publisher import Publisher
from rclpy.qos import (DurabilityPolicy, qos_check_compatible, QoSCompatibility, QoSProfile,
                       ReliabilityPolicy)
from rclpy.qos_overriding_options import QoSOverridingOptions

BILLION = 1_000_000_000
_STAMP = struct.Struct('<iI')
_STAMP_AT = 4   # behind the encapsulation


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


def partners_of(node, end) -> int:
    """
    Return how many of a node's partners are at the other end of its publisher or subscription.

    Who does not speak on ``sync`` only looks on; the middleware's count does not say whom it has.
    """
    partners = {(entry.node_namespace, entry.node_name) for entry in
                node.get_publishers_info_by_topic(node.sync.publisher.topic_name)}
    if publishes := isinstance(end, Publisher):
        others = node.get_subscriptions_info_by_topic(end.topic_name)
        matched = end.get_subscription_count()
    else:
        others = node.get_publishers_info_by_topic(end.topic_name)
        matched = end.get_publisher_count()
    for other in others:
        offered, wanted = (end, other) if publishes else (other, end)
        fits = qos_check_compatible(offered.qos_profile, wanted.qos_profile)[0]
        matched -= ((other.node_namespace, other.node_name) not in partners
                    and fits != QoSCompatibility.ERROR)
    return matched


def stamp_of(data: bytes) -> int:
    """Return the time stamp (ns) of a serialised message that begins with a header."""
    seconds, nanoseconds = _STAMP.unpack_from(data, _STAMP_AT)
    return seconds * BILLION + nanoseconds


def has_time(stamp: int, log) -> bool:
    """Say whether there is a time to stamp a message with; tell if not."""
    if stamp <= 0:
        log.warning('there is no time yet: use_sim_time is set and nobody publishes /clock; '
                    'nothing is published until then', throttle_duration_sec=5.0)
    return stamp > 0


def _scale(field: Field) -> tuple[float, float, float]:
    """
    Return factor, offset, shift of a field: ``channel = message * factor + offset + shift``.

    As ``Field.from_channel`` converts the other way, but the unit is looked up once.
    """
    unit = UNITS[canonical(field.unit)]
    return unit.factor, unit.offset, -ATMOSPHERE if field.absolute else 0.0


class Layout:
    """
    Where the numbers lie in serialised messages like this one.

    Packing them in place costs a tenth of what rclpy's conversion does, and lockstep lives on
    that. (It also leaves no bytes of foreign memory in the padding, as rclpy does.)
    """

    def __init__(self, codec: Codec, data: bytes, paths: list[str]):
        offsets, fixed = codec.layout(data, paths)
        self.numbers = [(struct.Struct(offsets[path][1]), offsets[path][0])
                        if path in offsets else None for path in paths]
        self._length = len(data)
        self._fixed = [(at, at + size, data[at:at + size]) for at, size in fixed]

    def fits(self, data: bytes) -> bool:
        """Return whether a message has this layout."""
        if len(data) != self._length:
            return False
        for start, end, same in self._fixed:
            if data[start:end] != same:
                return False
        return True

    def read(self, data: bytes) -> list[float]:
        """Return the numbers; NaN for an element that these messages do not have."""
        return [number[0].unpack_from(data, number[1])[0] if number else math.nan
                for number in self.numbers]


@contextmanager
def _wrong_override(node, name: str) -> Iterator[None]:
    """Tell in one line what is wrong with the quality of service that a user gave a topic."""
    try:
        yield
    except RuntimeError as error:
        if 'QoS' not in str(error):
            raise
        raise InputError(f'qos_overrides.{node.resolve_topic_name(name)}: {error}; see '
                         'docs/integration.md') from None


class Output:
    """
    A publisher of one topic of the table.

    Attributes
    ----------
    published : int
        Messages published until now.
    names : tuple of str
        Topics that it publishes.
    wrong : str
        Why what it publishes is not taken; '' if nothing is known of that.

    """

    def __init__(self, node, topic: Topic, variance: float = 0.0):
        self.topic = topic
        self._log = node.get_logger()
        paths = [field.path for field in topic.fields]
        template = {'header': {'frame_id': topic.frame}}
        if topic.type == JOINT_STATE:
            template['name'] = [topic.frame]
            template.update({path.partition('[')[0]: [0.0] for path in paths})
        if topic.type in (FLUID_PRESSURE, TEMPERATURE):
            template['variance'] = variance
        codec = Codec(topic.type, find_definition(topic.type))
        data = codec.encode(template)
        self._data = bytearray(data)
        self._fields = [(number.pack_into, offset, *_scale(field)) for (number, offset), field in
                        zip(Layout(codec, data, paths).numbers, topic.fields)]
        with _wrong_override(node, topic.name):
            self.publisher = node.create_publisher(
                message_class(topic.type), topic.name, qos_profile(topic.qos),
                qos_overriding_options=QoSOverridingOptions.with_default_policies())
        self.published = 0
        self.names, self.wrong = (self.publisher.topic_name,), ''

    def publish(self, stamp: int, *values: float) -> None:
        """Publish values (SI, in the order of the table's fields) that were true at stamp, ns."""
        if not has_time(stamp, self._log):
            return
        data = self._data
        _STAMP.pack_into(data, _STAMP_AT, *divmod(stamp, BILLION))
        for (pack_into, at, factor, offset, shift), value in zip(self._fields, values):
            pack_into(data, at, (value - shift - offset) / factor)
        self.publisher.publish(bytes(data))
        self.published += 1


class ClockOutput:
    """The publisher of /clock; ``ahead`` is how many messages a reader may be behind."""

    def __init__(self, node, ahead: int):
        topic = TOPICS['/clock']
        self._data = bytearray(Codec(topic.type, find_definition(topic.type)).encode({}))
        self.publisher = node.create_publisher(
            message_class(topic.type), topic.name, qos_profile(topic.qos, ahead))

    def publish(self, stamp: int) -> None:
        """Publish a time, ns."""
        _STAMP.pack_into(self._data, _STAMP_AT, *divmod(stamp, BILLION))
        self.publisher.publish(bytes(self._data))


class Input:
    """
    A subscription of one topic of the table; calls ``callback(stamp ns, SI values)``.

    NaN stands for an element that a message does not have; a message that cannot be read is
    passed over with a warning.

    Parameters
    ----------
    node : DriveNode
        Owner.
    topic : Topic
        Row of the table.
    callback : callable
        As above.
    joint : str
        The node's parameter that names the joint to read, for a JointState.

    Attributes
    ----------
    name : str
        The topic's full name.
    received : int
        Messages that could be read until now.
    refused : str
        Why the last message has no numbers, as it does not tell the joint; '' if it does.

    """

    def __init__(self, node, topic: Topic, callback: Callable[[int, tuple[float, ...]], None],
                 joint: str = ''):
        self.topic = topic
        self._callback = callback
        self._codec = Codec(topic.type, find_definition(topic.type))
        self._paths = [field.path for field in topic.fields]
        self._scales = [_scale(field) for field in topic.fields]
        self._layout: Layout | None = None
        self._joint, self.refused, self.received = joint, '', 0
        self._choice = JointChoice(node.settings[joint]) if joint else None
        self._node = node
        self._log = node.get_logger()
        # As for sensor data: that takes publishers that are reliable and those that are not. In
        # lockstep a lost reading would stop the run.
        wanted = topic.qos if node.lockstep or topic.name not in SENSORS else topic.qos._replace(
            reliability='best_effort')
        with _wrong_override(node, topic.name):
            self.subscription = node.create_subscription(
                message_class(topic.type), topic.name, self._received, qos_profile(wanted),
                qos_overriding_options=QoSOverridingOptions.with_default_policies(), raw=True)
        self.name = self.subscription.topic_name

    def _received(self, data: bytes) -> None:
        try:
            if self._layout is None or not self._layout.fits(data):
                self._layout = Layout(self._codec, data, self._paths_in(data))
            values = self._layout.read(data)
        except MalformedError as error:
            self._log.warning(f'{self.topic.name}: {error}', throttle_duration_sec=5.0)
            return
        self.received += 1
        self._callback(stamp_of(data), tuple([
            value * factor + offset + shift
            for value, (factor, offset, shift) in zip(values, self._scales)]))

    def _paths_in(self, data: bytes) -> list[str]:
        """Return where the numbers are in messages like this one; nowhere if it is refused."""
        if self._choice is None:
            return self._paths
        place, why = self._choice.place(self._codec.arrays(data))
        self.refused = f'{why}: name the one to read in the parameter {self._joint}' if why else ''
        if why:
            self._log.error(f'{self.topic.name}: {self.refused}', throttle_duration_sec=5.0)
            return [''] * len(self._paths)
        return [path.replace('[0]', f'[{place}]') for path in self._paths]

    def found(self) -> str:
        """Return the topic's name and what is there of its publishers."""
        name = self.name
        matched = self.subscription.get_publisher_count()
        if matched:
            return f'{name} (it has a publisher, but no usable message came)'
        if self._node.count_publishers(name):
            return (f'{name} (its publisher does not fit: compare type and quality of service, '
                    f'ros2 topic info -v {name})')
        return f'{name} (nobody publishes it)'
