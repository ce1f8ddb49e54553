# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The recorder on its own, with publishers that are not ours."""
from collections import Counter
import subprocess
import sys

import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import get_typestore, Stores

from .processes import environment, messages, node, PATIENCE, wait_for

pytest.importorskip('rclpy')
TOPICS = [f'/rig/imu_{number}' for number in range(10)]
COUNT, RATE = 1000, 200

PUBLISHER = f"""
import time
import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Imu
rclpy.init()
node = rclpy.create_node('rig')
qos = QoSProfile(depth=100, reliability=ReliabilityPolicy['%s'])
publishers = [node.create_publisher(Imu, name, qos) for name in {TOPICS}]
while any(p.get_subscription_count() < 1 for p in publishers):
    time.sleep(0.02)
message = Imu()
begin = time.monotonic()
for count in range({COUNT}):
    message.header.stamp = node.get_clock().now().to_msg()
    message.orientation.x = float(count)
    for publisher in publishers:
        publisher.publish(message)
    time.sleep(max(0.0, begin + (count + 1) / {RATE} - time.monotonic()))
for publisher in publishers:
    publisher.wait_for_all_acked()
time.sleep(0.5)
"""


def record(tmp_path, reliability):
    """Record what the publisher sends; return the bag."""
    bag = tmp_path / 'bag'
    names = '[' + ','.join(TOPICS) + ']'
    with node('recorder', '-p', f'output:={bag}', '-p', f'topics:={names}'):
        rig = subprocess.run([sys.executable, '-c', PUBLISHER % reliability], env=environment(),
                             timeout=PATIENCE, capture_output=True, text=True)
        assert rig.returncode == 0, rig.stderr
    return bag


def test_ten_topics_at_200_hz_lose_nothing(tmp_path):
    bag = record(tmp_path, 'RELIABLE')
    assert Counter(topic for topic, _, _ in messages(bag)) == dict.fromkeys(TOPICS, COUNT)
    store = get_typestore(Stores.ROS2_JAZZY)
    with Reader(bag) as reader:
        chosen = [c for c in reader.connections if c.topic == TOPICS[3]]
        found = [store.deserialize_cdr(data, connection.msgtype).orientation.x
                 for connection, _, data in reader.messages(chosen)]
    assert found == list(range(COUNT))


def test_best_effort_publishers_are_matched_and_noted(tmp_path):
    bag = record(tmp_path, 'BEST_EFFORT')
    assert {topic for topic, _, _ in messages(bag)} == set(TOPICS)
    assert 'reliability: best_effort' in (bag / 'metadata.yaml').read_text()


def test_a_recorder_without_publishers_leaves_an_empty_bag_that_is_whole(tmp_path):
    bag = tmp_path / 'bag'
    with node('recorder', '-p', f'output:={bag}'):
        wait_for(bag.is_dir)
    assert (bag / 'metadata.yaml').is_file()


def test_it_refuses_a_folder_that_exists(tmp_path):
    done = subprocess.run(
        [sys.executable, '-m', 'hst_drive.nodes.recorder', '--ros-args', '-p',
         f'output:={tmp_path}'], env=environment(), timeout=PATIENCE, capture_output=True,
        text=True)
    assert done.returncode == 2
    assert 'exists already' in done.stderr and 'Traceback' not in done.stderr
