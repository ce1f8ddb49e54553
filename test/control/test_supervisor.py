# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a supervisor says and does, whatever happens and in whatever order."""
import math

from hst_drive.control import SafetySettings, Supervisor
from hypothesis import example, given, settings, strategies as st

LIMITS = (0.0, 10.0)
SPEEDS = st.one_of(st.floats(0.0, 25.0), st.sampled_from([math.nan, math.inf, -40.0, 95.0]))
EVENTS = st.lists(st.tuples(st.floats(0.0, 0.4), st.one_of(
    st.tuples(st.just('read'), SPEEDS, st.sampled_from(['', '', 'two joints'])),
    st.tuples(st.just('wish'), SPEEDS),
    st.tuples(st.just('law'), st.floats(-1.0, 12.0), SPEEDS),
    st.tuples(st.just('ramp')), st.tuples(st.just('ramp')),
    st.tuples(st.just('press'), st.sampled_from(['topic', 'service']), st.booleans()),
    st.tuples(st.just('reset')), st.tuples(st.just('check')), st.tuples(st.just('end')),
)), max_size=60)


class Machine:
    """A supervisor as its node uses it, and the command that was really given out last."""

    def __init__(self):
        self.watch = Supervisor(SafetySettings(following_error_timeout=0.5), LIMITS)
        self.now, self.sent, self.resets, self.pressed = 100.0, None, 0, set()
        self.wanted = 0.0

    def read(self, value, refused):
        self.watch.feedback(self.now, self.now, value, None, refused)

    def wish(self, value):
        self.wanted = value
        self.watch.wish(self.now, value)

    def law(self, command, speed):
        """Send what a law has made, as long as that is allowed."""
        watch = self.watch
        if watch.fault is None and watch.formed(self.now, command) and not watch.lags(
                self.now, 10.0, speed, command):
            self.sent = command

    def ramp(self):
        if self.watch.fault:
            self.sent = self.watch.ramp(self.now, self.sent or 0.0)

    def press(self, source, pressed):
        (self.pressed.add if pressed else self.pressed.discard)(source)
        self.watch.press(source, pressed, self.now)

    def reset(self):
        if not self.watch.reset(self.now):
            self.resets += 1

    def check(self):
        self.watch.check(self.now)

    def end(self):
        self.watch.end(self.now)


# A set point that still stands when a stop is reset.
STANDING = [(0.0, ('read', 1.0, '')), (0.0, ('wish', math.nan)), (0.0, ('ramp',)),
            (1.1, ('ramp',)), *[(0.1, ('read', speed, '')) for speed in (0.3, 0.2, 0.1)],
            (0.0, ('wish', 5.0)), (0.0, ('reset',))]


@settings(max_examples=500, deadline=None)
@example(STANDING)
@given(EVENTS)
def test_it_says_zero_when_zero_was_sent_and_never_raises_the_command_in_a_fault(events):
    machine = Machine()
    watch = machine.watch
    for passed, (name, *values) in events:
        machine.now += passed
        faulted, before, resets = watch.fault, machine.sent, machine.resets
        getattr(machine, name)(*values)
        if watch.state == 'stopped':
            assert machine.sent == 0.0
        if faulted and machine.resets == resets:
            assert watch.fault, 'only a reset ends a fault'
            assert (machine.sent or 0.0) <= (before or 0.0)
            assert watch.state in ('stopping', 'stopped')
        if machine.resets > resets:
            assert not machine.pressed and watch.fault is None
            assert not faulted or watch.state in ('waiting', 'ready') or machine.wanted == 0.0, (
                'a reset starts nothing')
            assert machine.sent == before, 'a reset sends nothing'
        if machine.pressed:
            assert watch.fault
        if machine.sent is not None:
            assert LIMITS[0] <= machine.sent <= LIMITS[1]
    machine.press('topic', True)
    if machine.sent:
        assert watch.state == 'stopping'
    machine.ramp()
    machine.now += 1.0 + 1e-9     # the slower of the two ramps
    machine.ramp()
    assert machine.sent == 0.0 and watch.state == 'stopped'


def test_zero_is_said_after_the_first_step_of_each_ramp_that_gives_it():
    """Also of a second fault after a stop that ended at zero, and after a change of supervisor."""
    watch = Supervisor(SafetySettings(), LIMITS)
    watch.press('topic', True, 1.0)
    assert watch.state == 'stopping'
    assert watch.ramp(1.0, 3.1) == 3.1 and watch.state == 'stopping'
    assert watch.ramp(2.0, 3.1) == 0.0 and watch.state == 'stopped'
    after = Supervisor(SafetySettings(), LIMITS)
    after.inherit(watch)
    assert after.state == 'stopping'
    assert after.ramp(2.1, 0.0) == 0.0 and after.state == 'stopped'
    watch.press('topic', False, 3.0)
    assert watch.reset(3.0) == [] and watch.state == 'waiting' and watch.held
    watch.press('topic', True, 4.0)
    assert watch.state == 'stopping', 'the zero of the stop before does not count'
