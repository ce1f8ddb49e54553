# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A drive that turns either way: the law and the way to standstill, forwards as backwards."""
import math

from hst_drive.control import PiController, PumpFeedForward, SafetySettings, Supervisor
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

STEP = 0.01
LIMITS = (-10.0, 10.0)
BAND = 1.0          # V to either side of zero stroke
GAIN, LAG = 3.0, 0.3    # rad/s per V beyond the band; s
COMMAND = np.array([-10.0, -1.0, 1.0, 10.0])
DISPLACEMENT = np.array([-71.0, 0.0, 0.0, 71.0]) * 1e-6 / (2.0 * math.pi)


def steady_speed(command):
    """Return what the drive comes to at a command, from the table alone."""
    return GAIN * math.copysign(max(abs(command) - BAND, 0.0), command)


class Loop:
    """Supervisor and law as the node runs them, around a drive of first order."""

    def __init__(self, limits=LIMITS, manual=False, dead_band=BAND, **safety):
        self.watch = Supervisor(SafetySettings(**safety), limits, manual)
        self.law = PiController(0.02, 0.45, STEP, limits, dead_band=dead_band)
        self.now, self.command, self.speed, self.jammed = 0.0, 0.0, 0.0, False
        self.commands, self.speeds = [], []

    def step(self, wish, noise=0.0):
        self.now += STEP
        self.watch.wish(self.now, wish)
        reading = self.speed + noise
        usable = self.watch.feedback(self.now, self.now, reading)
        self.watch.check(self.now)
        if self.watch.fault is None:
            new = wish if self.watch.manual else self.law.update(
                wish, reading if usable else math.nan)
            if self.watch.formed(self.now, new) and (
                    self.watch.manual or not self.watch.lags(self.now, wish, reading, new)):
                self.command = new
        if self.watch.fault:
            self.command = self.watch.ramp(self.now, self.command)
        share = math.exp(-STEP / LAG)
        self.speed = 0.0 if self.jammed else (
            share * self.speed + (1.0 - share) * steady_speed(self.command))
        self.commands.append(self.command)
        self.speeds.append(self.speed)

    def run(self, seconds, wish):
        for _ in range(round(seconds / STEP)):
            self.step(wish)


@pytest.mark.parametrize('way', [1.0, -1.0])
@pytest.mark.parametrize('dead_band', [0.0, BAND])
def test_the_set_point_is_reached_either_way(way, dead_band):
    loop = Loop(dead_band=dead_band)
    loop.run(8.0, 12.0 * way)
    assert loop.watch.fault is None
    assert loop.speed == pytest.approx(12.0 * way, rel=2e-3)
    assert loop.command == pytest.approx(way * (12.0 / GAIN + BAND), rel=2e-3)


def test_it_stops_and_reverses_and_drills_on():
    loop = Loop()
    for wish in (12.0, 0.0, -6.0, 0.0, 12.0):
        loop.run(8.0, wish)
        assert loop.watch.fault is None
        assert loop.speed == pytest.approx(wish, abs=0.02), wish
        assert abs(loop.command) <= BAND + 1e-9 if wish == 0.0 else loop.command * wish > 0.0


def time_to_turn(dead_band):
    """Return how long the speed takes from 6 rad/s to beyond standstill, s."""
    loop = Loop(dead_band=dead_band)
    loop.run(8.0, 6.0)
    loop.speeds.clear()
    loop.run(8.0, -6.0)
    return STEP * next(i for i, speed in enumerate(loop.speeds) if speed < -0.3)


def test_the_dead_band_is_stepped_over():
    """The integral alone crosses the 2 V of it at up to 0.45 V/rad times the error."""
    assert time_to_turn(BAND) < time_to_turn(0.0) - 0.2


@settings(max_examples=60, deadline=None)
@given(wishes=st.lists(st.floats(-35.0, 35.0), min_size=1, max_size=6),
       faults=st.sampled_from(['none', 'stop', 'jam', 'manual']), seed=st.integers(0, 99))
