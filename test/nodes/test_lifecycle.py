# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Managed nodes, their manager, and two drives on one machine: processes over real DDS."""
from contextlib import ExitStack
from functools import partial
import signal
import subprocess
import sys

import pytest

from .processes import environment, messages, node, PATIENCE, wait_for
from .test_nodes import client, parameters_of, until_answered  # noqa: F401 (a fixture)

rclpy = pytest.importorskip('rclpy')
managed = partial(node, managed=True)


class Asker:
    """Asks a managed node for transitions and states."""

    def __init__(self, client, name):  # noqa: F811
        from lifecycle_msgs.srv import ChangeState, GetState
        self.asker, self.answer, self.executor = client
        self.change = self.asker.create_client(ChangeState, f'/drive/{name}/change_state')
        self.get = self.asker.create_client(GetState, f'/drive/{name}/get_state')
        for entry in (self.change, self.get):
            assert entry.wait_for_service(timeout_sec=PATIENCE)
        until_answered(client, lambda: self.get.call_async(GetState.Request()))

    def __call__(self, number):
        from lifecycle_msgs.srv import ChangeState
        request = ChangeState.Request()
        request.transition.id = number
        return self.answer(self.change.call_async(request)).success

    @property
    def state(self):
        from lifecycle_msgs.srv import GetState
        return self.answer(self.get.call_async(GetState.Request())).current_state.label


CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE, SHUTDOWN = 1, 2, 3, 4, 7


def test_the_states_of_a_node_and_transitions_that_do_not_fit(client):  # noqa: F811
    from sensor_msgs.msg import JointState
    got = []
    heard = client[0].create_subscription(JointState, '/drive/motor', got.append, 100)

    def silent():
        return client[0].count_publishers('/drive/motor') == 0

    with managed('plant') as process:
        ask = Asker(client, 'plant')
        assert ask.state == 'unconfigured' and silent()
        for wrong in (ACTIVATE, DEACTIVATE, CLEANUP, 99):
            assert not ask(wrong)
        assert ask.state == 'unconfigured'
        for _ in range(2):
            assert ask(CONFIGURE) and ask.state == 'inactive'
            assert not ask(CONFIGURE) and silent()
            for _ in range(2):
                assert ask(ACTIVATE) and ask.state == 'active'
                del got[:]
                while len(got) < 10:
                    client[2].spin_once(timeout_sec=1.0)
                assert ask(DEACTIVATE) and ask.state == 'inactive'
                wait_for(silent)
            assert ask(CLEANUP)
        assert ask(5) and ask.state == 'finalized'
        assert process.poll() is None
    client[0].destroy_subscription(heard)
    assert 'Traceback' not in process.err and 'no such transition' in process.err


def test_a_node_that_cannot_be_configured_says_why_and_stays(client):  # noqa: F811
    with managed('plant', '-p', 'rig:=nowhere.yaml') as process:
        ask = Asker(client, 'plant')
        assert not ask(CONFIGURE) and ask.state == 'unconfigured'
    assert 'nowhere.yaml' in process.err and 'Traceback' not in process.err


def test_parameters_can_be_set_until_the_node_is_configured(client, tmp_path):  # noqa: F811
    from rclpy.parameter import Parameter
    (tmp_path / 'rig.yaml').write_text('motor: nothing\n')
    with managed('plant') as process:
        ask = Asker(client, 'plant')
        asked, answer = parameters_of(client, 'plant'), client[1]

        def put(name, value):
            return answer(asked.set_parameters([Parameter(name, value=value)])).results[0]

        assert not put('rate', 5000.0).successful       # beyond its range
        assert not put('rate', 'fast').successful
        wrong = put('extra_topics', ['nothing'])
        assert not wrong.successful and "'nothing' is none of its values" in wrong.reason
        assert not put('partners', ['plant']).successful       # read at the start
        assert put('rig', str(tmp_path / 'rig.yaml')).successful
        assert not ask(CONFIGURE) and ask.state == 'unconfigured'
        assert put('rig', '').successful and put('extra_topics', ['']).successful
        assert put('rate', 50.0).successful and ask(CONFIGURE)
        late = put('rate', 20.0)
        assert not late.successful and 'it is inactive: clean it up first' in late.reason
        assert answer(asked.get_parameters(['rate'])).values[0].double_value == 50.0
        assert ask(CLEANUP) and put('rate', 20.0).successful
        described = answer(asked.describe_parameters(['rate', 'extra_topics', 'partners']))
        rate, extra, partners = described.descriptors
        assert (rate.read_only, extra.read_only, partners.read_only) == (False, False, True)
        assert 'some of: ' in extra.additional_constraints
        assert 'case_drain_flow' in extra.additional_constraints
    assert 'rig.yaml' in process.err


