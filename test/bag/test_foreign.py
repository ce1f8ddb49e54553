# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Bags of other machines, written by the independent package ``rosbags``."""
import random

from hst_drive.bag import read_log
from hst_drive.bag.channels import parse_channel_map
from hst_drive.errors import InputError
import numpy as np
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

STORE = get_typestore(Stores.ROS2_JAZZY)
COUNT = 60
STEP = 10**7
MAP = parse_channel_map({'channels': {
    'motor_speed': {'from': '/rig/joints.velocity[drill]'},
    'load_torque': {'from': '/rig/joints.effort[1]'},
    'pump_outlet_pressure': {'from': '/rig/p1.fluid_pressure'},
    'oil_temperature': {'from': '/rig/oil.temperature'},
    'pump_command': {'from': '/rig/joystick.data', 'unit': 'V'},
    'motor_inlet_flow': {'from': '/plc.data[2]', 'unit': 'L/min'},
    'motor_torque': {'from': '/diagnostics.status[rig: torque sensor].values[shaft torque]',
                     'unit': 'N.m'}}}, 'map.yaml')


def kind(name):
    """Return a message class of the other library by its short name."""
    return STORE.types[name.replace('/', '/msg/')]


def messages(count=COUNT):
    """Return (topic, type, time in ns, message) of a short recording of a foreign rig."""
    header, time = kind('std_msgs/Header'), kind('builtin_interfaces/Time')
    pair, status = kind('diagnostic_msgs/KeyValue'), kind('diagnostic_msgs/DiagnosticStatus')
    layout = kind('std_msgs/MultiArrayLayout')([], 0)
    found = []
    for i in range(count):
        at = 10**18 + i * STEP
        stamped = header(time(at // 10**9, at % 10**9), 'rig')
        pairs = [pair('noise', 'n/a'), pair('shaft torque', str(1.5 * i))]
        found += [(topic, name, at, kind(name)(*fields)) for topic, name, fields in (
            ('/rig/joints', 'sensor_msgs/JointState', (
                stamped, ['fan', 'drill'], np.zeros(2), np.array([9.0, 0.1 * i]),
                np.array([8.0, 2.0 * i]))),
            ('/rig/p1', 'sensor_msgs/FluidPressure', (stamped, 101325.0 + 1e5 * i, 0.0)),
            ('/rig/oil', 'sensor_msgs/Temperature', (stamped, 40.0 + 0.01 * i, 0.0)),
            ('/rig/joystick', 'std_msgs/Float64', (0.1 * i,)),
            ('/plc', 'std_msgs/Float64MultiArray', (layout, np.array([1.0, 2.0, 6.0 * i]))),
            ('/diagnostics', 'diagnostic_msgs/DiagnosticArray', (stamped, [
                status(0, 'rig: other', '', '', []),
                status(0, 'rig: torque sensor', 'fine', '', pairs)])),
            ('/diagnostics', 'diagnostic_msgs/DiagnosticArray', (stamped, [
                status(0, 'rig: door', 'shut', '', [])])))]
    return found


def write(folder, found, plugin=StoragePlugin.MCAP, mode=CompressionMode.NONE):
    """Write a bag in the order given."""
    bag = Writer(folder, version=9, storage_plugin=plugin)
    bag.set_compression(mode, CompressionFormat.ZSTD)
    with bag:
        connections = {}
        for topic, name, at, message in found:
            name = name.replace('/', '/msg/')
            if topic not in connections:
                connections[topic] = bag.add_connection(topic, name, typestore=STORE)
            bag.write(connections[topic], at, STORE.serialize_cdr(message, name))
    return folder


def check(run):
    """Compare with what was written, in SI."""
    i = np.arange(COUNT)
    for channel, values in (
            ('motor_speed', 0.1 * i), ('load_torque', 2.0 * i), ('pump_outlet_pressure', 1e5 * i),
            ('oil_temperature', 40.0 + 0.01 * i), ('pump_command', 0.1 * i),
            ('motor_inlet_flow', 6.0 * i / 6e4), ('motor_torque', 1.5 * i)):
        scale = 273.15 if channel == 'oil_temperature' and run[channel][0] > 200 else 0.0
        np.testing.assert_allclose(run[channel], values + scale, rtol=1e-9, atol=1e-9,
                                   err_msg=channel)
    np.testing.assert_allclose(run.time, i * 0.01, atol=1e-9)


@pytest.mark.parametrize('plugin', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize('mode', list(CompressionMode))
def test_every_storage_and_compression(tmp_path, plugin, mode):
    if mode == CompressionMode.STORAGE and plugin == StoragePlugin.SQLITE3:
        pytest.skip('sqlite3 has none of its own')
    folder = write(tmp_path / 'bag', messages(), plugin, mode)
    check(read_log(folder, MAP))
    if mode == CompressionMode.MESSAGE:
        return      # what a file holds is then written in metadata.yaml alone
    (folder / 'metadata.yaml').unlink()
    check(read_log(folder, MAP))
    check(read_log(next(folder.iterdir()), MAP))


@pytest.mark.parametrize('plugin', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_messages_out_of_order_are_sorted_and_told(tmp_path, plugin):
    found = messages()
    random.Random(3).shuffle(found)
    run = read_log(write(tmp_path / 'bag', found, plugin), MAP)
    check(run)
    assert any('out of order' in note for note in run.notes)


@pytest.mark.parametrize('plugin', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize('packed', [CompressionMode.NONE, CompressionMode.FILE])
def test_a_bag_of_several_files(tmp_path, plugin, packed):
    found = messages()
    first = write(tmp_path / 'bag', found[:200], plugin, packed)
    second = write(tmp_path / 'rest', found[200:], plugin, packed)
    name = next(path.name for path in first.iterdir() if path.name != 'metadata.yaml')
    other = name.replace('bag.', 'bag_1.')
    (second / name.replace('bag.', 'rest.')).rename(first / other)
    metadata = (first / 'metadata.yaml').read_text()
    lines = [line for line in metadata.splitlines() if line.strip() == f'- {name}']
    assert len(lines) == 1
    (first / 'metadata.yaml').write_text(metadata.replace(
        lines[0], f'{lines[0]}\n{lines[0].replace(name, other)}'))
    check(read_log(first, MAP))


def test_two_publishers_on_a_topic_are_told_and_left_out(tmp_path):
    found = []
    for topic, name, at, message in messages():
        found.append((topic, name, at, message))
        if topic == '/rig/p1':
            stamp = kind('builtin_interfaces/Time')((at + STEP // 2) // 10**9,
                                                    (at + STEP // 2) % 10**9)
            found.append((topic, name, at + STEP // 2, kind(name)(
                kind('std_msgs/Header')(stamp, 'other'), 5e7, 0.0)))
    run = read_log(write(tmp_path / 'bag', found), MAP)
    assert [note for note in run.notes if 'two publishers' in note][0].startswith('/rig/p1: ')
    assert 'pump_outlet_pressure' not in run.channels and 'motor_speed' in run.channels
    plain = read_log(write(tmp_path / 'plain', messages()), MAP)
    assert not any('two publishers' in note for note in plain.notes)


def test_a_clock_that_was_set_back_is_told_and_put_right(tmp_path):
    header, time = kind('std_msgs/Header'), kind('builtin_interfaces/Time')
    found = []
    for i in range(COUNT):
        at = 10**18 + i * STEP - (3600 * 10**9 if i >= COUNT // 2 else 0)
        found.append(('/p1', 'sensor_msgs/FluidPressure', at, kind('sensor_msgs/FluidPressure')(
            header(time(at // 10**9, at % 10**9), ''), 2e5 + i, 0.0)))
    run = read_log(write(tmp_path / 'bag', found), parse_channel_map(
        {'channels': {'pump_outlet_pressure': '/p1.fluid_pressure'}}, 'm'))
    assert len(run) == COUNT
    np.testing.assert_allclose(np.diff(run['pump_outlet_pressure']), 1.0, atol=1e-6)
    np.testing.assert_allclose(np.diff(run.time), STEP / 1e9, atol=1e-9)
    assert [note for note in run.notes if 'set back by 3.6e+03 s' in note] == list(run.notes)


def test_of_several_joints_none_is_read_unless_a_map_names_it(tmp_path):
    header, time = kind('std_msgs/Header'), kind('builtin_interfaces/Time')
    found = []
    for i in range(COUNT):
        at = 10**18 + i * STEP
        found.append(('/rig/motor', 'sensor_msgs/JointState', at, kind('sensor_msgs/JointState')(
            header(time(at // 10**9, at % 10**9), ''), ['drill', 'winch'],
            np.zeros(2), np.array([i, 7.0]), np.zeros(2))))
    folder = write(tmp_path / 'bag', found)
    with pytest.raises(InputError, match=r'/rig/motor: 2 joints \(drill, winch\); name the one'
                       r".*motor_speed: '/rig/motor.velocity\[NAME\]'") as caught:
        read_log(folder)
    assert '\n' not in str(caught.value)
    picked = read_log(folder, parse_channel_map(
        {'channels': {'motor_speed': '/rig/motor.velocity[winch]',
                      'load_torque': '/rig/motor.effort[winch]'}}, 'm'))
    assert (picked['motor_speed'] == 7.0).all()
    with pytest.raises(InputError, match='under namespace /other. It holds: /rig/motor'):
        read_log(folder, parse_channel_map({'namespace': '/other'}, 'm'))


@pytest.mark.parametrize('source, said', [
    ('/diagnostics.status[rig: torque sensor].values[x]', 'shaft torque'),
    ('/diagnostics.status[0]', 'expected status[NAME].values[KEY]'),
    ('/plc.data[3]', 'elements 0 to 2'),
    ('/plc.data', 'data[0]'),
])
def test_what_is_not_there_is_named_with_what_is(tmp_path, source, said):
    folder = write(tmp_path / 'bag', messages())
    with pytest.raises(InputError) as caught:
        read_log(folder, parse_channel_map(
            {'channels': {'motor_torque': {'from': source, 'unit': 'N.m'}}}, 'map.yaml'))
    assert said in str(caught.value) and 'map.yaml: channels.motor_torque' in str(caught.value)


def test_files_outside_of_the_bag_are_not_opened(tmp_path):
    folder = write(tmp_path / 'bag', messages())
    (folder / 'bag.mcap').rename(tmp_path / 'secret.mcap')
    metadata = folder / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace('bag.mcap', '../secret.mcap'))
    with pytest.raises(InputError, match='outside of the bag'):
        read_log(folder, MAP)


@pytest.mark.parametrize('turns, read', [
    ([['drill']], True), ([[]], True), ([['drill'], ['drill']], True),
    ([['drill'], ['fan']], False), ([['drill']] * 40 + [['fan', 'drill']], False)])
def test_the_only_joint_must_stay_the_same_one(tmp_path, turns, read):
    header, time = kind('std_msgs/Header'), kind('builtin_interfaces/Time')
    found = []
    for i in range(COUNT):
        at, names = 10**18 + i * STEP, turns[i % len(turns)]
        found.append(('/rig/motor', 'sensor_msgs/JointState', at, kind('sensor_msgs/JointState')(
            header(time(at // 10**9, at % 10**9), ''), names, np.zeros(0),
            np.full(max(len(names), 1), 0.1 * i), np.zeros(0))))
    folder = write(tmp_path / 'bag', found)
    if read:
        np.testing.assert_allclose(read_log(folder)['motor_speed'], 0.1 * np.arange(COUNT))
        return
    with pytest.raises(InputError, match='joints.*name the one to read in a channel map'):
        read_log(folder)
