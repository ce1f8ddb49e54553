# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The controller's node step by step: lockstep, its end, what it tells, both directions."""
import math
from test.nodes.controller_bench import BILLION, KI, KP, SAMPLE

from hst_drive.errors import InputError
import pytest


def test_in_lockstep_commands_carry_the_steps_stamp_and_each_step_is_done(bench):
    drive = bench(lockstep=True, partners=('plant', 'controller'))
    assert drive.supervise is None
    stamps = [drive.step(count, 10.0 - count, 15.0) for count in range(6)]
    assert [stamp for stamp, _ in drive.sent] == drive.done == stamps
    for count, (_, value) in enumerate(drive.sent):
        before = sum(5.0 + earlier for earlier in range(count))
        assert value == pytest.approx(KP * (5.0 + count) + KI * SAMPLE * before)
    assert drive.node._setpoints == {}
    assert drive.node._audit.last == '', 'a simulated run logs neither start nor end'


def test_in_lockstep_wishes_may_come_ahead(bench):
    drive = bench(lockstep=True, partners=('plant', 'controller'))
    stamps = [BILLION + count * round(SAMPLE * BILLION) for count in range(4)]
    drive.read(10.0, stamps[0])
    for count, stamp in enumerate(stamps):
        drive.wish(11.0 + count, stamp=stamp)
    for count, stamp in enumerate(stamps[1:], 1):
        assert len(drive.sent) == count
        drive.read(10.0, stamp)
    assert [stamp for stamp, _ in drive.sent] == stamps
    # Errors of 1, 2, 3 and 4 rad/s.
    assert drive.command == pytest.approx(KP * 4.0 + KI * SAMPLE * 6.0)


def test_in_lockstep_a_stop_falls_by_the_time_of_the_steps(bench):
    drive = bench(lockstep=True, partners=('plant', 'controller'), emergency_stop_time=1.0)
    for count in range(100):
        drive.step(count, 10.0, 15.0)
    before = drive.command
    drive.press('topic', True)
    for count in range(100, 105):
        stamp = drive.step(count, 10.0, 15.0)
        assert drive.sent[-1] == (stamp, pytest.approx(before - 10.0 * SAMPLE * (count - 99)))
    assert drive.done[-1] == stamp and len(drive.done) == 105
    assert drive.told[-1]['stamp'] <= stamp
    sent = len(drive.sent)
    drive.node.deactivate()
    assert len(drive.sent) == sent, 'the plant ends at the same time'


def test_the_end_brings_it_to_zero_as_an_emergency_stop_does(bench):
    drive = bench(emergency_stop_time=0.2, sample_time=0.05)
    for _ in range(40):
        drive.tick(after=0.05)
    before, count, at = drive.command, len(drive.sent), drive.at
    assert before > 2.0
    drive.node.deactivate()
    ramp = [value for _, value in drive.sent[count:]]
    assert ramp[-1] == 0.0 and ramp == sorted(ramp, reverse=True)
    # 10 V in 0.2 s, every 0.02 s at least.
    assert len(ramp) == pytest.approx(before / 10.0 * 0.2 / 0.02, abs=2)
    assert drive.at - at == pytest.approx(before / 10.0 * 0.2, abs=0.05)
    assert drive.told[-1]['fault'] == 'shutdown' and drive.told[-1]['level'] == 1
    assert drive.node._audit.last.startswith('the drive ends; it was running, at ')
    count = len(drive.sent)
    drive.node.deactivate()
    assert len(drive.sent) == count


def test_an_end_before_or_at_rest_sends_nothing(bench):
    drive = bench(active=False)
    drive.node.deactivate()
    assert drive.node._audit.last == ''
    drive = bench()
    drive.node.deactivate()
    assert drive.sent == [] and drive.node._audit.last.endswith('it was waiting, at 0 V')
    drive = bench(partners=('plant', 'controller'))
    for _ in range(20):
        drive.tick()
    count = len(drive.sent)
    drive.node.deactivate()
    assert len(drive.sent) == count and drive.node._audit.last == ''


def test_after_the_plants_last_word_nothing_is_missing(bench):
    from hst_drive.nodes import sync
    drive = bench(partners=('plant', 'controller'), feedback_timeout=0.05)
    drive.tick()
    for word in (sync.READY, sync.START, sync.ASK, sync.DONE):
        drive.node.said('plant', word, 0, {})
        assert not drive.node._ended
    for word in (sync.LAST, sync.DONE):
        # Another object, as from a message.
        drive.node.said('plant', ''.join(list(word)), 0, {})
        assert drive.node._ended
    count = len(drive.sent)
    drive.at += 1.0
    drive.supervise.callback()
    assert drive.node._watch.fault is None and len(drive.sent) == count


