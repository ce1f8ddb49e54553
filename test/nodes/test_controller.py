# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The controller's node between its endpoints, step by step, on a clock of the test."""
import math
from types import SimpleNamespace

from hst_drive.errors import InputError
import pytest

rclpy = pytest.importorskip('rclpy')
KP, KI, SAMPLE = 0.02, 0.45, 0.01
BILLION = 1_000_000_000


class Sent:
    """In place of a publisher."""

    def __init__(self):
        self.rows, self.names, self.wrong = [], (), ''

    @property
    def published(self):
        return len(self.rows)

    def publish(self, stamp, value):
        self.rows.append((stamp, value))


class Timer:
    """In place of a timer; it comes when the test calls it."""

    def __init__(self, period, callback):
        self.timer_period_ns, self.callback, self.resets = round(period * BILLION), callback, 0

    def reset(self):
        self.resets += 1


class Bench:
    """A controller whose readings, wishes, operator and clock are the test's."""

    def __init__(self, monkeypatch, active=True, lockstep=False, partners=(), **parameters):
        from hst_drive.nodes import controller, controller_status
        bench, self.at = self, 100.0
        clock = SimpleNamespace(monotonic=lambda: self.at, sleep=self.sleep,
                                monotonic_ns=lambda: round(self.at * BILLION))
        monkeypatch.setattr(controller, 'time', clock)
        monkeypatch.setattr(controller_status, 'time', clock)
        self.told, self.done, self.timers, self.publishers = [], [], [], {}
        monkeypatch.setattr(controller_status, 'Diagnostics', lambda node: SimpleNamespace(
            publish=lambda stamp, name, level, message, values: self.told.append(
                {'stamp': stamp, 'level': level, 'message': message, **values})))

        def operator(node, audit, press, reset, start):
            self.press, self.reset, self.start = press, reset, start
            return object()

        monkeypatch.setattr(controller, 'StopInputs', operator)

        class Between(controller.Controller):
            def publish_to(self, *names):
                self.outputs.update({name: Sent() for name in names})

            def listen_to(self, name, callback, joint=''):
                self.inputs[name] = SimpleNamespace(
                    name=name, callback=callback, received=0, refused='',
                    found=lambda: f'{name} (found)')

            def create_timer(self, period, callback, *args, **options):
                bench.timers.append(Timer(period, callback))
                return bench.timers[-1]

            def count_publishers(self, name):
                return bench.publishers.get(name, 1)

            def now(self):
                return round(bench.at * BILLION)

        self.node = Between()
        # Texts come from a message: no two are one object.
        self.node.settings.update({name: ''.join(list(value)) if isinstance(value, str) else value
                                   for name, value in parameters.items()})
        self.node.lockstep, self.node.partners = lockstep, list(partners)
        self.node.configure()
        if active:
            self.node.activate()
            self.node.answers = SimpleNamespace(
                done=self.done.append, asked=lambda stamp: None)
            self.supervise = next((timer for timer in self.timers if
                                   timer.callback == self.node._supervise), None)

    def sleep(self, seconds):
        self.at += seconds

    @property
    def sent(self):
        return self.node.outputs['pump_command'].rows

    @property
    def command(self):
        return self.sent[-1][1]

    def read(self, value, stamp=None):
        entry = self.node.inputs['motor']
        entry.received += 1
        entry.callback(self.node.now() if stamp is None else stamp, (math.nan, value, math.nan))

    def wish(self, value, name='speed_setpoint', stamp=None):
        entry = self.node.inputs[name]
        entry.received += 1
        entry.callback(self.node.now() if stamp is None else stamp, (value,))

    def tick(self, reading=10.0, wish=15.0, name='speed_setpoint', after=SAMPLE):
        """Let a sample time pass; readings differ in the last digits, as those of sensors do."""
        self.at += after
        if wish is not None:
            self.wish(wish, name)
        self.read(reading + 1e-9 * len(self.sent))

    def step(self, number, reading, wish):
        """Give a step of lockstep, the wish first or last in turn."""
        stamp = BILLION + number * round(SAMPLE * BILLION)
        self.at += 0.5      # what the clock on the wall says is nothing to it
        same = int(str(stamp))      # another object, as from another message
        first, last = (lambda: self.wish(wish, stamp=same)), (lambda: self.read(reading, stamp))
        for give in (first, last) if number % 2 else (last, first):
            give()
        return stamp

    def close(self):
        self.node.destroy_node()


@pytest.fixture(scope='module', autouse=True)
def context():
    rclpy.init()
    yield
    rclpy.shutdown()


@pytest.fixture
def bench(monkeypatch):
    made = []

    def make(**parameters):
        made.append(Bench(monkeypatch, **parameters))
        return made[-1]

    yield make
    for entry in made:
        entry.close()


def expected(count, error=5.0):
    """Return what kp e + ki e t is in the sample with this number, the first being 0."""
    return KP * error + KI * error * SAMPLE * count


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
