# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The way to standstill: every fault, its time and its ramp, and the return; no ROS."""
import math

from hst_drive.control import PiController, SafetySettings, Supervisor
from hst_drive.control.safety import FAULTS
from hypothesis import given, settings, strategies as st
import pytest

STEP = 0.01


class Loop:
    """A controller as the node runs it, in steps of simulated time."""

    def __init__(self, manual=False, **limits):
        self.watch = Supervisor(SafetySettings(**limits), manual=manual)
        self.law = PiController(0.02, 0.45, STEP)
        self.now, self.command, self.commands = 0.0, 0.0, []

    def step(self, reading=10.0, wish=10.5, stamp=None, clock=None):
        """Go one sample on; None: the message does not come. The reading wobbles as real ones."""
        self.now += STEP
        good = False
        if wish is not None:
            good = self.watch.wish(self.now, wish)
        if reading is not None:
            reading += 1e-6 * len(self.commands)
            usable = self.watch.feedback(self.now, self.now if stamp is None else stamp,
                                         reading, clock)
            if self.watch.fault is None and good:
                new = self.law.update(wish, reading if usable else math.nan)
                if self.watch.formed(self.now, new):
                    self.command = new
        self.watch.check(self.now)
        if self.watch.fault:
            self.command = self.watch.ramp(self.now, self.command)
        self.commands.append(self.command)
        return self.command

    def run(self, count, **what):
        for _ in range(count):
            self.step(**what)

    def steps_to_zero(self, **what):
        """Return how many samples it takes until the command is 0 for good."""
        self.commands = []
        self.run(400, **what)
        assert self.commands[-1] == 0.0
        return next(i for i, value in enumerate(self.commands) if not any(self.commands[i:])) + 1


CASES = {
    'feedback_lost': ({'reading': None}, 0.25),
    'feedback_not_finite': ({'reading': math.nan}, 0.02),
    'feedback_out_of_range': ({'reading': 100.0}, 0.02),
    'feedback_time': ({'stamp': 0.5}, 0.02),
    'setpoint_lost': ({'wish': None}, 0.5),
    'setpoint_invalid': ({'wish': math.nan}, 0.0),
}


@pytest.mark.parametrize('kind', CASES)
def test_each_fault_ends_at_zero_in_its_time(kind):
    what, detection = CASES[kind]
    loop = Loop()
    loop.run(200)
    assert loop.watch.state == 'running' and loop.command > 0.4
    before = loop.command
    held = detection + before / 10.0 * 1.0
    count = loop.steps_to_zero(**what)
    assert loop.watch.fault.kind == kind and loop.watch.state == 'stopped'
    # The loop may still have pushed the command up by ki * e * t while the fault was not seen.
    assert count * STEP <= held + 2 * STEP + 0.1 * 0.45 * 0.5 * detection + 1e-9
    assert kind in FAULTS and kind in str(loop.watch.fault)


def test_the_ramp_is_straight_and_the_emergency_stop_is_faster():
    for press, time in ((False, 1.0), (True, 0.3)):
        loop = Loop()
        loop.run(100)
        loop.command = 10.0
        if press:
            loop.watch.press('topic', True, loop.now)
        loop.commands = []
        loop.run(int(time / STEP) + 3, wish=10.5 if press else -1.0)
        falls = [a - b for a, b in zip(loop.commands, loop.commands[1:]) if b > 0.0]
        assert falls and max(falls) == pytest.approx(min(falls)) == pytest.approx(
            10.0 * STEP / time)
        assert loop.commands[-1] == 0.0


def test_an_emergency_stop_hastens_a_ramp_that_is_under_way():
    loop = Loop()
    loop.run(100)
    loop.command = 10.0
    loop.run(20, wish=-1.0)
    assert loop.command == pytest.approx(8.0, abs=0.11)
    loop.watch.press('service', True, loop.now)
    assert loop.steps_to_zero() <= 0.3 / STEP + 1
    assert loop.watch.fault.kind == 'emergency_stop'


def test_jumps_and_frozen_readings():
    loop = Loop(acceleration_limit=100.0)
    loop.run(50)
    loop.step(reading=14.0)     # 4 rad/s in 10 ms; one spike is passed over
    loop.run(50)
    assert loop.watch.fault is None and loop.watch.passed_over == 1
    loop.run(6, reading=20.0)
    assert loop.watch.fault.kind == 'feedback_jumps'
    watch = Supervisor(SafetySettings())
    for count in range(99):
        assert watch.feedback(count * STEP, count * STEP, 10.25)
    for count in range(99, 103):
        watch.feedback(count * STEP, count * STEP, 10.25)
    assert watch.fault.kind == 'feedback_frozen'
    watch = Supervisor(SafetySettings())
    assert all(watch.feedback(count * STEP, count * STEP, 0.0) for count in range(1000))


def test_stamps_of_another_clock_and_old_ones():
    for ahead in (-1.5, 1.5):
        loop = Loop()
        loop.run(50)
        for _ in range(3):
            loop.step(clock=loop.now + STEP + ahead)
        assert loop.watch.fault.kind == 'feedback_time'
    loop = Loop()
    loop.run(50)
    loop.step(stamp=0.1)      # the clock is set back once: one reading is passed over
    for count in range(50):
        loop.step(stamp=0.11 + count * STEP)
    assert loop.watch.fault is None


def test_every_second_reading_bad_is_a_fault_in_the_end():
    loop = Loop()
    loop.run(50)
    for _ in range(10):
        loop.step(reading=math.nan)
        loop.step()
    assert loop.watch.fault.kind == 'feedback_not_finite'


