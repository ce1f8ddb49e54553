# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A clock that is set while the drive runs in real time."""
import platform
import shutil
import subprocess

from hst_drive.nodes.controller import Controller
from hst_drive.nodes.load_profile import LoadProfile
from hst_drive.nodes.plant import Plant
import numpy as np
import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor

from .machine import surroundings
from .processes import node as running, wait_for

HOUR = 3600 * 10**9
# What a step back of the clock on the wall does to a thread that waits for a time on it: once the
# file SET_BACK is there, the next wait of each thread lasts an hour longer, if nobody wakes it.
WALL = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

typedef int (*wait_type)(pthread_cond_t *, pthread_mutex_t *, const struct timespec *);

int pthread_cond_timedwait(
  pthread_cond_t * condition, pthread_mutex_t * mutex, const struct timespec * until)
{
  static __thread int done;
  wait_type wait = (wait_type)dlvsym(RTLD_NEXT, "pthread_cond_timedwait", "GLIBC_2.3.2");
  struct timespec later = *until;
  if (!done && access(getenv("SET_BACK"), F_OK) == 0) {
    done = 1;
    later.tv_sec += 3600;
  }
  return wait(condition, mutex, &later);
}
"""


@pytest.mark.parametrize('jump', [HOUR, -HOUR])
def test_the_drive_goes_on_through_it(jump):
    rclpy.init(args=['--ros-args', '-p', 'setpoint_timeout:=20.0', '-p', 'feedback_timeout:=20.0',
                     '-p', 'bad_readings:=100'])
    nodes = [kind() for kind in (Controller, LoadProfile, Plant)]
    controller, _, plant = nodes
    executor, moved, stamps, true_now = SingleThreadedExecutor(), [0], [], {}
    # Readings that are under way when the clock is set are passed over: on a busy machine many.
    try:
        for node in nodes:
            true_now[node] = node.now
            node.now = lambda node=node: true_now[node]() + moved[0]
            node.configure()
            node.activate()
            executor.add_node(node)
        plant.outputs['motor'].publish = spied(plant.outputs['motor'].publish, stamps)
        for count in (100, 200):
            while len(stamps) < count:
                executor.spin_once(timeout_sec=1.0)
            moved[0] = jump
        steps = np.diff(stamps)
        assert np.count_nonzero(np.abs(steps) > HOUR / 2) == 1
        assert set(steps[np.abs(steps) < HOUR / 2]) == {10**7}
        assert controller._watch.fault is None
        assert controller._watch.passed_over < 100 and controller._command > 0.0
    finally:
        for node in nodes:
            node.destroy_node()
        rclpy.shutdown()


def spied(publish, stamps):
    """Return the function, which notes the stamps as well."""
    def both(stamp, *values):
        stamps.append(stamp)
        publish(stamp, *values)

    return both


@pytest.mark.skipif(shutil.which('cc') is None or platform.machine() != 'x86_64',
                    reason='needs a C compiler, and the symbols of x86_64')
def test_a_reading_that_is_lost_then_is_noticed_at_once(tmp_path, monkeypatch):
    """A middleware built for an old C library waits by the clock on the wall."""
    (tmp_path / 'wall.c').write_text(WALL)
    subprocess.run(['cc', '-shared', '-fPIC', '-o', 'wall.so', 'wall.c', '-ldl'], cwd=tmp_path,
                   check=True)
    set_back = tmp_path / 'set_back'
    monkeypatch.setenv('SET_BACK', str(set_back))
    monkeypatch.setenv('LD_PRELOAD', str(tmp_path / 'wall.so'))
    with running('controller'):
        monkeypatch.delenv('LD_PRELOAD')
        with surroundings() as machine:
            wait_for(machine.motor.get_subscription_count)
            machine.run_up()
            set_back.touch()
            machine.until(lambda: machine.told.get('fault') == 'feedback_lost', reading=None)
            machine.until(lambda: machine.told.get('at_zero') == 'true', reading=None)
