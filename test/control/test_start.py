# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""After a reset nothing moves before a start: by the set point, or by a call."""
import math

from hst_drive.control import SafetySettings, Supervisor
from hypothesis import given, settings, strategies as st
import pytest


def stopped(limits=(0.0, 10.0), manual=False, wish=5.0, **more):
    """Return a supervisor that was stopped at 1 s, came to 0 V, and has nothing against it."""
    watch = Supervisor(SafetySettings(bad_readings=1, **more), limits, manual)
    watch.wish(1.0, wish)
    watch.feedback(1.0, 1.0, 4.0)
    watch.press('topic', True, 1.0)
    watch.press('topic', False, 1.0)
    watch.ramp(1.0, 0.0)
    watch.feedback(1.1, 1.1, 0.0)
    return watch


def test_a_reset_is_refused_above_0_v_and_starts_nothing():
    watch = Supervisor(SafetySettings(emergency_stop_time=0.5))
    watch.wish(1.0, 5.0)
    watch.feedback(1.0, 1.0, 4.0)
    watch.press('topic', True, 1.0)
    watch.press('topic', False, 1.0)
    for now, command in ((1.0, 10.0), (1.125, 7.5), (1.25, 5.0)):
        assert watch.ramp(now, 10.0) == command
        assert watch.reset(now)[-1] == 'the command is not at 0 V yet' and watch.fault
    watch.ramp(1.5, 5.0)
    for now in (1.51, 1.52, 1.53):
        watch.feedback(now, now, 4.0 - now)
    watch.wish(1.5, 5.0)
    assert watch.reset(1.53) == [] and watch.fault is None
    assert watch.state == 'ready' and not watch.formed(1.53, 1.0)


@pytest.mark.parametrize('low, manual', [(0.0, False), (0.0, True), (1.5, True)])
def test_a_set_point_that_was_back_starts_and_no_other_does(low, manual):
    watch = stopped((low, 10.0), manual)
    assert watch.reset(1.1) == []
    for value in (5.0, math.nextafter(low, 10.0), 10.0):
        assert watch.wish(1.1, value)
        assert watch.state == 'ready' and not watch.formed(1.1, low)
    assert watch.wish(1.1, low) and watch.state == 'running' and watch.formed(1.1, low)
    assert watch.wish(1.1, 5.0) and watch.state == 'running' and watch.formed(1.1, 5.0)


def test_a_set_point_that_is_back_before_the_reset_is_back():
    watch = stopped()
    watch.wish(1.1, 0.0)
    assert watch.reset(1.1) == [] and watch.state == 'running'
    watch = stopped()
    watch.wish(1.1, 0.0)
    watch.wish(1.1, 5.0)
    assert watch.reset(1.1) == [] and watch.state == 'ready', 'it was, but is no more'


def test_a_start_is_refused_in_a_stop_and_before_the_first_messages():
    watch = stopped()
    assert 'emergency_stop' in watch.start()[0] and watch.fault
    assert watch.reset(1.1) == [] and watch.start() == []
    assert watch.state == 'running' and watch.formed(1.1, 5.0)
    assert watch.start() == [] and watch.state == 'running', 'a second call does no harm'
    for first in ('reading', 'wish'):
        watch = Supervisor(SafetySettings(bad_readings=1))
        watch.press('topic', True, 1.0)
        watch.press('topic', False, 1.0)
        watch.ramp(1.0, 0.0)
        if first == 'wish':
            watch.wish(1.0, 5.0)
        else:
            watch.feedback(1.0, 1.0, 0.0)
        assert watch.reset(1.0) == [] and watch.state == 'waiting'
        assert watch.start() == ['no reading or no set point has come yet']
        watch.wish(1.0, 5.0)
        watch.feedback(1.0, 1.01, 0.0)
        assert watch.state == 'ready', 'a set point that stands when it is heard first'


def test_a_first_start_needs_none_and_a_reset_of_nothing_changes_nothing():
    watch = Supervisor(SafetySettings(following_error_timeout=1.0))
    watch.wish(1.0, 5.0)
    for now in (1.0, 1.01, 1.02):
        watch.feedback(now, now, 4.0 + now)
    assert watch.state == 'running'
    assert watch.reset(1.02) == [] and watch.state == 'running' and watch.formed(1.02, 3.0)
    # It does not put off what is being timed either.
    assert not watch.lags(1.1, 20.0, 0.0, 10.0)
    watch.wish(1.9, 20.0)
    watch.feedback(1.9, 1.9, 6.0)
    assert watch.reset(1.9) == []
    assert watch.lags(2.2, 20.0, 0.0, 10.0)


