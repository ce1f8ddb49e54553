# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The fault that no single reading shows: a healthy drive never has it, a dead one soon."""
import math

from hst_drive.control import PiController, SafetySettings, Supervisor
from hst_drive.model import Drive
from hst_drive.rig import default_rig
from hypothesis import given, settings, strategies as st
import pytest

STEP = 0.01
SPEED = 100.0 * math.pi / 30.0
TIMEOUT = SafetySettings().following_error_timeout
STALL = 10.0    # V at the loading unit: more torque than the relief valve lets the motor have


@pytest.fixture(scope='module')
def drive():
    return Drive(default_rig())


class Loop:
    """Law, supervisor and a machine that may be anything: ``speed(command, time)``."""

    def __init__(self, speed, kp=0.02, ki=0.45, limits=(0.0, 10.0), **what):
        self.watch = Supervisor(SafetySettings(**what), limits)
        self.law = PiController(kp, ki, STEP, limits)
        self.speed, self.now, self.command = speed, 0.0, 0.0

    def run(self, seconds, setpoint=SPEED):
        """Go on until a fault or the end; return when the fault came, or None."""
        for _ in range(round(seconds / STEP)):
            self.now += STEP
            speed = self.speed(self.command, self.now)
            command = self.law.update(setpoint, speed)
            if self.watch.lags(self.now, setpoint, speed, command):
                return self.now
            self.command = command
        return None


class Shaft:
    """The whole drive with a load as it is set; called with a command, it gives the speed."""

    def __init__(self, drive, pprv=3.0):
        self.drive, self.state, self.pprv = drive, drive.initial_state(), pprv

    def __call__(self, command, time):
        self.state = self.drive.advance(self.state, STEP, pump_command=command,
                                        pprv_command=self.pprv, oil_temperature=323.15)
        return float(self.state[2])


@pytest.mark.parametrize('setpoint, slower', [
    *((setpoint, slower) for setpoint in (0.5, 3.2, 6.1, SPEED, 21.0, 29.0)
      for slower in (1.0, 2.0)), (SPEED, 10.0), (21.0, 10.0)])
@pytest.mark.parametrize('pprv', [1.0, 6.0])
def test_no_start_of_a_healthy_drive_is_a_fault(drive, setpoint, pprv, slower):
    """Also not with slower gains, nor where the set point is beyond what the drive can do."""
    loop = Loop(Shaft(drive, pprv), kp=0.02 / slower, ki=0.45 / slower)
    assert loop.run(30.0, setpoint) is None
    assert loop.run(10.0, 0.0) is None, 'nor its way to standstill'


def test_a_short_stall_passes_and_a_lasting_one_is_a_fault(drive):
    shaft = Shaft(drive)
    loop = Loop(shaft)
    assert loop.run(10.0) is None
    for _ in range(3):
        shaft.pprv = STALL
        assert loop.run(0.8 * TIMEOUT) is None
        assert shaft.state[2] < 0.1 * SPEED and loop.command == 10.0, 'it does stall'
        shaft.pprv = 3.0
        assert loop.run(5.0) is None
    shaft.pprv, began = STALL, loop.now
    assert TIMEOUT < loop.run(3.0 * TIMEOUT) - began < 1.5 * TIMEOUT
    assert loop.watch.fault.kind == 'following_error'


@pytest.mark.parametrize('speed', [
    lambda command, time: 0.0,                                      # never turns
    lambda command, time: 0.05 * math.sin(40.0 * time),             # nor does its noise
    lambda command, time: 4.0 + 0.2 * math.sin(3.0 * time),         # another shaft
    lambda command, time: -5.0,                                     # is driven backwards
    lambda command, time: 17.0,                                     # runs away at 0 V
    lambda command, time: -2.0 * command,                           # a wrong sign
])
@pytest.mark.parametrize('gains', [(0.02, 0.45), (0.0, 0.05), (0.5, 5.0)])
def test_a_shaft_that_does_not_follow_is_one_in_its_time(speed, gains):
    loop = Loop(speed, *gains)
    tripped = loop.run(3.0 * TIMEOUT)
    assert tripped and TIMEOUT < tripped < 1.5 * TIMEOUT
    assert loop.watch.fault.kind == 'following_error'
    assert f'{SPEED:.4g} rad/s is set' in loop.watch.fault.found
    # The command that would have told of the fault is not sent.
    assert loop.command <= 10.0


def test_set_points_that_come_and_go_do_not_hide_a_dead_motor():
    loop = Loop(lambda command, time: 0.0)
    found = None
    while not found and loop.now < 4.0 * TIMEOUT:
        found = loop.run(1.0, 12.0) or loop.run(1.0, 9.0)
    assert found < 2.0 * TIMEOUT


def test_what_is_no_fault():
    # A proportional law leaves an error, but its command rests.
    assert Loop(lambda command, time: 5.0 * command, ki=0.0).run(10.0 * TIMEOUT) is None
    # Apart, but by less than what counts; and where it is not judged.
    assert Loop(lambda command, time: SPEED - 2.9).run(10.0 * TIMEOUT) is None
    assert Loop(lambda command, time: 0.0, following_error_timeout=0.0).run(100.0) is None
    # Readings that are passed over neither count nor forgive.
    loop = Loop(lambda command, time: math.nan if round(time / STEP) % 7 == 3 else 0.0)
    assert loop.run(1.5 * TIMEOUT)
    # A reset begins anew.
    loop = Loop(lambda command, time: 0.0, start_after_reset=False)
    loop.run(0.9 * TIMEOUT)
    loop.watch.wish(loop.now, -1.0)
    loop.watch.wish(loop.now, 1.0)
    assert loop.watch.reset(loop.now) == []
    assert loop.run(0.9 * TIMEOUT) is None and loop.run(TIMEOUT)


@settings(max_examples=50, deadline=None)
@given(st.floats(0.5, 20.0), st.floats(0.3, 30.0), st.floats(0.05, 3.0), st.floats(0.05, 2.0))
def test_no_drive_that_comes_to_its_set_point_is_one(limit, setpoint, gain, lag):
    """Drives of all kinds: first order, rad/s per volt and s; limits that they can reach."""
    speed = 0.0

    def turn(command, time):
        nonlocal speed
        speed += (gain * setpoint / 5.0 * command - speed) * STEP / lag
        return speed

    loop = Loop(turn, following_error_limit=limit, ki=0.45 * 2.0 / setpoint,
                kp=0.02 * 2.0 / setpoint)
    loop.run(60.0, setpoint)
    if abs(speed - setpoint) < 0.1 * setpoint:
        assert loop.watch.fault is None
