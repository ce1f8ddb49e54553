# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A controller's node between its endpoints, on a clock of the test."""
import math
from types import SimpleNamespace

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


def expected(count, error=5.0):
    """Return what kp e + ki e t is in the sample with this number, the first being 0."""
    return KP * error + KI * error * SAMPLE * count