def test_backwards_is_forwards_in_a_mirror(wishes, faults, seed):
    """The same numbers to the last bit, with the other sign, through all faults."""
    def commands(way):
        loop = Loop(manual=faults == 'manual', following_error_timeout=1.0)
        noise = np.random.default_rng(seed).normal(0.0, 0.05, 60 * len(wishes))
        for i, value in enumerate(noise):
            if i == 50:
                loop.jammed = faults == 'jam'
                if faults == 'stop':
                    loop.watch.press('test', True, loop.now)
            loop.step(way * wishes[i // 60], way * value)
        return loop.commands, loop.watch.fault and loop.watch.fault.kind

    forwards, backwards = commands(1.0), commands(-1.0)
    assert [-value for value in backwards[0]] == forwards[0]
    assert forwards[1] == backwards[1]


@pytest.mark.parametrize('way', [1.0, -1.0])
@pytest.mark.parametrize('kind, seconds', [('emergency_stop', 0.3), ('setpoint_lost', 1.0)])
def test_a_stop_ends_at_zero_stroke_from_either_side(way, kind, seconds):
    loop = Loop()
    loop.run(5.0, 20.0 * way)
    before = loop.command
    assert way * before > 5.0
    if kind == 'emergency_stop':
        loop.watch.press('panel', True, loop.now)
    else:
        loop.watch._trip(kind, '', loop.now)
    loop.commands.clear()
    loop.run(6.0, 20.0 * way)
    sizes = [way * value for value in loop.commands]
    assert all(b <= a for a, b in zip(sizes, sizes[1:]))
    # The whole of 10 V takes the whole time, from here it takes its share.
    took = STEP * (next(i for i, value in enumerate(sizes) if value == 0.0) + 1)
    assert took == pytest.approx(seconds * abs(before) / 10.0, abs=1.5 * STEP)
    assert math.copysign(1.0, loop.commands[-1]) == 1.0 and loop.watch.state == 'stopped'
    assert abs(loop.speed) < 1e-3


def test_after_a_reset_it_waits_for_a_set_point_of_zero():
    loop = Loop()
    loop.run(3.0, -10.0)
    loop.watch.press('panel', True, loop.now)
    assert loop.watch.reset(loop.now)
    loop.run(1.0, -10.0)
    loop.watch.press('panel', False, loop.now)
    assert loop.watch.reset(loop.now) == [] and loop.watch.state == 'ready'
    loop.law.reset(loop.command)
    # Its smallest is full speed backwards: no start.
    for wish in (-10.0, -30.0, 10.0):
        loop.run(0.3, wish)
        assert loop.command == 0.0 and loop.watch.state == 'ready'
    loop.run(0.1, 0.0)
    assert loop.watch.state == 'running'
    loop.run(6.0, -10.0)
    assert loop.speed == pytest.approx(-10.0, rel=0.01)


@pytest.mark.parametrize('limits, wish, fits', [
    (LIMITS, -30.0, True), (LIMITS, -30.001, False), (LIMITS, 30.001, False),
    ((0.0, 10.0), -0.001, False), ((0.0, 10.0), 0.0, True)])
def test_set_points_backwards_are_for_drives_that_can(limits, wish, fits):
    watch = Supervisor(SafetySettings(), limits)
    assert watch.wish(0.0, wish) is fits
    assert (watch.fault is None) is fits


@pytest.mark.parametrize('way', [1.0, -1.0])
def test_a_jam_and_a_sensor_of_the_wrong_sign_are_found_either_way(way):
    loop = Loop()
    loop.run(4.0, 12.0 * way)
    loop.jammed = True
    loop.run(7.0, 12.0 * way)
    assert loop.watch.fault.kind == 'following_error'
    wrong = Loop()
    wrong.jammed, wrong.speed = True, 0.0
    for i in range(800):
        wrong.step(12.0 * way, noise=-way * 0.012 * i)
    assert wrong.watch.fault.kind == 'following_error'


def test_a_bumpless_start_gives_that_command_through_the_dead_band():
    for first in (-7.0, -1.2, -0.4, 0.0, 0.4, 1.02, 7.0):
        law = PiController(0.02, 0.45, STEP, LIMITS, dead_band=BAND)
        law.reset(first)
        assert law.update(5.0, 3.0) == pytest.approx(first, abs=1e-12)
    assert PiController(0.02, 0.45, STEP, LIMITS).command == 0.0
    assert PiController(0.02, 0.45, STEP, (2.0, 10.0)).command == 2.0


@pytest.mark.parametrize('dead_band', [-0.1, 10.0, math.nan])
def test_a_dead_band_that_makes_no_sense_is_refused(dead_band):
    with pytest.raises(ValueError, match='dead_band'):
        PiController(0.02, 0.45, STEP, LIMITS, dead_band=dead_band)


def test_the_limits_are_reached_and_nothing_winds_up():
    law = PiController(0.02, 0.45, STEP, LIMITS, dead_band=BAND)
    for _ in range(2000):
        command = law.update(-30.0, 0.0)
    assert command == -10.0
    # Of the 9 V within the band 0.1 V is the proportional part.
    assert law.update(0.0, -5.0) > -10.0


def test_the_feed_forward_is_the_inverse_of_the_table_on_both_sides():
    pump_speed, motor = 188.5, 160e-6 / (2.0 * math.pi)
    feed = PumpFeedForward(COMMAND, DISPLACEMENT, pump_speed, motor)
    for speed in (-60.0, -20.0, -0.5, 0.5, 20.0, 60.0):
        flow = pump_speed * np.interp(feed(speed), COMMAND, DISPLACEMENT)
        assert flow / motor == pytest.approx(speed, rel=1e-12)
        assert feed(-speed) == -feed(speed) and abs(feed(speed)) > BAND
    assert feed(0.0) == 0.0 and (feed(1e3), feed(-1e3)) == (10.0, -10.0)
    one_way = PumpFeedForward(COMMAND[2:], DISPLACEMENT[2:], pump_speed, motor)
    assert one_way(-5.0) == 0.0 and one_way(20.0) == feed(20.0)
