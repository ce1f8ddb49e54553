# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands of rows that come now before, now after the controller's step."""
from hst_drive.measure.commands import controller_steps, Steps
from hypothesis import given, settings, strategies as st
import numpy as np


def recorded(random, phase, jitter, rows=2000, period=0.01):
    """Return what a controller gave and what rows at uneven times show of it."""
    given_at = np.arange(rows) * period
    command = np.round(5 + np.cumsum(random.normal(0, 0.01, rows)), 3)
    time = given_at + phase * period + np.clip(random.normal(0, jitter, rows), -4e-3, 4e-3)
    shown = command[np.maximum(np.searchsorted(given_at, time, side='right') - 1, 0)]
    return command, time, shown


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.floats(1e-4, 1e-3))
def test_the_controllers_commands_come_back(seed, jitter):
    command, time, shown = recorded(np.random.default_rng(seed), 0.0, jitter)
    # The clock's phase is found to a fraction of the jitter: rows that near may fall either way.
    late = time - np.arange(len(time)) * 0.01
    clear = np.abs(late) > 0.25 * jitter
    clear &= np.append(clear[1:], False)
    steps = controller_steps(time, {'pump_command': shown})['pump_command']
    # What comes between an early row and a late one no row shows.
    known = clear & ((late >= 0) | np.append(late[1:] < 0, False))
    assert known.sum() > 0.3 * len(time)
    assert np.array_equal(steps.values[known], command[known])
    # Held from row to row, a quarter or more of the commands were wrong.
    assert np.mean(shown != command) > 0.25
    guessed = steps.low != steps.high
    drawn = steps.draw(np.random.default_rng(seed))
    assert np.array_equal(drawn[~guessed], steps.values[~guessed])


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.2, 0.8))
def test_rows_well_between_the_steps_are_left_alone(seed, phase):
    _, time, shown = recorded(np.random.default_rng(seed), phase, 4e-4)
    steps = controller_steps(time, {'pump_command': shown})['pump_command']
    assert np.array_equal(steps.values, shown)
    assert not steps.guessed


def test_even_stamps_and_few_rows_are_left_alone():
    for time in (np.arange(300) * 0.01, np.array([0.0, 0.01])):
        shown = np.sin(np.arange(len(time)))
        steps = controller_steps(time, {'pump_command': shown})['pump_command']
        assert np.array_equal(steps.values, shown)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([0.0, 5e-4, 1.5e-3]))
def test_what_lost_rows_would_have_shown_is_halfway(seed, jitter):
    """Each row's command holds until the next: at best the mean of the steps between."""
    random = np.random.default_rng(seed)
    command, time, shown = recorded(random, 1e-6, jitter, rows=8000)
    kept = np.flatnonzero((random.random(len(time)) > 0.05) | (np.arange(len(time)) == 0))
    steps = controller_steps(time[kept], {'pump_command': shown[kept]})['pump_command']
    between = np.array([command[first:last].mean() for first, last in zip(kept, kept[1:])])
    lost = np.diff(kept) > 1
    error, held = (np.std((values[:-1] - between)[lost]) for values in (
        steps.values, shown[kept]))
    assert error < 0.93 * held
    assert (steps.low != steps.high)[:-1][lost].mean() > 0.2


def test_a_single_step_that_no_row_shows_is_known_to_half_a_period():
    """One of many such steps shifts what follows by next to nothing."""
    time = np.arange(400) * 0.01
    values = np.where(time < 2.0, 1.0, 3.0)
    hidden = np.where(np.arange(400) == 199, 2.0, 0.0)
    for step, high in ((0.0, hidden), (1.0, hidden)):
        command = values + step * np.sin(40 * time)
        std = Steps(command, command, command + high).time_std(0.01)
        assert np.all(std[:190] == 0.0) and np.all(std[260:] == 0.0)
        if step:
            assert 0.0 < std[210] < 2e-3
        else:
            assert np.allclose(std[200:240], 5e-3)
