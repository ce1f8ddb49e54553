# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Single nodes as a user of ROS 2 meets them: parameters, signals, a partner that is missing."""
import signal
import subprocess
import sys

import pytest
import yaml

from .processes import environment, node, PATIENCE, TREE, wait_for

rclpy = pytest.importorskip('rclpy')

NODES = ('plant', 'controller', 'estimator', 'load_profile', 'recorder')


@pytest.fixture(scope='module')
def client():
    """Return a node to ask with, and a function that waits for an answer."""
    context = rclpy.Context()
    rclpy.init(context=context)
    asker = rclpy.create_node('asker', context=context)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(asker)

    def answer(future):
        executor.spin_until_future_complete(future, timeout_sec=PATIENCE)
        assert future.done()
        return future.result()

    yield asker, answer, executor
    asker.destroy_node()
    rclpy.shutdown(context=context)


def parameters_of(client, name):
    """Return a parameter client that has found its node."""
    from rclpy.parameter_client import AsyncParameterClient

    found = AsyncParameterClient(client[0], f'/drive/{name}')
    assert found.wait_for_services(timeout_sec=PATIENCE)
    for ask in (found.list_parameters, lambda: found.get_parameters(['use_sim_time']),
                lambda: found.describe_parameters(['use_sim_time']),
                lambda: found.set_parameters([]), lambda: found.set_parameters_atomically([])):
        until_answered(client, ask)
    return found


def until_answered(client, ask):
    """Ask again and again: what a node answers before it has seen who listens is lost."""
    for _ in range(30):
        future = ask()
        client[2].spin_until_future_complete(future, timeout_sec=3.0)
        if future.done():
            return
    raise AssertionError('no answer')


@pytest.mark.parametrize('name', NODES)
def test_every_parameter_is_described_and_stands_in_the_yaml(client, name, tmp_path):
    extra = ('-p', f'output:={tmp_path / "bag"}') if name == 'recorder' else ()
    with node(name, '--params-file', str(TREE / 'config' / 'drive.yaml'), *extra):
        asked, answer = parameters_of(client, name), client[1]
        names = [entry for entry in answer(asked.list_parameters()).result.names
                 if not entry.startswith(('qos_overrides', 'start_type_description'))
                 and entry != 'use_sim_time']
        described = answer(asked.describe_parameters(names)).descriptors
        for entry in described:
            assert entry.description, entry.name
            if entry.type in (2, 3):
                assert entry.integer_range or entry.floating_point_range, entry.name
            if entry.type == 3:
                assert '[' in entry.description, entry.name
    listed = yaml.safe_load((TREE / 'config' / 'drive.yaml').read_text())
    listed = set(listed[f'/**/{name}']['ros__parameters'])
    run_only = {'lockstep', 'lookahead', 'partners', 'progress', 'notes'}
    assert listed == set(names) - run_only


def test_gains_change_at_run_time_within_their_range_only(client):
    from rclpy.parameter import Parameter

    with node('controller'):
        asked, answer = parameters_of(client, 'controller'), client[1]

        def put(name, value):
            return answer(asked.set_parameters([Parameter(name, value=value)])).results[0]

        assert put('kp', 0.05).successful
        assert answer(asked.get_parameters(['kp'])).values[0].double_value == 0.05
        assert not put('kp', -1.0).successful
        assert not put('kp', 7).successful
        assert not put('mode', 'open_loop').successful


