# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The supervisor at the edges of its limits, and its counts; numbers that are exact in binary."""
import math

from hst_drive.control import SafetySettings, Supervisor
from hst_drive.control.faults import Fault, FAULTS
import pytest

STEP = 1.0 / 64.0


class Readings:
    """A supervisor and the readings that it gets, one each step; they wobble unless told."""

    def __init__(self, limits=(0.0, 10.0), manual=False, **settings):
        self.watch = Supervisor(SafetySettings(**settings), limits, manual)
        self.now, self.turn = 100.0, 1.0

    def give(self, *values, step=STEP, stamp=None, clock=None, refused=''):
        """Give readings; return for each whether it may be used."""
        usable = []
        for value in values:
            self.now += step
            usable.append(self.watch.feedback(
                self.now, self.now if stamp is None else stamp, value, clock, refused))
        return usable

    def good(self, count):
        """Give readings without fault."""
        for _ in range(count):
            self.turn = -self.turn
            assert self.give(10.0 + 0.125 * self.turn) == [True]

    def reset(self, later=0.0):
        """Reset at 0 V."""
        if self.watch.fault:
            self.watch.ramp(self.now, 0.0)
        return self.watch.reset(self.now + later)

    @property
    def kind(self):
        """The fault's kind, or None."""
        return self.watch.fault.kind if self.watch.fault else None


@pytest.mark.parametrize('many', [1, 2, 3, 7])
def test_so_many_bad_readings_in_a_row_and_none_fewer(many):
    readings = Readings(bad_readings=many)
    readings.good(5)
    assert readings.give(*[math.nan] * (many - 1)) == [False] * (many - 1)
    assert readings.kind is None and readings.watch.passed_over == many - 1
    assert readings.give(math.nan) == [False] and readings.kind == 'feedback_not_finite'
    readings.give(math.nan)
    assert readings.watch.passed_over == many, 'counted until the fault'


def test_one_bad_reading_in_five_is_forgiven_for_ever_and_more_are_not():
    readings = Readings(bad_readings=2)
    for _ in range(100):
        readings.give(math.nan)
        readings.good(4)
    assert readings.kind is None
    # Three good ones make up for three quarters: a quarter of each bad one stays.
    readings = Readings(bad_readings=2)
    for cycle in range(5):
        assert readings.kind is None, cycle
        readings.give(math.nan)
        readings.good(3)
    assert readings.kind == 'feedback_not_finite'


def test_good_readings_are_not_saved_up_for_bad_ones():
    readings = Readings()
    readings.good(100)
    readings.give(math.nan, math.nan)
    assert readings.kind is None
    readings.give(math.nan)
    assert readings.kind


def test_a_reset_needs_so_many_good_readings_and_then_counts_from_nothing():
    readings = Readings(bad_readings=3)
    readings.good(2)
    readings.give(math.nan, math.nan, math.nan)
    assert readings.reset() == ['the speed reading is not a number']
    readings.good(2)
    assert readings.reset() == ['too few good readings yet']
    readings.give(math.nan)
    readings.good(2)
    assert readings.reset() == ['too few good readings yet'], 'one in between: again'
    readings.good(1)
    assert readings.reset() == []
    for many in (3, 7):
        fresh = Readings(bad_readings=many)
        fresh.watch.press('topic', True, fresh.now)
        fresh.watch.press('topic', False, fresh.now)
        fresh.good(many - 1)
        assert fresh.reset() == ['too few good readings yet']
        fresh.good(1)
        assert fresh.reset() == []
    # What the stop was for does not weigh on the time after it.
    assert readings.give(math.nan, math.nan) == [False, False] and readings.kind is None
    readings.give(math.nan)
    assert readings.kind == 'feedback_not_finite'


def test_what_stands_against_a_reset_is_told_as_long_as_it_does():
    readings = Readings(frozen_timeout=0.0)
    watch = readings.watch
    watch.wish(readings.now, -1.0)
    readings.good(10)
    assert readings.reset() == ['the set point is not a number in its range']
    watch.wish(readings.now, 1.0)
    assert readings.reset(0.25) == []
    watch.press('topic', True, readings.now)
    watch.press('service', True, readings.now)
    assert readings.reset(0.75) == [
        'emergency stop is pressed (service)', 'emergency stop is pressed (topic)',
        'no usable speed reading', 'no set point']


