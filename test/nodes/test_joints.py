# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Of several joints the named one is read, or none; on the nodes' own processes."""
import pytest

from .machine import surroundings
from .processes import node, wait_for

FEED = (('feed', 0.3),)
TIMES = '-p', 'feedback_timeout:=1.0', '-p', 'setpoint_timeout:=1.0'


def refused(machine, said, **what):
    """Check that the controller stays at 0 V, or goes there, and tells why."""
    machine.until(lambda: machine.told.get('fault') == 'feedback_joint', **what)
    machine.until(lambda: machine.told.get('at_zero') == 'true', **what)
    assert machine.commands[-1][1] == 0.0
    assert machine.told['level'] == b'\2' and said in machine.told['found'], machine.told
    assert 'parameter joint' in machine.told['found']
    answer = machine.reset(**what)
    assert not answer.success and 'which joint' in answer.message


def test_of_several_joints_none_is_read_unless_it_is_named():
    with surroundings() as machine, node('controller', *TIMES) as controller:
        wait_for(machine.motor.get_subscription_count)
        refused(machine, '2 joints (feed, drill)', others=FEED)
        assert not any(command for _, command in machine.commands)
        # One joint alone is ours, whatever its name; another one in turn with it is not.
        machine.until(lambda: machine.reset(name='anything').success, name='anything')
        machine.run_up(name='anything')
        refused(machine, "2 joints in turn ('anything', then 'drill')")
    assert 'feedback_joint' in controller.err and '(feed, drill)' in controller.err


def test_the_named_joint_is_read_wherever_it_stands():
    with surroundings('second') as machine, node(
            'controller', '-r', '__ns:=/second', *TIMES, '-p', 'joint:=drill'):
        wait_for(machine.motor.get_subscription_count)
        # At its set point the command rests; the speed of feed would drive it up.
        machine.until(lambda: machine.told.get('state') == 'running', wish=10.0, others=FEED)
        for _ in range(200):
            machine.tick(wish=10.0, others=FEED)
        assert max(command for _, command in machine.commands) < 0.05
        machine.run_up(others=FEED)
        machine.run_up(others=(('feed', 0.3), ('winch', 1.0)))
        refused(machine, "expected one named 'drill'", name='bit', others=FEED)


def test_the_estimator_tells_which_joints_it_cannot_choose_from():
    from diagnostic_msgs.msg import DiagnosticArray
    with surroundings('third') as machine, node('estimator', '-r', '__ns:=/third'):
        told = []
        machine.node.create_subscription(
            DiagnosticArray, '/diagnostics',
            lambda message: told.extend(status.message for status in message.status), 10)
        machine.until(lambda: any('motor: 2 joints (feed, drill)' in text
                                  and 'parameter joint' in text for text in told), others=FEED)


@pytest.mark.parametrize('options, expected', [
    ((), 'third'), (('-p', 'hardware_id:=rig 7'), 'rig 7')])
def test_diagnostics_name_the_machine(options, expected):
    from diagnostic_msgs.msg import DiagnosticArray
    with surroundings('third') as machine, node('controller', '-r', '__ns:=/third', *options), \
            node('estimator', '-r', '__ns:=/third', *options):
        told = {}
        machine.node.create_subscription(
            DiagnosticArray, '/diagnostics', lambda message: told.update(
                (status.name.split(':')[0], status.hardware_id) for status in message.status), 10)
        machine.until(lambda: len(told) == 2)
        assert told == {f'/third/{name}': expected for name in ('controller', 'estimator')}