@pytest.mark.parametrize('name, arguments, word', [
    ('plant', ('-p', 'rate:=0.0'), 'rate'),
    ('plant', ('-p', 'effects:=[nothing]'), 'nothing'),
    ('plant', ('-p', 'rig:=nowhere.yaml'), 'nowhere.yaml'),
    ('plant', ('-p', 'lockstep:=true'), 'partners'),
    ('controller', ('-p', 'mode:=sideways'), 'sideways'),
    ('controller', ('-p', 'partners:=[nobody]'), 'nobody'),
    ('load_profile', ('-p', 'scenario:=nowhere'), 'nowhere'),
    ('recorder', (), 'output'),
])
def test_wrong_parameters_end_a_node_with_one_line(name, arguments, word):
    done = subprocess.run(
        [sys.executable, '-m', f'hst_drive.nodes.{name}', '--ros-args', *arguments],
        env=environment(), timeout=PATIENCE, capture_output=True, text=True)
    assert done.returncode == 2
    assert word in done.stderr.strip().splitlines()[-1] and 'Traceback' not in done.stderr


def test_the_plant_names_the_partner_that_is_not_there():
    done = subprocess.run(
        [sys.executable, '-m', 'hst_drive.nodes.plant', '--ros-args', '-p', 'lockstep:=true',
         '-p', 'partners:=[plant,controller]', '-p', 'partner_timeout:=1.0'],
        env=environment(), timeout=PATIENCE, capture_output=True, text=True)
    assert done.returncode == 1
    assert 'no answer from controller' in done.stderr


def test_sigterm_ends_a_node_cleanly(client):
    with node('plant') as process:
        parameters_of(client, 'plant')
        process.send_signal(signal.SIGTERM)
        wait_for(lambda: process.poll() is not None)


def test_a_plant_alone_publishes_in_real_time(client):
    from sensor_msgs.msg import JointState

    got = []
    heard = client[0].create_subscription(JointState, '/drive/motor', got.append, 1000)
    with node('plant', '-p', 'rate:=200.0'):
        while len(got) < 20:
            client[2].spin_once(timeout_sec=1.0)
    client[0].destroy_subscription(heard)
    stamps = [message.header.stamp.sec * 10**9 + message.header.stamp.nanosec for message in got]
    assert {later - sooner for sooner, later in zip(stamps, stamps[1:])} == {5_000_000}
    assert got[0].name == ['motor'] and len(got[0].velocity) == len(got[0].effort) == 1


def test_a_command_that_is_no_number_is_told_and_the_last_one_held(client):
    from geometry_msgs.msg import Vector3Stamped
    from sensor_msgs.msg import JointState

    got = []
    heard = client[0].create_subscription(JointState, '/drive/motor', got.append, 1000)
    tell = client[0].create_publisher(Vector3Stamped, '/drive/pump_command', 100)
    message = Vector3Stamped()
    with node('plant') as process:
        def turns():
            # The first messages may come before the plant has seen who sends them.
            message.vector.x = 6.0
            tell.publish(message)
            client[2].spin_once(timeout_sec=0.1)
            return got and got[-1].velocity[0] > 5

        wait_for(turns)
        for value in (float('nan'), float('inf')):
            message.vector.x = value
            tell.publish(message)
        del got[:]
        while len(got) < 100:
            client[2].spin_once(timeout_sec=1.0)
    client[0].destroy_publisher(tell)
    client[0].destroy_subscription(heard)
    assert got[-1].velocity[0] > 5
    # The second within five seconds is not told again.
    assert process.err.count('pump_command is nan: 6 is held') == 1
    assert 'Traceback' not in process.err


@pytest.mark.parametrize('pairs', [[('stamp', 'now')], [('phase', '1')], [('stamp', '')]])
def test_foreign_talk_on_sync_is_told_and_left_out(client, pairs):
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

    tell = client[0].create_publisher(DiagnosticArray, '/drive/sync', 100)
    status = DiagnosticStatus(name='stranger', message='done', values=[
        KeyValue(key=key, value=value) for key, value in pairs])
    with node('plant') as process:
        wait_for(tell.get_subscription_count)
        tell.publish(DiagnosticArray(status=[status]))
        asked, answer = parameters_of(client, 'plant'), client[1]
        assert answer(asked.list_parameters()).result.names
        assert process.poll() is None
    client[0].destroy_publisher(tell)
    assert "what 'stranger' says is not ours" in process.err
    assert 'Traceback' not in process.err
