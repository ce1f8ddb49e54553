# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Every row of the table of faults in docs/integration.md, on the controller's own process."""
import math
import os
import time

import pytest

from .machine import surroundings
from .processes import node, PATIENCE, start, wait_for

STOP_TIME, EMERGENCY = 0.8, 0.4
# A busy machine must not make faults of its own.
TIMES = ('-p', f'stop_time:={STOP_TIME}', '-p', f'emergency_stop_time:={EMERGENCY}',
         '-p', 'feedback_timeout:=1.0', '-p', 'setpoint_timeout:=1.0')


@pytest.fixture(scope='module')
def machine():
    """Return a machine around a controller that runs."""
    with node('controller', *TIMES), surroundings() as made:
        wait_for(made.motor.get_subscription_count)
        yield made


def goes_to_zero(machine, kind, stop_time=STOP_TIME, **what):
    """Check that a fault is told, that the ramp is straight, and that it stays at zero."""
    machine.until(lambda: machine.told.get('fault') == kind, **what)
    machine.until(lambda: machine.told.get('at_zero') == 'true', **what)
    assert machine.told['level'] == b'\2' and kind in machine.told['message']
    assert '~/reset' in machine.told['message']
    zero = next(i for i, (_, value) in enumerate(machine.commands)
                if not any(later for _, later in machine.commands[i:]))
    ramp = machine.commands[:zero][-8:]
    # The ramp goes by the clock, so a busy machine makes its steps uneven, not its slope.
    slope = (ramp[0][1] - ramp[-1][1]) / (ramp[-1][0] - ramp[0][0])
    assert slope == pytest.approx(10.0 / stop_time, rel=0.25)
    for _ in range(30):
        machine.tick()
    assert machine.commands[-1][1] == 0.0, 'a fault whose cause is gone is no reason to go on'


@pytest.mark.parametrize('kind, what', [
    ('feedback_lost', {'reading': None}),
    ('feedback_not_finite', {'reading': math.nan}),
    ('feedback_not_finite', {'reading': math.inf}),
    ('feedback_not_finite', {'bare': True}),
    ('feedback_out_of_range', {'reading': 95.5}),
    ('feedback_time', {'moved': -5.0}),
    ('feedback_time', {'moved': 5.0}),
    ('feedback_frozen', {'steady': True}),
    ('setpoint_lost', {'wish': None}),
    ('setpoint_invalid', {'wish': math.nan}),
    ('setpoint_invalid', {'wish': 1e6}),
    ('setpoint_invalid', {'wish': -5.0}),
])
def test_a_fault_brings_the_command_to_zero(machine, kind, what):
    machine.run_up()
    goes_to_zero(machine, kind, **what)
    assert machine.reset().success


def test_a_reading_that_jumps_to_and_fro(machine):
    machine.run_up()
    while machine.told.get('fault') != 'feedback_jumps':
        machine.tick(reading=-29.0 if machine.count % 2 else 29.0)
    goes_to_zero(machine, 'feedback_jumps')
    machine.until(lambda: machine.reset().success)


def test_a_machine_that_does_not_follow_is_stopped_and_one_that_does_is_not():
    with surroundings('fifth') as machine, node(
            'controller', '-r', '__ns:=/fifth', *TIMES, '-p', 'following_error_timeout:=2.0'):
        # A motor with 2 rad/s per volt comes to its set point, and runs on.
        machine.until(lambda: machine.commands)
        machine.until(lambda: machine.commands[-1][1] > 4.9 or machine.told.get('fault'),
                      reading=lambda: 2.0 * machine.commands[-1][1], wish=10.0)
        end = time.monotonic() + 4.0
        machine.until(lambda: time.monotonic() > end,
                      reading=lambda: 2.0 * machine.commands[-1][1], wish=10.0)
        assert machine.told['state'] == 'running'
        machine.run_up()
        # It never turns; or the sensor sits on another shaft, which does.
        for reading in (0.0, 4.0):
            goes_to_zero(machine, 'following_error', reading=reading, wish=12.0)
            assert '12 rad/s is set' in machine.told['found']
            machine.until(lambda: machine.reset().success)
            machine.run_up()


@pytest.mark.parametrize('way', ['stop', 'hasty_stop'])
def test_the_topic_stops_whatever_its_durability_and_needs_a_release_and_a_reset(machine, way):
    from std_msgs.msg import Bool
    machine.run_up()
    button = getattr(machine, way)
    button.publish(Bool(data=True))
    goes_to_zero(machine, 'emergency_stop', EMERGENCY)
    refused = machine.reset()
    assert not refused.success and 'pressed (topic)' in refused.message
    button.publish(Bool(data=False))
    machine.until(lambda: machine.told.get('against_reset') == '')
    assert machine.commands[-1][1] == 0.0
    assert machine.reset().success


