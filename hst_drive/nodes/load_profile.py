# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The test harness as a node: set point, load and oil temperature as a scenario wants them."""
from __future__ import annotations

import sys
import time

from hst_drive.bag.topics import TOPICS
from hst_drive.load import load_scenario, shipped_scenarios
from hst_drive.nodes import sync
from hst_drive.nodes.base import DriveNode, main as run_node
from hst_drive.nodes.endpoints import BILLION, qos_profile
from hst_drive.nodes.parameters import Parameter, YAML_FILE
from hst_drive.nodes.recordings import read_recording
from hst_drive.nodes.settings import rig_of
from hst_drive.nodes.sync import SLOW
from rosgraph_msgs.msg import Clock


class LoadProfile(DriveNode):
    """
    Plays a scenario.

    In lockstep it answers every step of ``/clock``. In real time it begins when the plant says
    so, or at once if it has no partners, and goes on at its own rate.
    """

    role = 'load_profile'
    parameters = (
        Parameter('scenario', 'paper_step', 'name of a shipped scenario, or a file',
                  form=f'one of: {", ".join(shipped_scenarios())}; or the path of a YAML file'),
        Parameter('log', '', 'drilling log, or recording, whose load is drilled; empty: the one '
                  'that the scenario names', form='path of a CSV file or a bag'),
        Parameter('channels', '', 'channel map of the recording; empty: none, or the one that '
                  'the scenario names', form=YAML_FILE),
        Parameter('rig', '', 'rig file; empty: the shipped test rig', form=YAML_FILE),
        Parameter('rate', 100.0, 'messages per second in real time', 'Hz', 1.0, 1000.0),
    )

    def configure(self) -> None:
        """Load the scenario."""
        settings = self.settings
        rig = rig_of(settings)
        self._scenario = scenario = load_scenario(
            settings['scenario'], rig, settings['log'] or None, settings['channels'] or None,
            read_recording)
        # The load's command, and its topic: of the loading unit, or a torque.
        self._load = (('pprv_command', scenario.load.pprv_command) if rig.loading else
                      ('load_torque_command', scenario.load.torque))
        self._start: int | None = None
        self._plan: tuple[int, int] | None = None   # lockstep: ns between steps, and how many
        self._count = 0
        self._timer = None

    def activate(self) -> None:
        """Open the endpoints."""
        self.publish_to(self._load[0], 'speed_setpoint', 'oil_temperature_command',
                        'manual_pump_command')
        if self.lockstep and not self.settings['lookahead']:
            topic = TOPICS['/clock']
            self.create_subscription(
                Clock, topic.name, self._clocked, qos_profile(topic.qos, 2 * sync.INTERVAL))
        super().activate()

    def started(self) -> None:
        """Begin at once when there is nobody to wait for."""
        if not self.partners:
            self._begin(self.now())

    def said(self, name: str, word: str, stamp: int, counts: dict[str, int]) -> None:
        """Begin when the plant does."""
        super().said(name, word, stamp, counts)
        if word == sync.START and self._start is None:
            self._begin(stamp)
            self._plan = (counts['period'], counts['steps']) if self.lockstep else None
        # A question of before the start is that of a plant of another run.
        if self._plan and self.settings['lookahead'] and word in (sync.START, sync.ASK):
            self._play_ahead(stamp)
        elif word == sync.LAST and self._timer is not None:
            self._timer.cancel()

    def _begin(self, stamp: int) -> None:
        self._start = stamp
        if not self.lockstep:
            self._play(stamp)
            # How far the scenario is must not hang on a clock that can be set.
            began = time.monotonic()
            self._timer = self.create_timer(
                1.0 / self.settings['rate'],
                lambda: self._play(self.now(), time.monotonic() - began), clock=self.wall)

    def _clocked(self, message: Clock) -> None:
        stamp = message.clock.sec * BILLION + message.clock.nanosec
        # The clock may overtake the word to start: both mean step 0.
        self._start = sync.SIMULATED_START
        self._play(stamp)
        self.answers.done(stamp)

    def _play_ahead(self, asked: int) -> None:
        period, steps = self._plan
        end = (asked - self._start) // period + sync.LOOKAHEAD
        for step in range(self._count, min(end, steps) if steps else end):
            stamp = self._start + step * period
            self._play(stamp)
            self.answers.done(stamp)

    def _play(self, stamp: int, t: float | None = None) -> None:
        scenario = self._scenario
        t = (stamp - self._start) / BILLION if t is None else t
        out = self.outputs
        self._count += 1
        if self._count % SLOW == 1:
            out['oil_temperature_command'].publish(stamp, scenario.oil_temperature(t))
        out[self._load[0]].publish(stamp, self._load[1](t))
        out['speed_setpoint'].publish(stamp, scenario.speed_setpoint(t))
        if scenario.pump_command is not None:
            out['manual_pump_command'].publish(stamp, scenario.pump_command(t))


def main() -> int:
    """Run the node."""
    return run_node(LoadProfile)


if __name__ == '__main__':
    sys.exit(main())