def test_a_managed_recorder_takes_a_new_name_for_its_next_bag(client, tmp_path):  # noqa: F811
    from rclpy.parameter import Parameter
    with managed('recorder', '-p', f'output:={tmp_path / "one"}'):
        ask = Asker(client, 'recorder')
        asked = parameters_of(client, 'recorder')
        assert all(map(ask, (CONFIGURE, ACTIVATE, DEACTIVATE, CLEANUP)))
        (tmp_path / 'one').mkdir()
        assert not ask(CONFIGURE)       # it is taken
        assert client[1](asked.set_parameters(
            [Parameter('output', value=str(tmp_path / 'two'))])).results[0].successful
        assert ask(CONFIGURE) and (tmp_path / 'two').is_dir()


def test_a_manager_brings_the_nodes_up_in_order_and_down_again(client, tmp_path):  # noqa: F811
    names = ['recorder', 'estimator', 'load_profile', 'controller', 'plant']
    common = ('-p', f"partners:=[{','.join(names)}]")
    with ExitStack() as stack:
        for name in names:
            stack.enter_context(managed(name, *common, *(
                ('-p', f'output:={tmp_path / "bag"}') if name == 'recorder' else ())))
        with node('manager', '-p', f"nodes:=[{','.join(names)}]") as manager:
            wait_for(lambda: 'active' in manager.stdout.readline())
            wait_for(lambda: sum(path.stat().st_size for path in tmp_path.glob('bag/*')) > 20000)
            assert Asker(client, 'controller').state == 'active'
        wait_for((tmp_path / 'bag' / 'metadata.yaml').is_file)
        for name in names:
            assert Asker(client, name).state == 'unconfigured'
    topics = {topic for topic, _, _ in messages(tmp_path / 'bag')}
    assert {'/drive/pump_command', '/drive/motor', '/drive/speed_setpoint'} <= topics


def test_a_manager_tells_of_a_node_that_was_killed_and_of_one_that_is_back(
        client, tmp_path):  # noqa: F811
    """It brings none back unless that is asked for (``test_manager``)."""
    def start(name, *arguments):
        return subprocess.Popen([sys.executable, '-m', f'hst_drive.nodes.{name}', *arguments],
                                env=environment(), stdout=log, stderr=log)

    def said(text):
        return text in (tmp_path / 'log').read_text()

    with open(tmp_path / 'log', 'w') as log, ExitStack() as stack:
        first = start('controller', '--managed')
        manager = start('manager', '--ros-args', '-p', 'nodes:=[controller]')
        stack.callback(manager.kill)
        wait_for(lambda: said('all nodes are active'))
        first.kill()
        first.wait()
        wait_for(lambda: said('controller: is silent; start it again'))
        stack.enter_context(managed('controller'))
        wait_for(lambda: said('controller: is unconfigured'))
        ask = Asker(client, 'controller')
        assert said('or give bring_back:=true') and ask.state == 'unconfigured'
        assert ask(CONFIGURE) and ask(ACTIVATE)
        wait_for(lambda: said('controller: is active again'))
        assert ask.state == 'active'
        manager.send_signal(signal.SIGINT)
        assert manager.wait(timeout=PATIENCE) == 0 and ask.state == 'unconfigured'


def test_what_was_due_when_a_node_closed_is_dropped():
    """The executor may hold a timer of which the node knows no more."""
    from hst_drive.nodes.lifecycle import managed as managed_class
    from hst_drive.nodes.load_profile import LoadProfile
    rclpy.init()
    try:
        late = managed_class(LoadProfile)()
        late.trigger_configure()
        late.trigger_activate()
        late.started()
        due = [timer.callback for timer in late.timers]
        late._count = 0
        due[-1]()
        assert late._count == 1
        late.trigger_deactivate()
        for callback in due:
            callback()
        assert late._count == 1
        late.destroy_node()
    finally:
        rclpy.shutdown()


