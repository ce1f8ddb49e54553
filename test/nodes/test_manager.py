# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A node that is killed is told and, restarted, brought up again: real processes, kill -9."""
from contextlib import ExitStack
import shutil
import subprocess
import sys

from hst_drive.resources import share
import pytest

from .machine import surroundings
from .processes import environment, node, PATIENCE

pytest.importorskip('rclpy')
SPACE = ('--ros-args', '-r', '__ns:=/kept')
TIMES = ('-p', 'feedback_timeout:=2.0', '-p', 'setpoint_timeout:=2.0')


def launched(name, *parameters):
    """Start a managed node as launch does, and again when it was killed."""
    return subprocess.Popen([sys.executable, '-m', f'hst_drive.nodes.{name}', '--managed', *SPACE,
                             *(TIMES if name == 'controller' else ()), *parameters],
                            env=environment(), stderr=subprocess.DEVNULL)


def heard(machine):
    """Return what the manager says of the nodes, which is kept up to date."""
    from diagnostic_msgs.msg import DiagnosticArray
    told = {'message': ''}

    def hear(message):
        for status in message.status:
            if status.name == '/kept/manager: nodes':
                told.update(level=status.level[0], message=status.message,
                            hardware=status.hardware_id,
                            **{entry.key: entry.value for entry in status.values})

    machine.node.create_subscription(DiagnosticArray, '/diagnostics', hear, 100)
    return told


def test_a_killed_controller_is_told_and_comes_back_at_zero_until_it_is_started():
    from std_srvs.srv import Trigger
    with surroundings('kept') as machine, ExitStack() as stack:
        told = heard(machine)
        is_active = machine.node.create_client(Trigger, 'manager/is_active')
        running = {name: launched(name) for name in ('controller', 'estimator')}
        stack.callback(lambda: [(process.kill(), process.wait()) for process in running.values()])
        with node('manager', '-r', '__ns:=/kept', '-p', 'nodes:=[controller, estimator]', '-p',
                  'bring_back:=true', '-p', 'hardware_id:=rig 7') as manager:
            machine.until(lambda: told.get('message') == 'all nodes are active')
            assert told['level'] == 0 and told['hardware'] == 'rig 7'
            assert machine.call(is_active, Trigger.Request()).success
            # The first time it starts as ever.
            machine.run_up()
            running['controller'].kill()
            running['controller'].wait()
            machine.until(lambda: told['level'] == 2)
            assert told['message'] == 'controller is silent'
            assert (told['controller'], told['estimator']) == ('silent', 'active')
            said = machine.call(is_active, Trigger.Request())
            assert not said.success and said.message == 'controller is silent'
            machine.commands.clear()
            machine.told = {}
            running['controller'] = launched('controller')
            machine.until(lambda: told['level'] == 0 and machine.told.get('state') == 'ready')
            assert told['brought_back'] == '1'
            count = len(machine.commands)
            machine.until(lambda: len(machine.commands) > count + 30)
            # A set point stands all the time.
            assert not any(command for _, command in machine.commands)
            assert machine.start().success
            machine.until(lambda: machine.commands[-1][1] > 1.0)
    assert 'controller: is silent; start it again' in manager.err
    assert manager.err.count('is brought up again') == 1


def test_a_bring_up_that_is_refused_is_tried_again(tmp_path):
    """Its rig file comes late, at the start and after a kill."""
    rig, away = tmp_path / 'rig.yaml', tmp_path / 'away.yaml'
    shutil.copy(share('config', 'rig', 'test_rig.yaml'), away)
    with surroundings('kept') as machine, ExitStack() as stack:
        told, running = heard(machine), []
        stack.callback(lambda: [(process.kill(), process.wait()) for process in running])
        running.append(launched('estimator', '-p', f'rig:={rig}'))
        with node('manager', '-r', '__ns:=/kept', '-p', 'nodes:=[estimator]', '-p',
                  'bring_back:=true', '-p', 'attempts:=30', '-p', 'retry_delay:=0.5') as manager:
            machine.until(lambda: told['message'].startswith(
                '(attempt 1 of 30 refused: estimator: does not configure; it is unconfigured'))
            shutil.copy(away, rig)
            machine.until(lambda: told['message'] == 'all nodes are active')
            refused = int(told['refused'])
            assert refused >= 1 and told['brought_back'] == '0'
            running[-1].kill()
            running[-1].wait()
            rig.unlink()
            running.append(launched('estimator', '-p', f'rig:={rig}'))
            machine.until(lambda: told['message'].startswith(
                'estimator is unconfigured (attempt 1 of 30 refused: estimator: does not'))
            assert told['level'] == 1
            shutil.copy(away, rig)
            machine.until(lambda: told['message'] == 'all nodes are active')
            assert told['brought_back'] == '1' and int(told['refused']) > refused
    assert 'bring-up: (attempt 1 of 30 refused: ' in manager.err
    assert 'estimator: (attempt 1 of 30 refused: ' in manager.err


def test_it_gives_up_after_so_many_attempts(tmp_path):
    with ExitStack() as stack:
        process = launched('estimator', '-p', f'rig:={tmp_path / "none.yaml"}')
        stack.callback(lambda: (process.kill(), process.wait()))
        done = subprocess.run(
            [sys.executable, '-m', 'hst_drive.nodes.manager', *SPACE, '-p', 'nodes:=[estimator]',
             '-p', 'bring_back:=true', '-p', 'attempts:=2', '-p', 'retry_delay:=0.1'],
            env=environment(), capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 1
    assert 'bring-up: (attempt 1 of 2 refused: ' in done.stderr
    assert done.stderr.splitlines()[-1] == (
        'manager: (given up: attempt 2 of 2 refused: estimator: does not configure; it is '
        'unconfigured, its log says why)')