def test_the_service_stops(machine):
    from std_srvs.srv import SetBool
    machine.run_up()
    assert machine.call(machine.stopper, SetBool.Request(data=True)).success
    goes_to_zero(machine, 'emergency_stop', EMERGENCY)
    assert not machine.reset().success
    assert machine.call(machine.stopper, SetBool.Request(data=False)).success
    assert machine.reset().success
    count = len(machine.commands)
    assert machine.start().success
    machine.until(lambda: machine.told.get('state') == 'running')
    machine.run_up()
    # It goes on from zero by the integral: no step of kp * e, no rest of the old integral.
    first = [value for _, value in machine.commands[count:] if value > 0.0]
    assert first[0] < 0.1 and max(b - a for a, b in zip(first, first[1:])) < 0.2


def test_a_reset_is_refused_while_the_cause_is_there(machine):
    machine.run_up()
    goes_to_zero(machine, 'feedback_lost', reading=None)
    machine.told = {'against_reset': ''}
    machine.until(lambda: 'no usable' in machine.told['against_reset'], reading=None)
    refused = machine.reset(reading=None)
    assert not refused.success and 'no usable speed reading' in refused.message
    machine.until(lambda: machine.told.get('against_reset') == '')
    assert machine.reset().success


def test_a_reset_starts_nothing_and_each_step_is_in_the_log():
    """Stop, release, reset, start by the set point, by the service, and the end: who and what."""
    from std_msgs.msg import Bool
    with surroundings('sixth') as machine, node(
            'controller', '-r', '__ns:=/sixth', *TIMES, '-p', 'feedback_timeout:=20.0',
            '-p', 'setpoint_timeout:=20.0') as process:
        machine.run_up()
        for way in ('setpoint', 'service'):
            machine.stop.publish(Bool(data=True))
            machine.until(lambda: machine.told.get('at_zero') == 'true')
            machine.stop.publish(Bool(data=False))
            machine.until(lambda: machine.told.get('against_reset') == '')
            assert 'emergency_stop' in machine.start().message
            assert machine.reset().success
            machine.told = {}
            machine.until(lambda: machine.told.get('state') == 'ready')
            assert machine.told['level'] == b'\1' and '~/start' in machine.told['message']
            assert 'reset by service (/sixth/machine): done' == machine.told['last_event']
            count = len(machine.commands)
            machine.until(lambda: len(machine.commands) > count + 50)
            # The amplifier's watchdog is fed, with zeros, while a set point stands.
            assert not any(value for _, value in machine.commands[count:])
            if way == 'setpoint':
                machine.tick(wish=0.0)
            else:
                assert machine.start().success
            machine.until(lambda: machine.commands[-1][1] > 1.0 or machine.told.get('fault'))
            assert not machine.told.get('fault'), machine.told
            first = next(value for _, value in machine.commands[count:] if value)
            assert first < 0.5, 'kp * 19 rad/s is 0.38 V; the old integral was 5 V'
    said = [line.partition(': ')[2] for line in process.err.splitlines() if '[INFO]' in line]
    by_topic, by_service = '(/sixth/machine)', 'by service (/sixth/machine): '
    stop = [f'emergency stop pressed by topic {by_topic}',
            f'emergency stop released by topic {by_topic}',
            f'start {by_service}refused: stopped: emergency_stop: emergency stop (by topic)',
            f'reset {by_service}done']
    start = f'the drive starts; speed_setpoint is %s {by_topic}'
    # The first set point may come before discovery has told whose it is.
    said[0] = said[0].replace('a node unknown by now', '/sixth/machine')
    assert said[:-1] == [start % 19, *stop, start % 0, *stop, f'start {by_service}done',
                         start % 19]
    assert said[-1].startswith('the drive ends; it was running, at ')


def test_a_controller_that_ends_leaves_the_pump_at_zero_and_a_latched_stop_is_heard():
    from std_msgs.msg import Bool
    apart = '-r', '__ns:=/other'
    with surroundings('other') as machine:
        with node('controller', *apart, *TIMES, '-p', 'mode:=open_loop'):
            machine.run_up(wish=None, manual=6.0)
            machine.until(lambda: machine.commands[-1][1] == 6.0, wish=None, manual=6.0)
            for fault, wrong in (('command_invalid', 11.0), ('setpoint_lost', None)):
                goes_to_zero(machine, fault, wish=None, manual=wrong)
                machine.until(lambda: machine.told.get('against_reset') == '', manual=6.0)
                assert machine.reset(manual=6.0).success
                machine.until(lambda: machine.told.get('state') == 'ready', wish=None, manual=6.0)
                machine.tick(wish=None, manual=0.0)
                machine.until(lambda: machine.commands[-1][1] == 6.0, wish=None, manual=6.0)
        machine.until(lambda: machine.commands[-1][1] == 0.0, wish=None, manual=6.0)
        machine.until(lambda: machine.told['state'] == 'stopped', wish=None, manual=6.0)
        assert machine.told['level'] == b'\1' and machine.told['fault'] == 'shutdown'
        machine.stop.publish(Bool(data=True))
        with node('controller', *apart):
            machine.told = {}
            # It may have commanded while discovery was under way: that goes down the ramp.
            machine.until(lambda: machine.told.get('fault') == 'emergency_stop'
                          and machine.commands[-1][1] == 0.0)