def test_a_middleware_that_never_closes_does_not_keep_the_process():
    """Seen once: a plant that had done its work stood still for minutes."""
    code = ('import sys, time; from hst_drive.nodes import base, load_profile\n'
            'base._LONGEST_END = 0.5\n'
            'load_profile.LoadProfile.destroy_node = lambda self: time.sleep(600)\n'
            'load_profile.LoadProfile.started = lambda self: self.stop(0)\n'
            'base.main(load_profile.LoadProfile)\n')
    done = subprocess.run([sys.executable, '-c', code], env=environment(), timeout=PATIENCE,
                          capture_output=True, text=True)
    assert done.returncode == 0
    assert 'the middleware did not close within 0.5 s' in done.stderr


def test_the_manager_names_the_node_that_is_not_there():
    done = subprocess.run(
        [sys.executable, '-m', 'hst_drive.nodes.manager', '--ros-args', '-p', 'nodes:=[plant]',
         '-p', 'patience:=0.5'], env=environment(), timeout=PATIENCE, capture_output=True,
        text=True)
    assert done.returncode == 1 and 'plant: no such managed node' in done.stderr
    assert 'Traceback' not in done.stderr


def test_the_manager_refuses_what_it_does_not_know():
    done = subprocess.run(
        [sys.executable, '-m', 'hst_drive.nodes.manager', '--nodes', 'plant'], env=environment(),
        timeout=PATIENCE, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("manager: unknown argument '--nodes'")


@pytest.mark.parametrize('lockstep', ['true', 'false'])
def test_two_drives_in_one_domain_do_not_hear_each_other(tmp_path, lockstep):
    """Lockstep needs the global topics /clock and /diagnostics apart as well."""
    names = ('recorder', 'load_profile', 'controller', 'plant')
    with ExitStack() as stack:
        plants = []
        for rig, seed in (('east', 1), ('west', 2)):
            apart = ('-r', f'__ns:=/{rig}', '-r', f'/clock:=/{rig}/clock',
                     '-r', f'/diagnostics:=/{rig}/diagnostics',
                     '-p', f"partners:=[{','.join(names)}]", '-p', f'lockstep:={lockstep}')
            # Another name of a node, too: what counts is its part.
            own = {'recorder': ('-p', f'output:={tmp_path / rig}', '-r', '__node:=logger'),
                   'plant': ('-p', 'duration:=3.0', '-p', f'seed:={seed}')}
            started = [stack.enter_context(node(name, *apart, *own.get(name, ())))
                       for name in names]
            plants.append(started[-1])
        wait_for(lambda: all(process.poll() is not None for process in plants))
    for rig in ('east', 'west'):
        found = messages(tmp_path / rig)
        assert all(topic.startswith(f'/{rig}/') for topic, _, _ in found)
        stamps = [data[4:12] for topic, _, data in found if topic == f'/{rig}/motor']
        assert len(stamps) == len(set(stamps)) == 300
    assert [data for topic, _, data in messages(tmp_path / 'east') if topic.endswith('motor')] \
        != [data for topic, _, data in messages(tmp_path / 'west') if topic.endswith('motor')]


def test_gains_are_taken_together_or_not_at_all_and_qos_can_be_overridden(client):  # noqa: F811
    from rclpy.parameter import Parameter
    override = 'qos_overrides./drive/pump_command.publisher.depth'
    with node('controller', '-p', f'{override}:=7'):
        asked, answer = parameters_of(client, 'controller'), client[1]

        def put(**values):
            return answer(asked.set_parameters_atomically(
                [Parameter(name, value=value) for name, value in values.items()])).result

        def gains():
            return [value.double_value for value in answer(
                asked.get_parameters(['kp', 'ki'])).values]

        assert put(kp=0.03, ki=0.5).successful and gains() == [0.03, 0.5]
        for bad in ({'kp': 0.04, 'ki': -1.0}, {'kp': 0.04, 'ki': float('nan')},
                    {'kp': 0.04, 'stop_time': 2.0}):
            assert not put(**bad).successful and gains() == [0.03, 0.5]
        assert answer(asked.get_parameters([override])).values[0].integer_value == 7