def test_it_says_once_a_second_how_often_messages_come(bench):
    drive = bench()
    look = next(timer for timer in drive.timers if timer.callback == drive.node._look)
    assert look.timer_period_ns == BILLION
    assert drive.told == []
    drive.read(math.nan)
    look.callback()
    assert drive.told[-1]['stamp'] == drive.node.now() and drive.told[-1]['against_reset'] == ''
    assert drive.told[-1]['message'] == 'waiting for motor (found), speed_setpoint (found)'
    assert drive.told[-1]['level'] == 1 and drive.told[-1]['state'] == 'waiting'
    for _ in range(2):
        for _ in range(50):
            drive.tick(after=0.02)
        look.callback()
    assert drive.told[-1]['message'] == (
        'running; motor comes 50 times a second, sample_time asks for 100')
    assert drive.told[-1]['level'] == 1 and drive.told[-1]['motor_rate_hz'] == '50'
    for _ in range(100):
        drive.tick()
    look.callback()
    assert drive.told[-1]['message'] == 'running' and drive.told[-1]['level'] == 0
    assert float(drive.told[-1]['command_v']) == pytest.approx(drive.command, rel=1e-3)


@pytest.mark.parametrize('state, wish', [('waiting', None), ('ready', 15.0)])
def test_a_slow_sensor_is_told_of_a_drive_that_runs_only(bench, state, wish):
    drive = bench(wait_for_start=True)
    drive.read(10.0)
    for _ in range(3):
        for _ in range(50):
            drive.tick(after=0.02, wish=wish)
        drive.node._look()
    assert drive.told[-1]['state'] == state and 'times a second' not in drive.told[-1]['message']
    assert drive.told[-1]['motor_rate_hz'] == '50'


def test_who_else_commands_or_wishes_is_told_but_not_in_lockstep(bench):
    for lockstep in (False, True):
        drive = bench(lockstep=lockstep, partners=('plant',) * lockstep)
        drive.node.outputs['pump_command'].names = ('/pump', '/forward/commands')
        for count in range(3):
            drive.step(count, 10.0, 15.0) if lockstep else drive.tick()
        drive.publishers = {'/forward/commands': 2, 'speed_setpoint': 3}
        drive.node._tell()
        said = 'running' + ('' if lockstep else '; 2 nodes publish /forward/commands: only one '
                            'may; 3 nodes publish speed_setpoint: only one may')
        assert drive.told[-1]['message'] == said and drive.told[-1]['level'] == (not lockstep)
        drive.node.outputs['pump_command'].wrong = 'other joints'
        drive.node._tell()
        assert drive.told[-1]['message'] == said + '; other joints'
        assert drive.told[-1]['level'] == 1 and drive.told[-1]['against_reset'] == ''


def test_a_fault_is_an_error_in_the_log_once(bench, capfd):
    drive = bench()
    drive.tick()
    drive.press('topic', True)
    for errors in (1, 0):
        drive.node._tell()
        assert capfd.readouterr().err.count('[ERROR]') == errors
    assert drive.told[-1]['against_reset'].startswith('emergency stop is pressed (topic)')
    assert drive.told[-1]['message'] == (
        'stopping: emergency_stop: emergency stop (by topic); reset it with ~/reset')


def test_settings_that_make_no_sense_are_named(bench):
    with pytest.raises(InputError, match='controller: .*u_clamp'):
        bench(u_clamp_min=5.0, u_clamp_max=5.0)


def test_a_drive_that_turns_either_way_stops_from_backwards_at_zero_stroke(bench):
    drive = bench(u_clamp_min=-10.0, dead_band=1.0, emergency_stop_time=0.1)
    for _ in range(100):
        drive.tick(reading=-10.0, wish=-15.0)
    assert drive.node._watch.fault is None and drive.command < -2.0
    before = drive.command
    drive.press('topic', True)
    stopping = []
    for _ in range(10):
        drive.tick(reading=-10.0, wish=-15.0)
        drive.supervise.callback()
        stopping.append(drive.command)
    assert stopping == sorted(stopping) and before < stopping[0] <= 0.0 == stopping[-1]
    assert drive.told[-1]['state'] == 'stopped' and drive.told[-1]['at_zero'] == 'true'
    drive.press('topic', False)
    assert drive.reset() == []
    drive.tick(reading=-10.0, wish=-15.0)
    drive.node._tell()
    assert drive.told[-1]['message'] == 'ready; start it with speed_setpoint back at 0, or ~/start'
    drive.tick(reading=0.0, wish=0.0)
    assert drive.node._watch.state == 'running'


def test_it_leaves_from_backwards_with_the_pump_at_zero(bench):
    drive = bench(u_clamp_min=-10.0)
    for _ in range(100):
        drive.tick(reading=-10.0, wish=-15.0)
    assert drive.command < -2.0
    drive.node.deactivate()
    assert drive.command == 0.0


@pytest.mark.parametrize('start, first', [(-3.0, -3.0), (-1.0, -1.0), (-100.0, KP * -5.0)])
def test_a_start_command_may_be_backwards_where_commands_are(bench, start, first):
    drive = bench(u_clamp_min=-10.0, start_command=start)
    drive.wish(-15.0)
    drive.tick(reading=-10.0, wish=-15.0)
    assert drive.command == pytest.approx(first)


def test_without_a_wish_a_drive_that_turns_either_way_stands(bench):
    drive = bench(u_clamp_min=-10.0)
    drive.read(0.0)
    assert drive.command == 0.0
