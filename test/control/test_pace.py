# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The law and the time that has passed: whatever the pace, the integral is that of the error."""
from hst_drive.control import PiController
from hst_drive.nodes.pace import Pace
from hypothesis import given, strategies as st
import pytest

SAMPLE = 10_000_000     # ns
WAITS = st.lists(st.integers(1, 60_000_000), min_size=1, max_size=200)


@given(st.floats(-5.0, 5.0), WAITS)
def test_the_integral_is_the_error_times_the_time_whatever_the_waits(error, waits):
    law = PiController(0.02, 0.45, 0.01, (-1e3, 1e3))
    law.update(error, 0.0)
    for wait in waits:
        command = law.update(error, 0.0, wait * 1e-9)
    assert command == pytest.approx(0.02 * error + 0.45 * error * sum(waits) * 1e-9, abs=1e-9)


def test_an_error_counts_for_the_time_that_it_lasted():
    """The forward rule: 5 rad/s for 50 ms, then 1 rad/s for 20 ms, worked by hand."""
    law = PiController(0.0, 1.0, 0.01)
    assert law.update(5.0, 0.0) == 0.0
    assert law.update(1.0, 0.0, 0.05) == pytest.approx(0.25)
    assert law.update(0.0, 0.0, 0.02) == pytest.approx(0.27)
    assert law.update(0.0, 0.0, 1.0) == pytest.approx(0.27)


@pytest.mark.parametrize('strategy', ['conditional_integration', 'back_calculation'])
def test_a_long_wait_at_the_limit_neither_winds_up_nor_overshoots(strategy):
    law = PiController(0.02, 0.45, 0.01, antiwindup_strategy=strategy)
    for _ in range(1000):
        law.update(10.0, 0.0)
    at_limit = law.integral
    for _ in range(20):
        assert law.update(10.0, 0.0, 0.5) == 10.0
    assert law.integral == pytest.approx(at_limit, abs=0.1)
    # Nor does an error that leads off the limit wait for long.
    law.update(9.0, 10.0, 0.01)
    assert law.update(9.0, 10.0, 0.5) < 10.0


def test_a_set_point_that_may_rise_so_fast_has_that_time():
    law = PiController(1.0, 0.0, 0.1, (-100.0, 100.0), setpoint_rate_limit=5.0)
    assert law.update(10.0, 0.0) == pytest.approx(0.5)
    assert law.update(10.0, 0.0, 0.2) == pytest.approx(1.5)


@given(WAITS, st.booleans())
def test_what_is_due_adds_up_to_the_time(waits, on_grid):
    pace, now, told = Pace(SAMPLE, on_grid), 5 * 10**9, []
    assert pace.due(now) == 0.01
    begin = now
    for wait in waits:
        now += wait
        told.append(pace.due(now))
    assert sum(told) * 1e9 == pytest.approx(now - begin, abs=0.6001 * SAMPLE)
    assert all(value == 0.0 or value > 0.0059 for value in told)


@pytest.mark.parametrize('rate, most', [(1000, 105), (500, 105), (200, 102), (100, 101), (50, 51)])
@pytest.mark.parametrize('on_grid', [True, False])
def test_of_fast_readings_only_some_form_a_command(rate, most, on_grid):
    """On the grid of a simulation exactly one each sample time; by a clock a few more."""
    pace = Pace(SAMPLE, on_grid)
    formed = [pace.due(step * 10**9 // rate) for step in range(rate + 1)]
    count = sum(value > 0.0 for value in formed)
    assert count <= (most if on_grid else 1.7 * most)
    assert count >= min(rate, 100)
    if on_grid:
        assert all(value in (0.0, 0.01, 0.02) for value in formed)
    pace.restart()
    assert pace.due(2 * 10**9) == 0.01
    assert pace.due(10**9) == 0.01, 'a simulation that begins anew'