def test_what_is_missing_while_it_waits_for_a_start_stops_it_anew():
    for kind, told in (('feedback_lost', 'wish'), ('setpoint_lost', 'read')):
        watch = stopped(feedback_timeout=0.5)
        assert watch.reset(1.1) == []
        watch.check(1.1)
        assert watch.state == 'ready'
        if told == 'wish':
            watch.wish(1.7, 5.0)
        else:
            watch.feedback(1.7, 1.7, 0.0)
        watch.check(1.7)
        assert watch.fault.kind == kind and watch.state == 'stopping'
        assert watch.start() and watch.fault


def test_to_be_held_goes_over_to_the_next_supervisor():
    watch = stopped()
    assert watch.reset(1.1) == []
    watch.end(1.2)
    after = Supervisor(SafetySettings())
    after.inherit(watch)
    after.wish(1.3, 5.0)
    after.feedback(1.3, 1.3, 0.0)
    assert after.state == 'ready'


def test_who_is_to_wait_for_a_start_does_so_after_a_drive_that_ran_as_well():
    """A manager asks that of a controller which somebody has cleaned up while it ran."""
    before = Supervisor(SafetySettings())
    assert not before.held
    after = Supervisor(SafetySettings(wait_for_start=True))
    after.inherit(before)
    after.wish(1.3, 5.0)
    after.feedback(1.3, 1.3, 0.0)
    assert after.state == 'ready'


def test_it_may_wait_for_a_start_from_the_beginning_on():
    def new(**more):
        watch = Supervisor(SafetySettings(wait_for_start=True, bad_readings=1, **more))
        watch.feedback(1.0, 1.0, 0.0)
        watch.wish(1.0, 5.0)
        return watch

    assert Supervisor(SafetySettings()).held is False
    watch = new()
    assert watch.state == 'ready' and not watch.formed(1.0, 1.0)
    assert watch.start() == [] and watch.state == 'running' and watch.formed(1.0, 1.0)
    watch = new()
    watch.wish(1.1, 0.0)
    assert watch.state == 'running'
    # A stop and its reset before the start are none.
    watch = new(start_after_reset=False)
    watch.press('topic', True, 1.0)
    watch.press('topic', False, 1.0)
    assert watch.reset(1.0) == [] and watch.state == 'ready'


def test_without_the_option_it_goes_on_from_the_command_that_holds():
    watch = Supervisor(SafetySettings(start_after_reset=False, bad_readings=1))
    watch.wish(1.0, 5.0)
    watch.feedback(1.0, 1.0, 4.0)
    watch.press('topic', True, 1.0)
    watch.press('topic', False, 1.0)
    assert watch.ramp(1.03, 10.0) == pytest.approx(9.0)
    assert watch.reset(1.03) == [] and watch.state == 'running' and watch.formed(1.03, 9.0)


def test_a_press_or_release_is_told_as_new_once():
    watch = Supervisor(SafetySettings())
    assert not watch.press('topic', False, 1.0)
    assert watch.press('topic', True, 1.0) and not watch.press('topic', True, 1.0)
    assert watch.press('service', True, 1.0)
    assert watch.press('topic', False, 1.0) and not watch.press('topic', False, 1.0)


EVENTS = st.lists(st.tuples(st.floats(0.0, 0.3), st.one_of(
    st.tuples(st.just('wish'), st.sampled_from([0.0, 5.0, 10.0, -1.0, math.nan])),
    st.tuples(st.just('press'), st.booleans()),
    st.sampled_from([('read',), ('reset',), ('start',), ('check',)]))), max_size=80)


@settings(max_examples=500, deadline=None)
@given(EVENTS)
def test_whatever_comes_no_reset_moves_it_until_a_start(events):
    """Independent of the supervisor's own flag: what the operator has done since the reset."""
    watch, now, sent, last, need = Supervisor(SafetySettings()), 1.0, 0.0, None, False
    for passed, (name, *values) in events:
        now += passed
        faulted = watch.fault is not None
        if name == 'wish':
            last = values[0]
            watch.wish(now, last)
            need = need and last != 0.0
        elif name == 'press':
            watch.press('topic', values[0], now)
        elif name == 'read':
            watch.feedback(now, now, 1.0 + 1e-6 * now)
        elif name == 'reset':
            if not watch.reset(now) and faulted:
                assert sent == 0.0
                need = last != 0.0
        elif name == 'start':
            need = bool(watch.start()) and need
        else:
            watch.check(now)
        if watch.fault:
            sent = watch.ramp(now, sent)
        elif watch.formed(now, 4.0):
            assert not need
            sent = 4.0
        if need and not watch.fault:
            assert sent == 0.0
