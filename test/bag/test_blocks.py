# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Bags come in blocks of messages: what is read does not hang on where one ends."""
import tracemalloc

from hst_drive.bag import mcap_bag, read_log, write_run
from hst_drive.bag.cdr import Codec
from hst_drive.bag.channels import parse_channel_map
from hst_drive.bag.definitions import find_definition
from hst_drive.errors import InputError
from mcap.reader import make_reader
from mcap.writer import Writer
import numpy as np
import pytest

from .records import make_run, write_bag
from .test_bags import VECTOR, vector


def test_a_bag_is_read_as_numbers_not_as_messages(tmp_path):
    """16 bytes a number, and as much for a while; a message takes some 200."""
    write_run(tmp_path / 'b', make_run(20000))
    tracemalloc.start()
    read_log(tmp_path / 'b')
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20000 * 7 * 100


def test_blocks_put_together_are_the_whole(tmp_path, monkeypatch):
    write_run(tmp_path / 'b', make_run(900))
    whole = read_log(tmp_path / 'b')
    monkeypatch.setattr(mcap_bag, 'BLOCK', 150)
    parts = read_log(tmp_path / 'b')
    assert parts.notes == whole.notes
    np.testing.assert_array_equal(parts.time, whole.time)
    for name in whole.channels:
        np.testing.assert_array_equal(parts[name], whole[name])


def test_a_topic_under_two_types_is_read_where_the_map_fits(tmp_path):
    float64 = 'std_msgs/msg/Float64'
    codec = Codec(float64, find_definition(float64))
    folder = tmp_path / 'b'
    times = range(0, 20 * 10**7, 10**7)
    write_bag(folder, {
        '/x': (float64, [(at, codec.encode({'data': at // 10**7})) for at in times]),
        '/d/pump_command': (VECTOR, [(at, vector(at, 5.0)) for at in times])})
    file = next(folder.glob('*.mcap'))
    with open(file, 'rb') as source, open(tmp_path / 'two.mcap', 'wb') as target:
        writer = Writer(target)
        writer.start('ros2', 'test')
        schemas = {kind: writer.register_schema(kind, 'ros2msg', find_definition(kind).encode())
                   for kind in (VECTOR, float64)}
        other = writer.register_channel('/x', 'cdr', schemas[VECTOR])
        writer.add_message(other, 0, vector(0, 1.0), 0)
        ids = {}
        for schema, channel, message in make_reader(source).iter_messages():
            if channel.topic not in ids:
                ids[channel.topic] = writer.register_channel(channel.topic, 'cdr',
                                                             schemas[schema.name])
            writer.add_message(ids[channel.topic], message.log_time, message.data,
                               message.publish_time)
        writer.finish()
    run = read_log(tmp_path / 'two.mcap', parse_channel_map({'channels': {
        'motor_torque': {'from': '/x.data', 'unit': 'N.m'}}}, 'map.yaml'))
    np.testing.assert_array_equal(run['motor_torque'], np.arange(20.0))


def test_topics_without_numbers_are_told(tmp_path):
    joint = 'sensor_msgs/msg/JointState'
    codec = Codec(joint, find_definition(joint))
    write_bag(tmp_path / 'b', {'/d/motor': (joint, [
        (k * 10**7, codec.encode({'header': {'stamp': {'sec': k}}})) for k in range(20)])})
    with pytest.raises(InputError, match='none of our topics holds a number'):
        read_log(tmp_path / 'b')