def test_a_frozen_reading_is_one_at_once_and_a_reset_begins_its_time_anew():
    readings = Readings(frozen_timeout=1.0)
    assert all(readings.give(*[10.0] * 65)) and readings.kind is None      # 1 s to the digit
    assert readings.give(10.0) == [False] and readings.kind == 'feedback_frozen'
    assert readings.watch.fault.found == '10 rad/s for 1.02 s'
    readings.good(3)
    readings.give(9.5)
    assert readings.reset() == []
    assert all(readings.give(*[9.5] * 64)) and readings.kind is None
    assert readings.give(9.5) == [False] and readings.kind == 'feedback_frozen'
    # It rests, sticks for long while it is not judged, and goes on.
    readings = Readings(frozen_timeout=1.0)
    assert all(readings.give(*[0.0] * 200, *[10.0] * 65)) and readings.kind is None
    readings = Readings(frozen_timeout=0.0)
    assert all(readings.give(*[10.0] * 200))


def test_a_fault_before_the_reset_does_not_count_as_frozen_after_it():
    readings = Readings(frozen_timeout=1.0)
    readings.good(3)
    readings.watch.press('topic', True, readings.now)
    readings.give(*[10.0] * 60)
    readings.watch.press('topic', False, readings.now)
    assert readings.reset() == []
    assert all(readings.give(*[10.0] * 60)) and readings.kind is None


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_the_speed_limit_is_still_a_good_reading(sign):
    readings = Readings(speed_limit=16.0, acceleration_limit=1e6, frozen_timeout=0.0)
    assert readings.give(sign * 16.0) == [True]
    assert readings.give(sign * math.nextafter(16.0, 17.0)) == [False]


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_the_acceleration_limit_is_still_a_good_reading(sign):
    readings = Readings(acceleration_limit=64.0)
    assert readings.give(8.0, 8.0 + sign) == [True, True]
    assert readings.give(8.0 - 0.03125 * sign) == [False]


def test_the_default_acceleration_limit():
    """Beyond what the drive can do, 700 rad/s^2 as the relief valve lets go; not far beyond."""
    for change, usable in ((14.5, True), (-14.5, True), (15.5, False), (-15.5, False)):
        readings = Readings()
        assert readings.give(0.0, step=0.01) and readings.give(change, step=0.01) == [usable]


def test_readings_passed_over_give_the_next_one_their_time():
    """The relief valve lets go at 700 rad/s^2, and two readings are lost: no jump of the third."""
    for wrong in (math.nan, 95.0):
        readings = Readings()
        assert readings.give(0.0, 7.0, wrong, wrong, 28.0, step=0.01) == [
            True, True, False, False, True]
        assert readings.kind is None
    readings = Readings(acceleration_limit=64.0)
    readings.give(10.0, math.nan)
    assert readings.give(12.125) == [False]
    # What jumps gives the next one no time: else a second look would let it through.
    assert readings.give(12.125) == [False] and readings.kind == 'feedback_jumps'


def test_a_first_reading_is_no_jump_whatever_came_before_it():
    for first in (math.nan, 1e6):
        readings = Readings()
        assert readings.give(first) == [False] and readings.give(10.0) == [True]


def test_a_new_level_is_taken_in_once_the_fault_is_there():
    readings = Readings(acceleration_limit=64.0, bad_readings=3)
    readings.good(3)
    assert readings.give(20.0, 20.125, 20.0) == [False] * 3 and readings.kind == 'feedback_jumps'
    # It comes down by itself: a spike, while there was no fault, moved nothing.
    assert readings.give(20.125) == [False]
    assert readings.give(20.0, 20.125, 20.0) == [True] * 3
    assert readings.reset() == []


def test_the_stamp_tolerance_is_still_good_on_both_sides_and_may_be_off():
    for clock, usable in ((101.5, True), (100.5, True), (101.25, True), (101.0, True),
                          (101.5 + STEP, False), (100.5 - STEP, False)):
        assert Readings(stamp_tolerance=0.5).give(10.0, stamp=101.0, clock=clock) == [usable]
    assert Readings(stamp_tolerance=0.0).give(10.0, clock=1e9) == [True]
    assert Readings().give(10.0, clock=None) == [True]


@pytest.mark.parametrize('clock, said', [
    (205.0, '105 s old'), (95.0, '5 s in the future'), (0.0, 'does anybody publish /clock?')])
def test_what_is_wrong_with_a_stamp_is_told(clock, said):
    readings = Readings(bad_readings=1)
    readings.give(10.0, stamp=100.0, clock=clock)
    assert said in readings.watch.fault.found
    assert ('/clock' in readings.watch.fault.found) == (clock == 0.0)


def test_a_stamp_that_stands_or_runs_back():
    readings = Readings()
    assert readings.give(10.0, stamp=5.0) == [True]
    assert readings.give(10.5, stamp=5.0) == [False]
    assert readings.give(10.5, stamp=4.0) == [False]
    assert readings.give(10.5, stamp=4.5) == [True]
    for stamp in (float('5.0'), 4.0):
        readings = Readings(bad_readings=1)
        readings.give(10.0, stamp=5.0)
        assert readings.give(10.5, stamp=stamp) == [False] and readings.kind == 'feedback_time'