def test_it_says_what_it_waits_for_and_who_else_commands():
    from geometry_msgs.msg import Vector3Stamped
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    with surroundings('third') as machine:
        # Readings that come seldom are told as well: these come often enough for 0.1 s.
        with node('controller', '-r', '__ns:=/third', *TIMES, '-p', 'sample_time:=0.1'):
            machine.until(lambda: '/third/speed_setpoint (it has a publisher, but no' in
                          machine.told.get('message', ''), wish=None)
            machine.until(lambda: machine.told['message'] == 'running')
            second = machine.node.create_publisher(Vector3Stamped, 'pump_command', 10)
            machine.until(lambda: '2 nodes publish /third/pump_command' in machine.told['message'])
            assert machine.told['level'] == b'\1'
            machine.node.destroy_publisher(second)
            machine.until(lambda: machine.told['message'] == 'running')
        machine.node.destroy_publisher(machine.setpoint)
        machine.setpoint = machine.node.create_publisher(
            Vector3Stamped, 'speed_setpoint',
            QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT))
        with node('controller', '-r', '__ns:=/third', *TIMES):
            machine.until(lambda: '/third/speed_setpoint (its publisher does not fit' in
                          machine.told['message'])


def test_deactivate_and_sigterm_end_at_zero_and_a_stop_outlives_them():
    from lifecycle_msgs.msg import Transition
    from lifecycle_msgs.srv import ChangeState, GetState
    from std_srvs.srv import SetBool
    with surroundings('fourth') as machine:
        with node('controller', '-r', '__ns:=/fourth', *TIMES, managed=True) as process:
            change = machine.node.create_client(ChangeState, 'controller/change_state')

            ask = machine.node.create_client(GetState, 'controller/get_state')

            def go(which, state):
                machine.call(change, ChangeState.Request(transition=Transition(id=which)))
                assert machine.call(ask, GetState.Request()).current_state.label == state

            go(Transition.TRANSITION_CONFIGURE, 'inactive')
            go(Transition.TRANSITION_ACTIVATE, 'active')
            machine.run_up()
            go(Transition.TRANSITION_DEACTIVATE, 'inactive')
            machine.until(lambda: machine.commands[-1][1] == 0.0)
            go(Transition.TRANSITION_ACTIVATE, 'active')
            machine.run_up()
            assert machine.call(machine.stopper, SetBool.Request(data=True)).success
            machine.until(lambda: machine.commands[-1][1] == 0.0)
            go(Transition.TRANSITION_DEACTIVATE, 'inactive')
            machine.commands, machine.told = [], {}
            go(Transition.TRANSITION_ACTIVATE, 'active')
            machine.until(lambda: machine.told.get('fault') == 'emergency_stop')
            for _ in range(50):
                machine.tick()
            assert not any(command for _, command in machine.commands)
            assert not machine.reset().success
            assert machine.call(machine.stopper, SetBool.Request(data=False)).success
            machine.until(lambda: machine.told.get('against_reset') == '')
            assert machine.reset().success
            machine.run_up()
            process.terminate()
            machine.until(lambda: machine.told.get('fault') == 'shutdown'
                          and machine.commands[-1][1] == 0.0)
            process.wait(PATIENCE)


def test_an_emergency_stop_in_lockstep_is_in_the_bag_and_the_run_goes_on(tmp_path, monkeypatch):
    from rosbags.highlevel import AnyReader
    from std_msgs.msg import Bool

    # Another controller, that of the other tests, still listens in this domain.
    domain = 1 + int(os.environ['ROS_DOMAIN_ID']) % 101
    monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
    with surroundings(domain=domain) as machine:
        process = start('run', 'paper_step', '-o', str(tmp_path / 'bag'), '--duration', '12')
        wait_for(lambda: machine.tick(None, None) or machine.commands or process.poll())
        wait_for(lambda: machine.tick(None, None) or machine.commands[-1][1] > 2.0)
        machine.stop.publish(Bool(data=True))
        _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    with AnyReader([tmp_path / 'bag']) as bag:
        found = [(connection.topic, bag.deserialize(data, connection.msgtype))
                 for connection, _, data in bag.messages()]
    commands = [message.vector.x for topic, message in found if topic == '/drive/pump_command']
    assert len(commands) == 1200 and commands[-1] == 0.0
    last = max(place for place, value in enumerate(commands) if value > 0.0)
    ramp = commands[last - 4:last + 1]
    # Simulated time: 10 V in 0.3 s, exactly.
    assert [a - b for a, b in zip(ramp, ramp[1:])] == pytest.approx([10.0 * 0.01 / 0.3] * 4)
    told = [status.message for topic, message in found if topic == '/diagnostics'
            for status in message.status if status.name == '/drive/controller: safety']
    assert any(text.startswith('stopped: emergency_stop') for text in told), told
