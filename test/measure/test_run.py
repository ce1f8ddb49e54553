# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A recording as such: parts of it, and slower samples."""
from hst_drive.measure.run import Run
import numpy as np
import pytest


def _run(n: int = 1001, step: float = 0.002) -> Run:
    time = np.arange(n) * step
    return Run('log', time, {'motor_speed': 3.0 + 2.0 * time,
                             'pump_command': np.floor(time * 10)}, 'log.csv')


def test_slower_keeps_straight_lines_and_commands():
    slow = _run().slower(0.01)
    assert np.allclose(np.diff(slow.time), 0.01)
    # The mean of a straight line over five samples lies on the line.
    assert np.allclose(slow['motor_speed'], 3.0 + 2.0 * slow.time)
    assert set(np.unique(slow['pump_command'])) <= set(range(21))


def test_slower_averages_white_noise():
    run = _run(50001)
    noise = np.random.default_rng(3).standard_normal(len(run))
    slow = Run('n', run.time, {'motor_speed': noise}).slower(0.01)
    assert abs(slow['motor_speed'].std() * np.sqrt(5) - 1) < 0.03


def test_slower_keeps_commands_in_time_and_what_a_gap_leaves():
    """Rows are kept where the controller steps; a missing sample costs no other."""
    n = 2000
    time = np.arange(n) * 0.002
    command = np.random.default_rng(5).standard_normal(n // 5 + 1)[(np.arange(n) + 2) // 5]
    speed = np.full(n, 7.0)
    speed[101] = np.nan
    slow = Run('n', time, {'pump_command': command, 'motor_speed': speed}).slower(0.008)
    assert np.allclose(np.diff(slow.time), 0.01) and np.all(slow['motor_speed'] == 7.0)
    assert np.array_equal(slow['pump_command'], command[np.rint(slow.time / 0.002).astype(int)])
    assert np.all(np.rint(slow.time / 0.002) % 5 == 3)


def test_slower_delays_no_command_that_steps_at_any_row():
    """Held from row to row it has the same integral."""
    command = np.repeat(np.random.default_rng(6).standard_normal(400), 7)
    time = np.arange(len(command)) * 0.002
    slow = Run('n', time, {'pump_command': command}).slower(0.008)
    rows = slice(*np.rint((slow.time[[0, -1]] + [0.0, 0.008]) / 0.002).astype(int))
    assert np.sum(slow['pump_command']) * 4 == pytest.approx(np.sum(command[rows]), abs=0.1)


def test_slower_delays_no_command_beside_one_that_steps_at_its_own_pace():
    """The controller steps each 10 ms, who turns the load at any row: each keeps its integral."""
    time = 0.002 * np.arange(5000)
    random = np.random.default_rng(2)
    pump = np.repeat(random.uniform(2.0, 6.0, 1000), 5)
    load = np.cumsum(np.where(random.random(5000) < 0.01, random.normal(size=5000), 0.0))
    slow = Run('n', time, {'pump_command': pump, 'pprv_command': load}).slower(0.008)
    assert slow.sample_time == pytest.approx(0.01)
    for name, values in (('pump_command', pump), ('pprv_command', load)):
        kept = (time >= slow.time[0] - 1e-9) & (time < slow.time[-1] + 0.01 - 1e-9)
        assert 0.01 * slow[name].sum() == pytest.approx(0.002 * values[kept].sum())


def test_slower_leaves_slow_records_alone():
    run = _run(200, 0.05)
    assert run.slower(0.008) is run


@pytest.mark.parametrize('rows', [10, 12, 17])
def test_slower_leaves_records_alone_of_which_no_two_samples_would_be_left(rows):
    run = _run(rows, 0.001)
    assert run.slower(0.008) is run


def test_between_takes_the_first_and_leaves_the_last():
    part = _run().between(0.1, 0.2)
    assert part.time[0] == 0.1 and part.time[-1] < 0.2 and len(part) == 50


def test_a_part_in_which_a_sensor_was_off_has_no_such_channel():
    run = _run()
    run.channels['motor_inlet_flow'] = np.where(run.time < 1.0, 3e-4, np.nan)
    part = run.between(1.0, 2.0)
    assert 'motor_inlet_flow' not in part and 'motor_inlet_flow' in run.between(0.5, 2.0)
    assert part.notes == ('motor_inlet_flow: no numbers from 1 to 2 s; left out',)
