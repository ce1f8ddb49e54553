# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The controller's node step by step: readings, wishes, starts."""
import math
from test.nodes.controller_bench import BILLION, expected, KI, KP, SAMPLE

import pytest


def test_each_reading_is_answered_and_one_command_is_formed_per_sample_time(bench):
    drive = bench()
    drive.read(10.0)
    assert drive.sent == [(drive.node.now(), 0.0)], 'the smallest command until a wish comes'
    drive.wish(15.0)
    for count in range(5):
        drive.at += SAMPLE
        drive.read(10.0 + 1e-9 * count)
        assert drive.command == pytest.approx(expected(count), rel=1e-6)
        assert drive.sent[-1][0] == drive.node.now()
        drive.at += 0.4 * SAMPLE        # too early for a new one
        drive.read(10.0 + 1e-9 * count + 1e-10)
        assert drive.sent[-1][1] == drive.sent[-2][1] and len(drive.sent) == 3 + 2 * count
        drive.at -= 0.4 * SAMPLE


def test_without_a_new_reading_the_timer_goes_on_until_it_is_lost(bench):
    drive = bench(feedback_timeout=0.05, stop_time=1.0)
    assert drive.supervise.timer_period_ns == round(SAMPLE * BILLION)
    drive.supervise.callback()
    assert drive.sent == [], 'nothing is sent before there is a reading'
    drive.wish(15.0)
    drive.tick()
    drive.tick()
    assert drive.supervise.resets == 0, 'a reading sets no timer anew'
    drive.supervise.callback()
    assert drive.supervise.timer_period_ns == round(1.25 * SAMPLE * BILLION), 'it puts it off'
    assert len(drive.sent) == 2
    for count in (2, 3, 4, 5):
        drive.at += SAMPLE if count > 2 else 1.25 * SAMPLE
        drive.wish(15.0)
        drive.supervise.callback()
        assert drive.command == pytest.approx(expected(count + 0.25), rel=1e-6)
        assert drive.supervise.timer_period_ns == round(SAMPLE * BILLION)
        assert drive.supervise.resets == 2, 'set once, then it keeps its own time'
    before = drive.command
    drive.at += 0.011
    drive.supervise.callback()
    assert drive.node._watch.fault.kind == 'feedback_lost'
    assert drive.told[-1]['level'] == 2 and drive.told[-1]['state'] == 'stopping'
    assert drive.told[-1]['at_zero'] == 'false'
    drive.at += 0.01
    drive.supervise.callback()
    assert drive.command == pytest.approx(before - 10.0 * 0.01, abs=1e-9)
    resets = drive.supervise.resets
    drive.read(10.0)
    assert drive.supervise.resets == resets, 'on the ramp readings put nothing off'


def test_a_bad_reading_is_passed_over_and_the_command_holds(bench):
    drive = bench()
    for _ in range(3):
        drive.tick()
    held = drive.command
    drive.tick(reading=math.nan)
    assert drive.command == held and drive.node._watch.fault is None
    drive.tick()
    assert drive.command > held
    drive.node.inputs['motor'].refused = 'two joints'
    for _ in range(4):
        drive.tick()
    assert drive.node._watch.fault.kind == 'feedback_joint'
    assert drive.node._watch.fault.found == 'two joints'


def test_stamps_are_compared_with_the_nodes_clock(bench):
    drive = bench(stamp_tolerance=1.0)
    for count in range(3):
        drive.at += SAMPLE
        drive.read(10.0 + count, drive.node.now() - 2 * BILLION)
    assert drive.node._watch.fault.kind == 'feedback_time'
    assert drive.node._watch.fault.found == '2 s old'


def test_a_wish_that_is_wrong_is_not_taken(bench):
    drive = bench()
    drive.tick()
    drive.wish(math.nan)
    assert drive.node._watch.fault.kind == 'setpoint_invalid' and drive.node._setpoint == 15.0


@pytest.mark.parametrize('mode, wanted, other', [
    ('closed_loop', 'speed_setpoint', 'manual_pump_command'),
    ('open_loop', 'manual_pump_command', 'speed_setpoint')])
def test_the_wishes_of_the_other_mode_are_not_heard(bench, mode, wanted, other):
    drive = bench(mode=mode)
    for _ in range(3):
        drive.tick(wish=4.0, name=other)
    assert {value for _, value in drive.sent} == {0.0}
    assert drive.node._watch.missing == (False, True)
    drive.tick(reading=2.0, wish=4.0, name=wanted)
    assert drive.command == (4.0 if mode == 'open_loop' else pytest.approx(KP * 2.0, rel=1e-6))


def test_by_hand_whatever_the_speed_is_follows_nothing(bench):
    drive = bench(mode='open_loop', following_error_timeout=0.1)
    for _ in range(50):
        drive.tick(reading=0.0, wish=10.0, name='manual_pump_command')
    assert drive.node._watch.fault is None and drive.command == 10.0
    drive.tick(wish=-0.1, name='manual_pump_command')
    assert drive.node._watch.fault.kind == 'command_invalid'


