# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A clock that is set back: the true times of the messages are known here, and come back."""
from hst_drive.bag.clock import set_forward_again, steps_back, Written
from hypothesis import example, given, settings, strategies as st
import numpy as np
import pytest

MS = 1_000_000
PERIOD = 10 * MS


def topics(steps, seed, jitter=0.1):
    """Return a dense topic, one at half the rate, one of four messages: (true, Written)."""
    random = np.random.default_rng(seed)
    parts = []
    for number, period in enumerate((PERIOD, 2 * PERIOD, 400 * PERIOD)):
        true = 10**18 + np.arange(1600 * PERIOD // period, dtype=np.int64) * period
        true += random.integers(0, max(int(jitter * PERIOD), 1), len(true)) + number
        shown = true.copy()
        for at, lost in steps:
            shown -= np.where(true >= 10**18 + at * PERIOD, lost * MS, 0)
        parts.append((true, shown))
    order = np.argsort(np.concatenate([true for true, _ in parts]), kind='stable')
    places = np.empty(len(order), dtype=np.int64)
    places[order] = np.arange(len(order))
    found, at = [], 0
    for true, shown in parts:
        found.append((true, Written('', places[at:at + len(true)], shown)))
        at += len(true)
    return found


def right(written, notes):
    """Return the stamps put right, in the order of the topics."""
    return [stamps for _, stamps in sorted(set_forward_again(written, notes),
                                           key=lambda entry: entry[0])]


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.integers(1, 7), st.integers(20, 10**8)), max_size=3,
                unique_by=lambda step: step[0]), st.integers(0, 2**31))
@example([(6, 12051)], 0)     # to just before the first message
def test_the_true_times_come_back(steps, seed):
    found = topics([(200 * place, lost) for place, lost in steps], seed)
    notes = []
    put_right = right([entry for _, entry in found], notes)
    assert len(notes) == len(steps)
    for (true, _), times in zip(found, put_right):
        np.testing.assert_allclose(times - true[0], true - true[0], atol=0.6 * PERIOD)
        assert (np.diff(times) > 0).all()


def test_a_message_that_was_written_late_stays_with_its_stretch():
    (true, dense), (_, other) = topics([(800, 3000)], 1)[:2]
    late = np.argmin(np.diff(other.stamps))     # the last one before the step
    order = other.order.copy()
    order[late] = order[late + 1] - 1           # is written only after the step
    dense_order = dense.order.copy()
    dense_order[(dense.order >= other.order[late]) & (dense.order < order[late + 1])] -= 1
    put_right = right([Written('', dense_order, dense.stamps),
                       Written('', order, other.stamps)], [])
    assert (np.diff(put_right[1]) > 0).all()
    assert np.abs(np.diff(put_right[1]) - 2 * PERIOD).max() < PERIOD


@pytest.mark.parametrize('burst', [1, 3, 30, 300])
def test_late_messages_are_no_step(burst):
    (true, dense), *_ = topics([], 2)
    times = true.copy()
    times[500:500 + 2 * burst] = np.concatenate([true[500 + burst:500 + 2 * burst],
                                                 true[500:500 + burst]])
    assert not steps_back(Written('', dense.order, times))


def test_two_sources_are_no_step():
    (true, dense), *_ = topics([], 3)
    times = true.copy()
    times[1::2] -= 5_000 * MS
    assert not steps_back(Written('', dense.order, times))


def test_a_sensor_with_a_clock_of_its_own():
    (true, dense), (other_true, other), *_ = topics([], 4)
    shown = other.stamps - np.where(other_true >= 10**18 + 800 * PERIOD, 3_000 * MS, 0)
    notes = []
    first, second = right([dense, other._replace(name='/flow', stamps=shown)], notes)
    np.testing.assert_array_equal(first, dense.stamps)
    np.testing.assert_allclose(second - true[0], other_true - true[0], atol=0.6 * PERIOD)
    assert len(notes) == 1 and notes[0].startswith('/flow: its clock was set back by 3 s')
