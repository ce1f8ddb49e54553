# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The recorder on its own, with publishers that are not ours."""
from collections import Counter
from importlib.util import find_spec
import os
from pathlib import Path
import subprocess
import sys

import mcap.reader
import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import get_typestore, Stores

from .processes import alive, environment, messages, node, PATIENCE, run, wait_for

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


def test_nothing_is_lost_through_rosbag2_py(tmp_path, monkeypatch):
    """Or through what has its interface, where it is not installed."""
    if find_spec('rosbag2_py') is None:
        stand_in = Path(__file__).parents[1] / 'bag' / 'stand_in'
        monkeypatch.setattr('test.nodes.processes.TREE', os.pathsep.join(
            [str(stand_in), environment()['PYTHONPATH']]))
    bag = record(tmp_path, 'RELIABLE')
    assert Counter(topic for topic, _, _ in messages(bag)) == dict.fromkeys(TOPICS, COUNT)
    with open(next(bag.glob('*.mcap')), 'rb') as stream:
        assert mcap.reader.make_reader(stream).get_header().library != 'hst_drive'


def test_best_effort_publishers_are_matched_and_noted(tmp_path):
    bag = record(tmp_path, 'BEST_EFFORT')
    assert {topic for topic, _, _ in messages(bag)} == set(TOPICS)
    assert 'reliability: best_effort' in (bag / 'metadata.yaml').read_text()


def test_a_recorder_without_publishers_leaves_nothing_so_that_the_name_stays_free(tmp_path):
    bag = tmp_path / 'bag'
    for _ in range(2):
        with node('recorder', '-p', f'output:={bag}') as process:
            wait_for(bag.is_dir)
        assert process.out.splitlines()[-1] == 'recorded 0' and not bag.exists()


def refused(folder):
    """Return what a recorder says that refuses to record to a folder."""
    done = subprocess.run(
        [sys.executable, '-m', 'hst_drive.nodes.recorder', '--ros-args', '-p',
         f'output:={folder}'], env=environment(), timeout=PATIENCE, capture_output=True, text=True)
    assert done.returncode == 2 and 'Traceback' not in done.stderr
    return done.stderr


def test_it_refuses_a_folder_that_exists(tmp_path):
    assert 'exists already' in refused(tmp_path)


def test_it_ends_while_others_go_on_publishing(tmp_path):
    """Ctrl-C on the recorder alone: the rig does not stop for it."""
    bag = tmp_path / 'bag'
    with node('plant', '-p', 'rate:=50.0') as plant:
        with node('recorder', '-p', f'output:={bag}', '-p', 'topics:=[/drive/motor]'):
            wait_for(lambda: any(path.stat().st_size > 5000 for path in bag.glob('*.mcap')))
        assert alive(plant.pid)
    assert len(messages(bag)) > 20


@pytest.fixture
def without_mcap(tmp_path, monkeypatch):
    """Hide the libraries that a sourced ROS 2 of Ubuntu does not have, from child processes."""
    for name in ('mcap', 'lz4', 'zstandard'):
        (tmp_path / 'hidden' / name).mkdir(parents=True)
        (tmp_path / 'hidden' / name / '__init__.py').write_text(
            f'raise ModuleNotFoundError("No module named {name}", name={name!r})\n')
    monkeypatch.setattr('test.nodes.processes.TREE', os.pathsep.join(
        [str(tmp_path / 'hidden'), environment()['PYTHONPATH']]))


@pytest.mark.usefixtures('without_mcap')
def test_without_the_library_for_bags(tmp_path):
    """One line says what to install; nothing is started."""
    code, out, err = run('run', 'paper_step', '-o', str(tmp_path / 'bag'))
    assert code == 2 and not out and 'pip install mcap' in err
    assert 'Traceback' not in err and not (tmp_path / 'bag').exists()
    assert 'pip install mcap' in refused(tmp_path / 'bag')


@pytest.mark.usefixtures('without_mcap')
def test_the_nodes_can_be_loaded_without_it():
    """Plant and the rest work with ROS 2's own recorder."""
    names = ', '.join(f'hst_drive.nodes.{name}' for name in (
        'plant', 'controller', 'estimator', 'load_profile', 'recorder'))
    done = subprocess.run([sys.executable, '-c', f'import {names}'], env=environment(),
                          timeout=PATIENCE, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
