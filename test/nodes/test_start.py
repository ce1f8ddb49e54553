# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How nodes start: each run in a domain of its own, one line where ROS 2 cannot start."""
from contextlib import ExitStack
import os
import subprocess
import sys
import tempfile
import time

from hst_drive.errors import InputError
from hst_drive.nodes.session import environment as environment_of_run, free_domain
import pytest

from .machine import surroundings
from .processes import environment, node, PATIENCE

pytest.importorskip('rclpy')
CALLS = """
import os, signal, sys, threading
from rclpy.experimental.events_executor import EventsExecutor
from hst_drive.nodes import base, estimator

class Counting:
    def __init__(self):
        self.of, self.calls = EventsExecutor(), 0

    def __getattr__(self, name):
        return getattr(self.of, name)

    def spin_until_future_complete(self, *args, **options):
        self.calls += 1
        self.of.spin_until_future_complete(*args, **options)

counting = []
base._executor = lambda: counting.append(Counting()) or counting[0]
threading.Timer(3.0, os.kill, (os.getpid(), signal.SIGINT)).start()
code = estimator.main()
print(code, counting[0].calls)
"""


@pytest.fixture
def taken(tmp_path, monkeypatch):
    """Return a function that takes all domains that are free; with locks of this test alone."""
    monkeypatch.setattr(tempfile, 'tempdir', str(tmp_path))

    def take():
        found = []
        with ExitStack() as locks, pytest.raises(InputError, match='100 runs are going on'):
            while True:
                found.append(free_domain(locks))
        return found

    return take


def test_each_run_has_a_domain_of_its_own(taken, monkeypatch):
    monkeypatch.delenv('ROS_DOMAIN_ID')
    with ExitStack() as locks:
        mine = int(environment_of_run(locks)['ROS_DOMAIN_ID'])
        assert sorted([mine, *taken()]) == list(range(1, 101))
    assert sorted(taken()) == list(range(1, 101))


def test_a_domain_that_users_chose_is_theirs_together(taken, monkeypatch):
    monkeypatch.setenv('ROS_DOMAIN_ID', '17')
    with ExitStack() as one:
        notes = []
        with ExitStack() as other:
            for locks in (one, other):
                assert environment_of_run(locks, notes.append)['ROS_DOMAIN_ID'] == '17'
        assert len(notes) == 1 and 'another run is in ROS_DOMAIN_ID 17' in notes[0]
        assert sorted([17, *taken()]) == list(range(1, 101))


def test_who_comes_later_is_told_also_when_the_first_has_gone(taken, monkeypatch):
    monkeypatch.setenv('ROS_DOMAIN_ID', '17')
    notes = []
    with ExitStack() as second, ExitStack() as third:
        with ExitStack() as first:
            for locks in (first, second):
                environment_of_run(locks)
        environment_of_run(third, notes.append)
    assert len(notes) == 1


def test_a_user_may_choose_the_domain_of_a_run_and_keeps_it(taken, monkeypatch):
    with ExitStack() as chosen:
        with ExitStack() as own:
            mine = free_domain(own)
            monkeypatch.setenv('ROS_DOMAIN_ID', str(mine))
            environment_of_run(chosen)
        assert mine not in taken()


def test_a_number_that_is_no_domain_is_refused_and_none_is_none(taken, monkeypatch):
    with ExitStack() as locks:
        monkeypatch.setenv('ROS_DOMAIN_ID', '500')
        with pytest.raises(InputError, match="ROS_DOMAIN_ID is '500', expected 0 to 232"):
            environment_of_run(locks)
        monkeypatch.setenv('ROS_DOMAIN_ID', '')
        assert 1 <= int(environment_of_run(locks)['ROS_DOMAIN_ID']) <= 100


def test_the_domain_of_these_tests_is_held():
    with ExitStack() as locks:
        assert free_domain(locks) != int(os.environ['ROS_DOMAIN_ID'])


@pytest.mark.parametrize('variables, arguments, words', [
    ({'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_STRATEGY': 'Enforce'}, [],
     ('ROS_SECURITY_KEYSTORE', 'security libraries', 'docs/integration.md')),
    ({'ROS_DOMAIN_ID': 'one'}, [], ('not an integral number', 'ROS_DOMAIN_ID (0 to 101)')),
    ({}, ['--ros-args', '-p', 'a'], ("parse parameter override rule: '-p a'", '--ros-args'))])
def test_where_ros_cannot_start_a_node_says_so_in_one_line(variables, arguments, words):
    done = subprocess.run(
        [sys.executable, '-m', 'hst_drive.nodes.estimator', *arguments], timeout=PATIENCE,
        env={**environment(), **variables}, capture_output=True, text=True)
    # What begins with a bracket is rcl's own log.
    lines = [line for line in done.stderr.splitlines() if not line.startswith('[')]
    assert done.returncode == 1 and len(lines) == 1, done.stderr
    assert lines[0].startswith('estimator: ') and all(word in lines[0] for word in words)


