# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Sensors of any rate: the same law, a command every sample time; on the controller's process."""
import time

from hst_drive.bag import read_log
import numpy as np
import pytest

from .machine import surroundings
from .processes import node, run, wait_for

SAMPLE, KP, KI, ERROR = 0.01, 0.02, 0.45, 5.0
# A busy machine must not make faults of its own.
TIMES = '-p', 'feedback_timeout:=2.0', '-p', 'setpoint_timeout:=2.0'


def play(machine, rate, seconds):
    """Send readings at a rate, 5 rad/s below a set point that comes at 50 Hz."""
    now = begin = time.monotonic()
    due, wished = begin, begin
    while now < begin + seconds:
        machine.tick(reading=10.0 if now >= due else None,
                     wish=10.0 + ERROR if now >= wished else None, lasts=0.0)
        due += now >= due and 1.0 / rate
        wished += now >= wished and 0.02
        machine.executor.spin_once(timeout_sec=max(0.0, min(due, wished) - time.monotonic()))
        now = time.monotonic()


@pytest.mark.parametrize('rate', [200, 100, 50, 20])
def test_a_step_of_the_set_point_at_any_rate_of_the_sensor(rate):
    with surroundings(f'at{rate}') as machine, node(
            'controller', '-r', f'__ns:=/at{rate}', *TIMES) as controller:
        wait_for(machine.motor.get_subscription_count)
        wait_for(machine.setpoint.get_subscription_count)
        play(machine, rate, 4.0)
        told = machine.told
    found = np.array(machine.commands)
    first = int(np.flatnonzero(found[:, 1] > 0.0)[0])
    at, command = found[first:].T
    assert command[0] == pytest.approx(KP * ERROR, rel=0.01)
    # ki * e * t, whatever the rate; beyond the start, whose stamp a busy machine sends late.
    late = at - at[0] > 1.0
    assert late.sum() > 100, controller.err
    rise, begin = np.polyfit(at[late] - at[0], command[late], 1)
    assert rise == pytest.approx(KI * ERROR, rel=0.05)
    np.testing.assert_allclose(command[late], begin + rise * (at[late] - at[0]), atol=0.3)
    # A command each sample time, or for each reading; a busy machine leaves some out.
    assert (len(at) - 1) * SAMPLE / (at[-1] - at[0]) > 0.8 * max(1.0, rate * SAMPLE)
    assert told['state'] == 'running', told
    assert float(told['motor_rate_hz']) == pytest.approx(rate, rel=0.2)
    assert float(told['speed_setpoint_rate_hz']) == pytest.approx(50.0, rel=0.2)
    seldom = rate < 60
    assert ('times a second, sample_time asks for 100' in told['message']) == seldom
    assert told['level'] == (b'\1' if seldom else b'\0')


def test_the_last_reading_is_held_until_it_is_stale():
    with surroundings('held') as machine, node('controller', '-r', '__ns:=/held', *TIMES):
        wait_for(machine.motor.get_subscription_count)
        wait_for(machine.setpoint.get_subscription_count)
        play(machine, 100, 1.0)
        count = len(machine.commands)
        machine.until(lambda: machine.told.get('fault') == 'feedback_lost', reading=None)
        held = [value for _, value in machine.commands[count:]]
        # It went on with the law, about 2 s of it, and then down the ramp.
        assert max(held) > held[0] + 0.5 * KI * ERROR * 2.0
        machine.until(lambda: machine.told.get('at_zero') == 'true', reading=None)
        assert machine.commands[-1][1] == 0.0


@pytest.mark.parametrize('rate', ['50', '500'])
def test_in_lockstep_the_law_is_that_of_the_time_that_has_passed(rate, tmp_path):
    code, _, err = run('run', 'paper_step', '--rate', rate, '--duration', '4', '-o',
                       str(tmp_path / 'bag'))
    assert code == 0, err
    record = read_log(tmp_path / 'bag')
    error = record['speed_setpoint'] - record['motor_speed']
    integral = np.concatenate([[0.0], np.cumsum(error[:-1] * np.diff(record.time))])
    expected = KP * error + KI * integral
    # A command holds for a sample time, in which the integral would go on by 0.05 V at most.
    np.testing.assert_allclose(record['pump_command'], expected, atol=0.1)
