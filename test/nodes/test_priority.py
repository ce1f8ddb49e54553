# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Real-time priority: every thread has it, also those that come later; who may not is told."""
import os
import subprocess
import sys

from hst_drive.errors import InputError
from hst_drive.nodes.plan import make_plan, Options
import pytest

from .processes import environment, wait_for

# In a process of its own: priority and rights cannot be taken back.
CODE = """
import os, threading
from hst_drive.errors import InputError
from hst_drive.nodes.priority import go_before_others
early = threading.Event()
threading.Thread(target=early.wait, daemon=True).start()
{before}
try:
    go_before_others(7)
    threading.Thread(target=early.wait, daemon=True).start()
    tasks = [int(name) for name in os.listdir('/proc/self/task')]
    print(len(tasks) >= 3, {{(os.sched_getscheduler(task) == os.SCHED_RR,
                             os.sched_getparam(task).sched_priority) for task in tasks}})
except InputError as error:
    print(error)
os._exit(0)
"""


def said(before):
    """Return what the code prints."""
    return subprocess.run([sys.executable, '-c', CODE.format(before=before)], check=True,
                          capture_output=True, text=True).stdout.strip()


@pytest.mark.skipif(os.geteuid() != 0, reason='only root may for sure')
def test_every_thread_has_it():
    assert said('pass') == 'True {(True, 7)}'


@pytest.mark.skipif(os.geteuid() != 0, reason='only root may for sure')
@pytest.mark.parametrize('name', ['estimator', 'manager'])
def test_a_node_has_the_priority_of_its_parameter(name):
    pytest.importorskip('rclpy')
    process = subprocess.Popen(
        [sys.executable, '-m', f'hst_drive.nodes.{name}', '--ros-args', '-p', 'priority:=7',
         *(['-p', 'nodes:=[estimator]'] * (name == 'manager'))], env=environment())
    try:
        wait_for(lambda: (os.sched_getscheduler(process.pid), os.sched_getparam(
            process.pid).sched_priority) == (os.SCHED_RR, 7))
    finally:
        process.kill()
        process.wait()


def test_who_may_not_is_told_what_to_do():
    told = said('import resource\nresource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))\n'
                'os.geteuid() or os.setuid(65534)')
    assert told.startswith('parameter priority 7: Operation not permitted; it needs')
    assert 'rtprio' in told and '\n' not in told


def test_the_plant_goes_before_the_controller_and_that_before_the_rest(tmp_path):
    def levels(**more):
        plan = make_plan(Options('paper_step', str(tmp_path / 'bag'), realtime=True, **more))
        return {name: entry.get('priority', 0) for name, entry in plan.parameters.items()}

    assert levels(priority=20) == {'plant': 20, 'controller': 19, 'load_profile': 18,
                                   'estimator': 18, 'recorder': 18}
    assert set(levels().values()) == {0}
    for wrong in (-1, 2, 100):
        with pytest.raises(InputError, match=f'--priority {wrong}: expected 3 to 99'):
            levels(priority=wrong)


def test_simulated_time_needs_no_priority(tmp_path):
    with pytest.raises(InputError, match='add --realtime'):
        make_plan(Options('paper_step', str(tmp_path / 'bag'), priority=20))