@pytest.mark.parametrize('value', [math.nan, math.inf, -0.1, 10.1])
def test_a_manual_command_beyond_its_limits(value):
    watch = Supervisor(SafetySettings(), manual=True)
    assert watch.wish(0.0, 10.0) and not watch.wish(0.1, value)
    assert watch.fault.kind == 'command_invalid'


@pytest.mark.parametrize('value', [math.nan, 11.0, -1.0])
def test_a_law_gone_wrong_is_not_sent(value):
    watch = Supervisor(SafetySettings())
    assert not watch.formed(0.0, value) and watch.fault.kind == 'command_invalid'


def test_a_reset_needs_the_cause_gone_and_returns_without_a_bump():
    loop = Loop(start_after_reset=False)
    loop.run(300)
    loop.command = 6.0
    loop.watch.press('topic', True, loop.now)
    loop.run(5)
    assert 'pressed (topic)' in loop.watch.reset(loop.now)[0]
    loop.watch.press('topic', False, loop.now)
    assert loop.watch.fault, 'releasing is no reset'
    loop.step(reading=None, wish=None)
    held = loop.command
    assert held > 0.0 and loop.watch.reset(loop.now) == []
    loop.law.reset(held)
    assert loop.step() == pytest.approx(held, abs=1e-12)
    assert abs(loop.step() - held) < 0.45 * 0.5 * STEP + 0.01


def test_nothing_is_missed_before_the_first_messages():
    watch = Supervisor(SafetySettings())
    watch.check(100.0)
    assert watch.fault is None and watch.state == 'waiting'
    watch.press('topic', True, 100.0)
    assert watch.ramp(100.1, 0.0) == 0.0 and watch.state == 'stopped'


def test_a_stop_from_before_the_simulated_time_began_ramps_as_well():
    watch = Supervisor(SafetySettings())
    watch.press('topic', True, 1.7e9)
    assert watch.ramp(1.0, 6.0) == 6.0
    assert watch.ramp(1.1, 6.0) == pytest.approx(6.0 - 10.0 * 0.1 / 0.3)
    assert watch.ramp(1.3, 6.0) == 0.0


@pytest.mark.parametrize('bad', [{'stop_time': 0.0}, {'speed_limit': -1.0},
                                 {'feedback_timeout': math.nan}, {'bad_readings': 0}])
def test_settings_that_make_no_sense(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        SafetySettings(**bad)


NUMBERS = st.one_of(st.none(), st.floats(allow_nan=True, allow_infinity=True),
                    st.floats(9.0, 11.0))
EVENT = st.tuples(NUMBERS, NUMBERS, st.sampled_from(['', 'press', 'release', 'reset']),
                  st.one_of(st.none(), st.floats(-1e9, 1e9)))


@settings(max_examples=300, deadline=None)
@given(st.lists(EVENT, max_size=60))
def test_whatever_comes_the_command_is_in_limits_falls_in_a_fault_and_never_winds_up(events):
    loop = Loop()
    loop.run(20)
    for reading, wish, button, stamp in events:
        faulted, before, integral = loop.watch.fault, loop.command, loop.law.integral
        if button == 'reset' and loop.watch.fault and not loop.watch.reset(loop.now):
            loop.law.reset(loop.command)
            faulted = None
        elif button in ('press', 'release'):
            loop.watch.press('topic', button == 'press', loop.now)
            faulted = loop.watch.fault
        loop.step(reading, wish, stamp)
        assert 0.0 <= loop.command <= 10.0
        assert math.isfinite(loop.law.integral) and abs(loop.law.integral) <= 15.0
        if faulted:
            assert loop.watch.fault, 'only a reset ends a fault'
            assert loop.command <= before
            assert loop.law.integral == integral
    loop.watch.press('topic', True, loop.now)
    loop.run(int(0.3 / STEP) + 2, reading=None, wish=None)
    assert loop.command == 0.0


@settings(max_examples=100, deadline=None)
@given(st.floats(0.0, 10.0), st.floats(0.0, 10.0), st.lists(st.floats(-12.0, 12.0), max_size=30))
def test_new_gains_do_not_move_the_command(kp, ki, errors):
    law = PiController(0.02, 0.45, STEP, (-1e6, 1e6))
    for error in errors:
        law.update(error, 0.0)
    last = errors[-1] if errors else 0.0
    expected = law.kp * last + law.integral
    law.retune(kp, ki)
    assert law.kp * last + law.integral == pytest.approx(expected, abs=1e-9)
    with pytest.raises(ValueError, match='gains'):
        law.retune(math.nan, 1.0)


def test_a_stop_goes_over_to_the_next_supervisor_and_an_end_does_not():
    loop = Loop()
    loop.run(100)
    loop.watch.press('service', True, loop.now)
    loop.command = 10.0
    loop.watch.end(loop.now)
    assert loop.watch.fault.kind == 'emergency_stop'
    second = Supervisor(SafetySettings())
    second.inherit(loop.watch)
    assert second.fault.kind == 'emergency_stop' and 'service' in second.reset(9.0)[0]
    second.press('service', False, 9.0)
    assert second.ramp(9.0, 0.0) == 0.0
    assert second.reset(9.0) == [] and second.fault is None
    loop = Loop()
    loop.run(100)
    loop.command = 10.0
    loop.watch.end(loop.now)
    assert loop.watch.fault.kind == 'shutdown'
    assert loop.steps_to_zero() <= 0.3 / STEP + 1
    third = Supervisor(SafetySettings())
    third.inherit(loop.watch)
    assert third.fault is None


def test_an_end_during_a_ramp_takes_over_with_the_fast_one():
    loop = Loop()
    loop.run(100)
    loop.command = 10.0
    loop.run(20, wish=-1.0)
    loop.watch.end(loop.now)
    assert loop.steps_to_zero() <= 0.3 / STEP + 1
    assert loop.watch.fault.kind == 'setpoint_invalid'
