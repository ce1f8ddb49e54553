# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A node that is killed is told and, restarted, brought up again: real processes, kill -9."""
from contextlib import ExitStack
import subprocess
import sys

import pytest

from .machine import surroundings
from .processes import environment, node

pytest.importorskip('rclpy')
SPACE = ('--ros-args', '-r', '__ns:=/kept')
TIMES = ('-p', 'feedback_timeout:=2.0', '-p', 'setpoint_timeout:=2.0')


def launched(name):
    """Start a managed node as launch does, and again when it was killed."""
    return subprocess.Popen([sys.executable, '-m', f'hst_drive.nodes.{name}', '--managed', *SPACE,
                             *(TIMES if name == 'controller' else ())], env=environment(),
                            stderr=subprocess.DEVNULL)


def test_a_killed_controller_is_told_and_comes_back_at_zero_until_it_is_started():
    from diagnostic_msgs.msg import DiagnosticArray
    from std_srvs.srv import Trigger
    with surroundings('kept') as machine, ExitStack() as stack:
        told = {}

        def hear(message):
            for status in message.status:
                if status.name == '/kept/manager: nodes':
                    told.update(level=status.level[0], message=status.message,
                                hardware=status.hardware_id,
                                **{entry.key: entry.value for entry in status.values})

        machine.node.create_subscription(DiagnosticArray, '/diagnostics', hear, 100)
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