def test_in_closed_loop_a_speed_that_does_not_follow_stops_the_drive(bench):
    drive = bench(following_error_timeout=0.1)
    for _ in range(50):
        drive.tick(reading=0.0)
        if drive.node._watch.fault:
            break
    assert drive.node._watch.fault.kind == 'following_error'
    held = drive.command
    drive.tick()
    assert drive.command <= held


@pytest.mark.parametrize('start, first', [(3.0, 3.0), (0.0, 0.0), (-1.0, KP * 5.0)])
def test_a_start_command_is_the_first_one(bench, start, first):
    drive = bench(start_command=start)
    drive.wish(15.0)
    drive.tick()
    assert drive.command == pytest.approx(first)
    drive.tick()
    assert drive.command == pytest.approx(first + KI * 5.0 * SAMPLE)


def test_a_start_command_that_was_not_sent_is_no_beginning_of_a_ramp(bench):
    drive = bench(start_command=3.0)
    drive.press('topic', True)
    drive.supervise.callback()
    assert drive.command == 0.0


def test_a_reset_makes_ready_and_a_start_begins_anew(bench):
    drive = bench(emergency_stop_time=0.1)
    for _ in range(100):
        drive.tick()
    assert drive.command > 2.0
    assert drive.press('service', True) and not drive.press('service', True)
    assert drive.press('service', False)
    assert drive.reset() and drive.node._watch.fault.kind == 'emergency_stop'
    for _ in range(10):
        drive.tick(reading=10.0)
        drive.supervise.callback()
    assert drive.command == 0.0 and drive.told[-1]['state'] == 'stopped'
    assert drive.told[-1]['at_zero'] == 'true'
    assert drive.start() and drive.reset() == []
    for _ in range(3):
        drive.tick()
        assert drive.command == 0.0 and drive.node._watch.state == 'ready'
    assert drive.start() == []
    drive.tick()
    assert drive.command == 0.0, 'without a bump: from the command that holds'
    drive.tick()
    assert drive.command == pytest.approx(KI * 5.0 * SAMPLE)


def test_without_the_wait_a_reset_goes_on_from_the_command_on_the_ramp(bench):
    drive = bench(start_after_reset=False, emergency_stop_time=1.0)
    for _ in range(100):
        drive.tick()
    drive.press('topic', True)
    drive.supervise.callback()
    for _ in range(10):
        drive.tick()
        drive.supervise.callback()
    drive.press('topic', False)
    held = drive.command
    drive.at += 0.5 * SAMPLE
    assert drive.reset() == []
    drive.wish(15.0)
    drive.read(10.1)
    assert drive.command == held, 'the next command is the first one, and due at once'
    drive.tick(reading=10.1)
    assert drive.command == pytest.approx(held + KI * 4.9 * SAMPLE)


def test_a_drive_that_waits_for_its_start_sends_zero_until_then(bench):
    drive = bench(wait_for_start=True, u_clamp_min=1.0, start_command=3.0)
    for _ in range(3):
        drive.tick()
    assert {value for _, value in drive.sent} == {0.0} and len(drive.sent) == 3
    drive.node._tell()
    assert drive.told[-1]['message'] == (
        'ready; start it with speed_setpoint back at 0, or ~/start')
    assert drive.told[-1]['level'] == 1
    assert drive.node._audit.last == '' and drive.start() == []
    drive.tick()
    assert drive.command == 1.0
    assert drive.node._audit.last.startswith('the drive starts; speed_setpoint is 15 ')


def test_a_stop_outlives_an_activation(bench):
    drive = bench()
    drive.tick()
    drive.press('topic', True)
    drive.node.configure()
    assert drive.node._watch.fault.kind == 'emergency_stop'
    assert drive.node._command == 0.0 and drive.node._reading is drive.node._setpoint is None


def test_gains_change_together_without_a_jump(bench):
    from rclpy.parameter import Parameter
    drive = bench()
    for _ in range(20):
        drive.tick()
    before = drive.command

    def put(**values):
        return drive.node.set_parameters_atomically(
            [Parameter(name, value=value) for name, value in values.items()])

    assert not put(kp=0.05, ki=math.nan).successful
    assert drive.node._law.kp == KP
    assert put(kp=0.05).successful and put(ki=0.9).successful
    assert drive.node.settings['kp'] == 0.05 and drive.node.settings['ki'] == 0.9
    drive.tick()
    # The last step's integral was of the old gain.
    assert drive.command == pytest.approx(before + KI * 5.0 * SAMPLE, rel=1e-6)
    drive.tick()
    assert drive.command == pytest.approx(before + (KI + 0.9) * 5.0 * SAMPLE, rel=1e-6)
    early = bench(active=False)
    assert early.node.set_parameters_atomically([Parameter('kp', value=0.03)]).successful