def test_times_that_are_just_kept():
    for name, kind in (('feedback_timeout', 'feedback_lost'),
                       ('setpoint_timeout', 'setpoint_lost')):
        watch = Supervisor(SafetySettings(**{
            'feedback_timeout': 100.0, 'setpoint_timeout': 100.0, name: 0.5}))
        watch.wish(0.25, 5.0)
        watch.feedback(0.25, 0.25, 5.0)
        watch.check(0.75)
        assert watch.fault is None
        watch.check(0.75 + STEP)
        assert watch.fault.kind == kind and 'for 0.516 s' in watch.fault.found
    watch = Supervisor(SafetySettings(feedback_timeout=1e9, setpoint_timeout=0.0))
    watch.wish(1.0, 5.0)
    watch.feedback(1.0, 1.0, 5.0)
    watch.check(1e6)
    assert watch.fault is None


def test_nothing_is_lost_until_both_have_come():
    for first in ('wish', 'reading'):
        watch = Supervisor(SafetySettings())
        if first == 'wish':
            watch.wish(1.0, 5.0)
        else:
            watch.feedback(1.0, 1.0, 5.0)
        watch.check(100.0)
        assert watch.fault is None and watch.state == 'waiting'


@pytest.mark.parametrize('manual, low, high, unit, kind', [
    (False, 0.0, 16.0, 'rad/s', 'setpoint_invalid'), (True, 0.5, 8.0, 'V', 'command_invalid')])
def test_wishes_and_commands_at_their_limits(manual, low, high, unit, kind):
    for good in (low, high):
        watch = Supervisor(SafetySettings(speed_limit=16.0), (0.5, 8.0), manual)
        assert watch.wish(1.0, good) and watch.fault is None
    for bad in (math.nextafter(low, -1.0), math.nextafter(high, 99.0)):
        watch = Supervisor(SafetySettings(speed_limit=16.0), (0.5, 8.0), manual)
        assert not watch.wish(1.0, bad) and watch.fault.kind == kind
        assert f' {unit}, expected {low:g} to {high:g}' in watch.fault.found
    watch = Supervisor(SafetySettings(), (0.5, 8.0))
    assert watch.wish(1.0, 20.0), 'rad/s, unless it is told that they are volts'
    assert watch.formed(1.0, 0.5) and watch.formed(1.0, 8.0)
    assert not watch.formed(1.0, math.nextafter(0.5, 0.0))
    assert watch.fault.kind == 'command_invalid'


def lagging(error, command=10.0, limits=(0.0, 10.0), seconds=4.0, setpoint=2.0, **settings):
    """Hold an error and a command for so long; return whether that is a fault."""
    watch = Supervisor(SafetySettings(**{'following_error_limit': 0.5, **settings,
                                         'following_error_timeout': 2.0}), limits)
    for step in range(round(seconds / STEP) + 1):
        now = step * STEP
        told = watch.lags(now, setpoint, setpoint - error,
                          command(now) if callable(command) else command)
        assert told == (watch.fault is not None)
        if told:
            return True
    return False


def test_the_following_error_at_its_edges():
    # Half the set point, and the limit, are still near enough; the time is still kept.
    assert not lagging(1.0) and lagging(1.0 + STEP)
    assert not lagging(1.5, following_error_limit=1.5)
    assert lagging(1.5 + STEP, following_error_limit=1.5)
    assert not lagging(2.0, seconds=2.0) and lagging(2.0, seconds=2.0 + STEP)
    assert lagging(0.75, setpoint=1.0) and not lagging(0.75, 0.0, setpoint=1.0)


@pytest.mark.parametrize('nearer, fault', [(8.0, False), (9.0, False), (9.5, True)])
def test_an_error_that_falls_to_nine_tenths_begins_a_new_time(nearer, fault):
    watch = Supervisor(SafetySettings(following_error_timeout=2.0))
    for now, error in ((0.0, 10.0), (1.5, nearer), (3.0, nearer)):
        told = watch.lags(now, 10.0, 10.0 - error, 10.0)
    assert told == fault


@pytest.mark.parametrize('error', [1.5, -1.5])
@pytest.mark.parametrize('low, high', [(0.0, 10.0), (2.0, 6.0)])
def test_a_following_error_needs_a_command_that_is_at_its_limit_or_moves_on(error, low, high):
    limits, middle, way = (low, high), 0.5 * (low + high), math.copysign(1.0, error)
    assert lagging(error, high if error > 0.0 else low, limits)
    assert not lagging(error, low if error > 0.0 else high, limits)
    assert not lagging(error, middle, limits)
    # A hundredth of the range is the noise of a law that rests.
    for share, fault in ((0.008, False), (0.012, True), (-0.5, False)):
        step = way * share * (high - low)
        assert lagging(error, lambda now: middle + step * (now > 1.0), limits) == fault
    whole = 0.01 * 100.0
    assert not lagging(error, lambda now: 50.0 + way * whole * (now > 1.0), (0.0, 100.0))
    # Each time is judged by itself: what moved long ago does not count later.
    assert not lagging(error, lambda now: middle + 0.004 * way * (high - low) * now, limits, 8.0)


