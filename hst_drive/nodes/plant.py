# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The drive and its sensors as a node: what a real rig would publish, and its clock."""
from __future__ import annotations

from collections import deque
import math
import sys
import time

from hst_drive.errors import InputError
from hst_drive.model import SensorBank
from hst_drive.nodes import sync, wiring
from hst_drive.nodes.base import DriveNode, main as run_node
from hst_drive.nodes.endpoints import BILLION, ClockOutput, partners_of, topic_named
from hst_drive.nodes.parameters import Parameter, YAML_FILE
from hst_drive.nodes.readings import BURST, Readings
from hst_drive.nodes.settings import effects_in, rig_of
from hst_drive.nodes.simulated import simulated
import numpy as np
from rclpy.duration import Duration

_PROGRESS, _JUMP = 0.5, BILLION // 4   # s between lines of progress; ns: the clock was set
_CATCHES_UP = 50   # steps in a tick: more than the queue holds would overwrite each other


class Plant(DriveNode):
    """Integrates the drive from sample to sample; commands hold between samples."""

    role = 'plant'
    _readings: Readings | None = None
    parameters = (
        Parameter('rig', '', 'rig file; empty: the shipped test rig', form=YAML_FILE),
        Parameter('effects', [], 'hidden effects',
                  form='id.parameter=value (SI), id.parameter=value[unit] or id, as hst-drive '
                  'effects lists them'),
        Parameter('effects_from', 0.0, 'time of the run from which on the hidden effects act',
                  's', 0.0, 1e7),
        Parameter('seed', 1, "seed of the sensors' noise", low=0, high=2**31 - 1),
        Parameter('start_speed', 0.0, 'start steadily at this speed; 0: start at rest', 'rad/s',
                  0.0, 100.0),
        Parameter('start_pprv_command', 0.0, 'PPRV command of a steady start', 'V', 0.0, 10.0),
        Parameter('rate', 100.0, 'samples per second', 'Hz', 1.0, 1000.0),
        Parameter('duration', 0.0, 'length of the run; 0: without end', 's', 0.0, 1e7),
        Parameter('speed', 0.0, 'in lockstep: simulated per real second; 0: as fast as it goes',
                  '1', 0.0, 1e4),
        Parameter('partner_timeout', 30.0, 'in lockstep: how long to wait for a partner', 's',
                  0.1, 600.0),
        Parameter('extra_topics', [], 'readings that are off by default and shall be published',
                  choices=wiring.SENSORS),
        Parameter('truth', False, 'publish the values without noise under truth/ as well'),
        Parameter('progress', False, 'tell the progress on standard output'),
    )

    def configure(self) -> None:
        """Build drive and sensors."""
        settings = self.settings
        rig = rig_of(settings)
        effects, late = effects_in(rig, settings['effects']), settings['effects_from'] > 0.0
        self._drive = simulated(rig, None if late else effects)
        self._later = simulated(rig, effects) if late else None
        self._names = wiring.readings(settings['extra_topics'], settings['circuit'])
        # There are usual sensors for the open circuit; others have those that the rig states.
        self._sensors = SensorBank(rig, settings['seed'], [
            field.channel for name in self._names for field in topic_named(name).fields
            if field.channel] if rig.whole else ())
        self._state = self._drive.start(settings['start_speed'], settings['start_pprv_command'])
        self.taken = wiring.recorded(self.partners, settings['extra_topics'], settings['truth'],
                                     settings['circuit'])
        self._period = round(BILLION / settings['rate'])
        self._steps = (max(round(settings['duration'] * BILLION / self._period), 1)
                       if settings['duration'] else None)
        self._takes = self._drive.takes     # input of the drive by topic
        self._inputs = {**dict.fromkeys(self._takes.values(), 0.0),
                        'oil_temperature': rig.characterised_at}
        if self.lockstep and not {'controller', 'load_profile'} & set(self.partners):
            raise InputError('plant: parameter lockstep needs controller or load_profile among '
                             'the partners')
        self._pending: set[str] = set()
        self._early: dict[tuple[str, int], float] = {}
        self._unready, self._unanswered = {*self.partners} - {self.role}, set()
        self._step = self._asked = -1
        self._finishing = self._running = False
        self._times = np.array([0.0, self._period / BILLION])
        self._late: deque[float] = deque(maxlen=10_000)   # s behind the grid, in real time
        # Compiled code is loaded when it is first called: now, not in the first sample.
        self._drive.simulate(self._times, {name: np.full(2, value) for name, value in
                                           self._inputs.items()}, self._state.copy())

    def activate(self) -> None:
        """Open the endpoints."""
        settings = self.settings
        self._readings = Readings(
            self, self._names, self._sensors, settings['truth'],
            BURST if self.lockstep and settings['lookahead'] else 1)
        self._awaited = [name for name in self._takes
                         if topic_named(name).publisher in self.partners]
        for name in self._takes:
            self.listen_to(name, lambda stamp, values, name=name:
                           self._commanded(name, stamp, values[0]))
        if self.lockstep:
            self._clock_output = ClockOutput(self, 2 * sync.INTERVAL)
        super().activate()
        self._heard, self._ready = time.monotonic(), False
        self.create_timer(0.25, self._watch, clock=self.wall)

    def deactivate(self) -> None:
        """Publish what was kept for a burst."""
        if self._readings:
            self._readings.send()

    def not_connected(self) -> list[str]:
        """Return the topics on which a partner is missing; load_profile reads the clock."""
        missing = super().not_connected()
        reads_clock = 'load_profile' in self.partners and not self.settings['lookahead']
        if (self.lockstep and reads_clock
                and partners_of(self, self._clock_output.publisher) < 1):
            missing.append('/clock')
        return missing

    def started(self) -> None:
        """Begin when all partners are ready."""
        self._ready = True
        self._ready_timer.cancel()
        self._begin()

    def said(self, name: str, word: str, stamp: int, counts: dict[str, int]) -> None:
        """Take a partner's word that it is ready or through with a step."""
        self._heard = time.monotonic()
        if word == sync.READY:
            self._unready.discard(name)
            self._begin()
        elif word == sync.DONE and stamp == self._asked:
            self._unanswered.discard(name)
            if self._finishing and not self._unanswered:
                self._finish()
            elif self._running and not self._pending:
                self._next_step()

    def _begin(self) -> None:
        if self._running or self._unready or not self._ready:
            return
        self._running = True
        self._began = self._told = time.monotonic()
        if self.lockstep:
            self._start = sync.SIMULATED_START
            counts = {'period': self._period, 'steps': self._steps or 0}
            self.sync.say(sync.START, self._start, counts)
            self._next_step()
        else:
            self._start, self._began = self.now(), time.monotonic()
            self.create_timer(self._period / BILLION, self._tick, clock=self.wall)
            self.sync.say(sync.START, self._start)
            self._tick()

    def _stamp(self) -> int:
        return self._start + self._step * self._period

    def _commanded(self, name: str, stamp: int, value: float) -> None:
        if not self.lockstep:
            self._set(name, value)
            return
        self._heard = time.monotonic()
        if name not in self._pending or stamp != self._stamp():
            self._early[name, stamp] = value
            return
        self._set(name, value)
        self._pending.discard(name)
        if name == 'pump_command':
            self._next_step()
        elif self._pending <= {'pump_command'}:
            self._sample()

    def _set(self, name: str, value: float) -> None:
        if not math.isfinite(value):
            self.get_logger().warning(f'{name} is {value}: {self._inputs[self._takes[name]]:g} '
                                      'is held', throttle_duration_sec=5.0)
            return
        self._inputs[self._takes[name]] = value

    def _next_step(self) -> None:
        """Go one step on in lockstep, unless a partner is too far behind."""
        due = self._step >= 0 and (self._step + 1) % sync.INTERVAL == 0
        if self._finishing or self._pending or (due and self._unanswered):
            return
        if self._steps is not None and self._step + 1 >= self._steps:
            self._finishing = True
            self._ask(sync.LAST)
            return
        if due:
            self._ask(sync.ASK)
        self._step += 1
        self._pace()
        stamp = self._stamp()
        self._held = dict(self._inputs)
        self._pending = set(self._awaited)
        if self._step % sync.SLOW:
            self._pending.discard('oil_temperature_command')
        self._clock_output.publish(stamp)
        for name in self._awaited:
            if name in self._pending and (name, stamp) in self._early:
                self._set(name, self._early.pop((name, stamp)))
                self._pending.discard(name)
        if self._pending <= {'pump_command'}:
            self._sample()

    def _ask(self, word: str) -> None:
        self._unanswered = {name for name in self.partners if name != self.role}
        self._readings.send()
        self._asked = self._stamp()
        self.sync.say(word, self._asked, self.answers.counts())
        if word == sync.LAST and not self._unanswered:
            self._finish()

    def _sample(self) -> None:
        """Move the drive to this step and publish the readings; a controller answers them."""
        self._measure()
        if not self._pending:
            self._next_step()

    def _measure(self) -> None:
        """Integrate the last interval with the commands held in it; read the sensors."""
        first = self._step == 0
        if self._later and self._step * self._period > self.settings['effects_from'] * BILLION:
            self._drive, self._later = self._later, None
        state, held = (self._state.copy(), self._inputs) if first else (self._state, self._held)
        inputs = {name: np.array([held[name], value]) for name, value in self._inputs.items()}
        # The commands of this step act from now on; the readings are taken just before.
        result = self._drive.simulate(self._times, inputs, state)
        truth = {name: float(values[0 if first else 1]) for name, values in result.items()}
        if not math.isfinite(sum(truth[name] for name in self._drive.bounded)):
            self._readings.send()
            self.stop(1, f'the drive left all bounds at step {self._step}')
            return
        truth['oil_temperature'] = self._inputs['oil_temperature']
        readings = {**truth, **self._sensors.read(truth)}
        for values in (truth, readings):    # on a closed circuit nothing lies between the two
            values.setdefault('load_torque', values['motor_torque'])
        self._readings.publish(self._stamp(), readings, truth)
        self._tell()

    def _tick(self) -> None:
        """Take the samples that are due in real time; a late tick catches up."""
        # The pace is that of a clock that cannot be set; the stamps follow one that can.
        passed = round((time.monotonic() - self._began) * BILLION)
        if abs(jump := self.now() - self._start - passed) > _JUMP:
            self._start += jump
            self.get_logger().warning(f'the clock was set by {jump / BILLION:+.3g} s')
        due = min(passed // self._period, self._step + _CATCHES_UP)
        while self._step < due and self.exit_code is None:
            self._step += 1
            self._late.append((passed - self._step * self._period) / BILLION)
            self._held = dict(self._inputs)
            self._measure()
            if self._steps is not None and self._step + 1 >= self._steps:
                self._finish()

    def _finish(self) -> None:
        if not self.lockstep:
            self.sync.say(sync.LAST, self._stamp())
            # Else the word goes down with this process, a fault to the others.
            self.sync.publisher.wait_for_all_acked(Duration(seconds=1.0))
            if self.settings['progress']:
                print('late', *np.percentile(self._late, (50, 99, 100)).round(6), flush=True)
        self._tell(last=True)
        self.stop(0)

    def _pace(self) -> None:
        factor = self.settings['speed']
        if factor:
            due = self._began + self._step * self._period / BILLION / factor
            time.sleep(max(0.0, due - time.monotonic()))

    def _tell(self, last: bool = False) -> None:
        now = time.monotonic()
        if self.settings['progress'] and (last or now - self._told >= _PROGRESS):
            self._told, seconds = now, (self._step + 1) * self._period / BILLION
            print(f'progress {seconds:.2f} {now - self._began:.3f}{" end" * last}', flush=True)

    def _watch(self) -> None:
        """In lockstep, give up when a partner does not answer, and say which."""
        if not (self.partners and (self.lockstep or not self._running)):
            return
        if time.monotonic() - self._heard < self.settings['partner_timeout']:
            return
        silent = self._unready | self._unanswered
        silent |= {self.inputs[name].topic.publisher for name in self._pending}
        where = f'at step {self._step}' if self._running else 'before the start'
        missing = '' if self._running else f' (not connected: {", ".join(self.not_connected())})'
        self.stop(1, f'no answer from {", ".join(sorted(silent)) or "itself"} {where} within '
                  f'{self.settings["partner_timeout"]:g} s{missing}')


def main() -> int:
    """Run the node."""
    return run_node(Plant)


if __name__ == '__main__':
    sys.exit(main())
