# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Signals of different rates and clocks on one time base."""
from hst_drive.bag.align import align, sample, Signal
from hst_drive.errors import InputError
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

MS = 1_000_000


def signal(channel, times_ms, values=None):
    stamps = 10**18 + np.asarray(times_ms, dtype=np.int64) * MS
    return Signal(channel, stamps, np.asarray(
        np.arange(len(stamps)) if values is None else values, dtype=float))


def test_commands_are_held_and_measurements_interpolated():
    fast = signal('pump_outlet_pressure', range(0, 1000, 10))
    run = align([fast, signal('motor_speed', range(0, 1000, 20)),
                 signal('pump_command', range(0, 1000, 20))], 'n', 's')
    np.testing.assert_allclose(run.time, np.arange(100) * 0.01)
    np.testing.assert_allclose(run['motor_speed'][:6], [0.0, 0.5, 1.0, 1.5, 2.0, 2.5])
    np.testing.assert_allclose(run['pump_command'][:6], [0.0, 0.0, 1.0, 1.0, 2.0, 2.0])
    assert any('read at the stamps of pump_outlet_pressure' in note for note in run.notes)


def test_nothing_is_extrapolated_and_gaps_stay_gaps():
    at = 10**18 + np.arange(0, 1000, 10, dtype=np.int64) * MS
    speed = signal('motor_speed', [t for t in range(100, 900, 10) if not 300 <= t < 500])
    found = sample(speed, at)
    missing = np.flatnonzero(np.isnan(found)) * 10
    assert missing.tolist() == [*range(0, 100, 10), *range(300, 500, 10), *range(900, 1000, 10)]


def test_a_short_gap_is_bridged():
    at = 10**18 + np.arange(0, 1000, 10, dtype=np.int64) * MS
    times = [t for t in range(0, 1000, 10) if t not in (300, 310, 320)]
    found = sample(signal('motor_speed', times, times), at)
    np.testing.assert_allclose(found, np.arange(0, 1000, 10))


def test_a_command_sent_only_on_change_is_held():
    at = 10**18 + np.arange(0, 40000, 10, dtype=np.int64) * MS
    found = sample(signal('speed_setpoint', [6, 12000, 30000], [1.0, 2.0, 3.0]), at)
    assert np.isnan(found[0])
    np.testing.assert_array_equal(np.unique(found[1:]), [1.0, 2.0, 3.0])
    assert found[-1] == 3.0
    assert sample(signal('speed_setpoint', [0], [7.0]), at)[-1] == 7.0


def test_a_command_between_two_stamps_acts_from_the_nearer_one():
    """Never more than half a period off; looked up at the stamps it was up to a whole one late."""
    at = 10**18 + np.arange(0, 1000, 10, dtype=np.int64) * MS
    for phase in (1, 3, 7, 9):
        found = sample(signal('pprv_command', range(phase, 1000, 10), np.arange(100)), at)
        acts = 10 * np.flatnonzero(np.diff(found) > 0) + 10     # where command 1, 2, ... begins
        sent = 10 * found[acts // 10] + phase
        assert np.abs(acts - sent).max() <= 5


def test_a_command_that_stops_is_missing_from_then_on():
    at = 10**18 + np.arange(0, 2000, 10, dtype=np.int64) * MS
    found = sample(signal('pump_command', range(0, 1000, 10)), at)
    assert np.isfinite(found[:104]).all()
    assert np.isnan(found[106:]).all()


@settings(max_examples=50, deadline=None)
@given(st.permutations(range(30)))
def test_messages_out_of_order_are_sorted(order):
    run = align([signal('motor_speed', np.array(order) * 10, order)], 'n', 's')
    np.testing.assert_array_equal(run['motor_speed'], np.arange(30.0))
    assert any('out of order' in note for note in run.notes) == (list(order) != sorted(order))


def test_repeated_stamps_are_dropped_with_a_note():
    times = sorted([*range(0, 300, 10), 50, 50, 70])
    run = align([signal('motor_speed', times)], 'n', 's')
    assert len(run) == 30
    assert any('3 messages with a repeated stamp' in note for note in run.notes)


def test_jittered_stamps_keep_a_straight_line():
    random = np.random.default_rng(3)
    base = np.cumsum(random.integers(8, 13, 300))
    other = np.cumsum(random.integers(15, 26, 160))
    run = align([signal('pump_outlet_pressure', base, base),
                 signal('motor_speed', other, other)], 'n', 's')
    known = np.isfinite(run['motor_speed'])
    assert known.sum() > 250
    np.testing.assert_allclose(run['motor_speed'][known], run['pump_outlet_pressure'][known])


def test_too_few_messages_are_refused():
    with pytest.raises(InputError, match='only 3 messages'):
        align([signal('motor_speed', [0, 10, 20])], 'n', 's')
