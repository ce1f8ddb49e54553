# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A recording as such: parts of it, and slower samples."""
from hst_drive.measure.run import Run
import numpy as np


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


def test_slower_leaves_slow_records_alone():
    run = _run(200, 0.05)
    assert run.slower(0.008) is run


def test_between_takes_the_first_and_leaves_the_last():
    part = _run().between(0.1, 0.2)
    assert part.time[0] == 0.1 and part.time[-1] < 0.2 and len(part) == 50