def test_nodes_start_without_scipy():
    """It takes as long to import as all the rest, and most of them never need it."""
    code = ('import sys\nfrom hst_drive.nodes import controller, estimator, load_profile\n'
            'from hst_drive.nodes import manager, plant, recorder\nprint("scipy" in sys.modules)')
    done = subprocess.run([sys.executable, '-c', code], env=environment(), timeout=PATIENCE,
                          capture_output=True, text=True)
    assert done.stdout == 'False\n', done.stderr


def test_a_node_asks_its_executor_seldom():
    """For rclpy loses 32 bytes each time."""
    done = subprocess.run([sys.executable, '-c', CALLS], env=environment(), timeout=PATIENCE,
                          capture_output=True, text=True)
    code, calls = map(int, done.stdout.split())
    assert code == 0 and 1 <= calls <= 3, done.stderr


@pytest.mark.parametrize('arguments, words', [
    (['--managd'], ("'--managd'", '--managed', '--ros-args')),
    (['--ros-args', '-p', 'kp:=1'], ('parameter kp is 1 (INTEGER), expected DOUBLE',)),
    (['--ros-args', '-p', 'mode:=nothing'],
     ("controller: parameter mode: 'nothing' is none of its values", 'open_loop')),
    (['--ros-args', '-p', 'partners:=[plnt]'], ("partners: 'plnt'", "did you mean 'plant'?")),
    (['--ros-args', '-p', 'qos_overrides./drive/motor.subscription.reliability:=besteffort'],
     ('qos_overrides./drive/motor', 'besteffort'))])
def test_wrong_arguments_are_one_line(arguments, words):
    done = subprocess.run(
        [sys.executable, '-m', 'hst_drive.nodes.controller', *arguments], timeout=PATIENCE,
        env=environment(), capture_output=True, text=True)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert all(word in done.stderr for word in words), done.stderr
    assert done.stderr.count('controller: ') == 1


def test_a_topic_that_the_circuit_has_not_is_told():
    done = subprocess.run(
        [sys.executable, '-m', 'hst_drive.nodes.estimator', '--ros-args', '-p',
         'extra_topics:=[charge_pressure]'], timeout=PATIENCE, env=environment(),
        capture_output=True, text=True)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert "topic 'charge_pressure' is none of the plant's" in done.stderr


def test_a_parameter_that_a_node_does_not_have_is_told():
    with node('controller', '-p', 'stop_tme:=2.0', '-p',
              'qos_overrides./drive/motor.subscription.depth:=5', '-p',
              'qos_overrides./drive/motorr.subscription.depth:=5') as process:
        time.sleep(2.0)
    assert "'stop_tme' is none of this node's" in process.err
    assert "did you mean 'stop_time'" in process.err
    assert "'qos_overrides./drive/motorr.subscription.depth' is none" in process.err
    assert "'qos_overrides./drive/motor.subscription.depth' is none" not in process.err


def test_who_looks_on_is_no_partner(monkeypatch):
    """Their readers of a topic are as many as those of the partners, of whom none has come."""
    domain = str(1 + int(os.environ['ROS_DOMAIN_ID']) % 101)
    monkeypatch.setenv('ROS_DOMAIN_ID', domain)
    with ExitStack() as stack:
        for _ in range(3):
            stack.enter_context(surroundings(domain=int(domain)))
        alone = stack.enter_context(node(
            'controller', '-p', 'lockstep:=true', '-p',
            'partners:=[plant, load_profile, controller, estimator, recorder]'))
        line = next(line for line in alone.stderr if 'still waiting' in line)
    assert 'motor' in line and 'pump_command' in line


@pytest.mark.parametrize('arguments, code, words', [
    (['--help'], 0, '--ros-args -p NAME:=VALUE'),
    (['now'], 2, "manager: unknown argument 'now'"),
    (['--ros-args', '-p', 'patience:=3'], 2, 'manager: parameter patience is 3 (INTEGER)'),
    (['--ros-args', '-p', 'a'], 1, 'manager: RCLError: ')])
def test_the_manager_says_what_is_wrong_in_one_line(arguments, code, words):
    done = subprocess.run([sys.executable, '-m', 'hst_drive.nodes.manager', *arguments],
                          timeout=PATIENCE, env=environment(), capture_output=True, text=True)
    assert done.returncode == code and words in done.stdout + done.stderr, done.stderr
    # What begins with a bracket is rcl's own log.
    lines = [line for line in done.stderr.splitlines() if not line.startswith('[')]
    assert len(lines) == (code > 0), done.stderr