def test_a_reading_passed_over_at_the_beginning_does_not_hide_that_the_drive_follows():
    watch = Supervisor(SafetySettings(following_error_timeout=2.0))
    assert not watch.lags(0.0, 20.0, math.nan, 10.0)
    for step in range(640):
        assert not watch.lags(step * STEP, 20.0, 1.5 * step * STEP, 10.0)


def test_a_stop_of_another_supervisor_goes_on_and_none_stays_none():
    before, after = (Supervisor(SafetySettings()) for _ in range(2))
    after.inherit(before)
    assert after.fault is None and after.reset(1.0) == []
    before.press('topic', True, 1.0)
    after.inherit(before)
    assert after.fault.kind == 'emergency_stop'


def test_the_ramp_begins_at_the_fault_and_ends_for_good():
    """The time until its first step counts; a clock that stands or runs back gives nothing up."""
    watch = Supervisor(SafetySettings(stop_time=1.0), (0.0, 8.0))
    watch.wish(10.0, -1.0)
    assert watch.ramp(10.25, 8.0) == 6.0
    assert watch.ramp(10.25, 8.0) == 6.0 and watch.ramp(10.0, 8.0) == 6.0
    assert watch.ramp(10.5, 8.0) == 4.0
    watch.end(10.5)
    assert watch.ramp(10.575, 8.0) == pytest.approx(2.0)
    assert watch.ramp(11.0, 8.0) == 0.0 and watch.ramp(12.0, 8.0) == 0.0


def test_the_defaults_at_their_edges():
    assert Readings().give(29.9) == [True] and Readings().give(30.1) == [False]
    assert Readings().give(*[10.0] * 66) == [True] * 65 + [False], 'frozen for more than 1 s'
    for error, fault in ((2.9, None), (3.1, 'following_error')):
        watch = Supervisor(SafetySettings())
        for step in range(round(5.1 / STEP)):
            assert watch.fault is None or step * STEP > 5.0
            watch.lags(step * STEP, 4.0, 4.0 - error, 10.0)
        assert (watch.fault.kind if watch.fault else None) == fault


def test_a_fault_says_what_it_is_and_what_was_found():
    watch = Supervisor(SafetySettings())
    watch.end(1.0)
    assert str(watch.fault) == 'shutdown: the controller is being ended'
    watch.press('topic', True, 2.0)
    assert str(watch.fault) == 'emergency_stop: emergency stop (by topic)'
    assert watch.fault.time == 2.0


@pytest.mark.parametrize('kind', [kind for kind in FAULTS if kind != 'emergency_stop'])
def test_an_emergency_stop_outranks_every_fault_and_nothing_outranks_it(kind):
    watch = Supervisor(SafetySettings(stop_time=4.0, emergency_stop_time=1.0))
    watch.fault = first = Fault(kind, 'found', 1.0)
    watch.wish(1.5, -1.0)
    watch.formed(1.5, 11.0)
    assert watch.fault == first, 'the first one is told'
    assert watch.ramp(2.0, 8.0) == 5.5, '10 V in 4 s, for the second since it came'
    watch.press('topic', True, 2.0)
    assert watch.ramp(2.25, 8.0) == 3.0, '10 V in 1 s'
    assert watch.fault == Fault('emergency_stop', 'by topic', 2.0)
    watch.press('service', True, 3.0)
    watch.wish(3.0, -1.0)
    watch.formed(3.0, 11.0)
    watch.end(3.0)
    assert watch.fault == Fault('emergency_stop', 'by topic', 2.0), 'the first one is told'


def test_the_defaults_are_those_that_the_table_of_faults_tells():
    assert vars(SafetySettings()) == {
        'feedback_timeout': 0.25, 'setpoint_timeout': 0.5, 'stamp_tolerance': 1.0,
        'frozen_timeout': 1.0, 'bad_readings': 3, 'speed_limit': 30.0,
        'acceleration_limit': 1500.0, 'following_error_limit': 3.0,
        'following_error_timeout': 5.0, 'stop_time': 1.0, 'emergency_stop_time': 0.3,
        'start_after_reset': True, 'wait_for_start': False}


def test_nobody_changes_the_limits_of_a_supervisor_that_watches():
    with pytest.raises(AttributeError):
        SafetySettings().stop_time = 9.0
