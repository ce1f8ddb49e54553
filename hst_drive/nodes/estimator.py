# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Efficiency and losses of the hydromotor while it runs, and the watch over the drive."""
from __future__ import annotations

import sys

from hst_drive.bag.topics import CHANNEL_FIELDS, TOPICS
from hst_drive.losses.efficiency import Performance
from hst_drive.nodes import verdict, wiring
from hst_drive.nodes.base import DriveNode, GATHER, main as run_node
from hst_drive.nodes.diagnostics import (
    Diagnostics, HARDWARE, OK, PackedOutput, STALE, WARN)
from hst_drive.nodes.mapped import CHANNELS, map_of, MappedInput, search_for
from hst_drive.nodes.parameters import JOINT, Parameter, YAML_FILE
from hst_drive.rig import load_rig
from hst_drive.watch.characteristic import Estimate, Resistances
from hst_drive.watch.drive import Figures, Observer, Settings, Watched
from hst_drive.watch.figures import limits_of
from hst_drive.watch.samples import accuracy_of

_READ = tuple(name for name in wiring.READS['estimator'] if name != 'sync')
_JOINTS = {'motor': 'joint', 'pump': 'pump_joint'}
_RESISTANCES = {'leakage': 'leakage_resistance', 'port': 'port_resistance',
                'external': 'external_leakage_resistance',
                'internal': 'internal_leakage_resistance'}


class Estimator(DriveNode):
    """
    Publishes figures of merit, loss resistances, residuals of the balances, and a verdict.

    Figures carry the time in the middle of the window that they were smoothed over. Where the
    signals say nothing (standstill, no pressure, a sensor that is silent) it publishes no
    figure, and on /diagnostics why.
    """

    role = 'estimator'
    parameters = (
        Parameter('rig', '', "rig file, or a machine's own from commission; empty: the shipped "
                  'test rig', form=YAML_FILE),
        HARDWARE,
        Parameter('joint', '', 'joint of the topic motor that is the hydromotor; empty: the only '
                  'one there is', form=JOINT),
        Parameter('pump_joint', '', 'joint of the topic pump, likewise', form=JOINT),
        CHANNELS,
        Parameter('rate', 10.0, 'estimates per second', 'Hz', 0.1, 100.0),
        Parameter('window', 0.5, 'smoothing of what the loss model leaves', 's', 0.05, 60.0),
        Parameter('timeout', 0.5, 'a signal that is older is missing', 's', 0.01, 60.0),
        Parameter('minimum_speed', 0.0, 'below it no figure is valid; 0: 2.3 % of the speed on '
                  "the pump's full flow", 'rad/s', 0.0, 100.0),
        Parameter('minimum_pressure', 5e5, 'below it no figure is valid', 'Pa', 1e3, 1e8),
        Parameter('pressure_accuracy', 5e4, 'standard uncertainty of the pressure sensor, noise '
                  'apart', 'Pa', 0.0, 1e7),
        Parameter('flow_accuracy', 0.005, 'standard uncertainty of the flow meter, of the reading',
                  '1', 0.0, 0.5),
        Parameter('torque_accuracy', 0.0, 'standard uncertainty of the torque sensor; 0: 0.16 % '
                  "of the torque at the relief valve's pressure", 'N.m', 0.0, 1e4),
        Parameter('extra_topics', [], 'readings that are off by default and come in this run',
                  choices=wiring.SENSORS),
        Parameter('bag', '', 'bag that records this run, for the pointer to it',
                  form='path of a folder'),
    )

    def configure(self) -> None:
        """Build what observes the drive."""
        settings = self.settings
        rig = load_rig(settings['rig'])
        self._map = map_of(self)
        # What a map names comes.
        mapped = [CHANNEL_FIELDS[name][0].name for name in CHANNEL_FIELDS
                  if name in self._map.entries]
        self._extra = (*wiring.asked(settings['extra_topics'], rig.circuit), *mapped)
        self._expected = tuple(name for name in _READ if wiring.comes(
            name, self._extra, rig.circuit))
        self._circuit = rig.circuit
        # Position of a channel among the fields of its topic.
        self._channels = {name: [(place, field.channel) for place, field in
                                 enumerate(TOPICS[name].fields) if field.channel]
                          for name in self._expected}
        signals = tuple(channel for places in self._channels.values() for _, channel in places)
        self._observer = Observer(rig, signals, Settings(
            settings['rate'], settings['window'], settings['timeout'],
            limits=limits_of(rig, settings['minimum_speed'], settings['minimum_pressure']),
            accuracy=accuracy_of(rig, settings['pressure_accuracy'], settings['flow_accuracy'],
                                 settings['torque_accuracy'])))
        self._awaited = {name: 0 for name in self._expected
                         if TOPICS[name].publisher in self.partners}
        self._step = 0
        self._heard = False
        self._failing: tuple[str, ...] = ()
        self.gather = 4 * GATHER if self.lockstep else 0.0

    def activate(self) -> None:
        """Open the endpoints."""
        self.publish_to(*(
            name for name, topic in TOPICS.items() if topic.publisher == self.role and topic.fields
            and wiring.comes(name, self._extra, self._circuit)))
        self.outputs['verdict'] = PackedOutput(self, 'verdict')
        self.outputs['/diagnostics'] = self._diagnostics = Diagnostics(self)
        for name in _READ:
            channels = [field.channel for field in TOPICS[name].fields if field.channel]
            for channel in filter(self._map.entries.__contains__, channels):
                self.inputs[channel] = MappedInput(
                    self, self._map, channel, lambda stamp, value, channel=channel: self._mapped(
                        channel, stamp, value), self.settings['timeout'])
            if not set(channels) <= set(self._map.entries):
                self.listen_to(name, lambda stamp, values, name=name: self._measured(
                    name, stamp, values), _JOINTS.get(name, ''))
        search_for(self)
        super().activate()
        if not self.lockstep:
            self.create_timer(1.0 / self.settings['rate'], self._tick)

    def not_connected(self) -> list[str]:
        """Return the topics on which a partner is missing; of the extra ones, those asked for."""
        return [name for name in super().not_connected()
                if name not in _READ or name in self._expected]

    def _measured(self, topic: str, stamp: int, values: tuple[float, ...]) -> None:
        if topic not in self._channels:
            return
        for place, channel in self._channels[topic]:
            if channel not in self._map.entries:
                self._observer.put(channel, stamp, values[place])
        self._heard = self._heard or not self.inputs[topic].refused
        if self.lockstep:
            self._awaited[topic] = stamp
            reached = min(self._awaited.values())
            if reached > self._step:
                self._step = reached
                self._advance(reached)
                self.answers.done(reached)

    def _mapped(self, channel: str, stamp: int, value: float) -> None:
        self._observer.put(channel, stamp, value)
        self._heard = True

    def _tick(self) -> None:
        """Go on as far as the signals have come in real time; say so when none comes."""
        reached = self._observer.reached()
        if self._heard and reached is not None:
            self._heard = False
            self._advance(reached)
        elif not self._heard:
            self._say(self.now(), 'efficiency', 'no signal comes')

    def _advance(self, stamp: int) -> None:
        found = self._observer.advance(stamp)
        for figures in found.figures:
            self._publish(figures)
        for watched in found.watched:
            self._watch(watched)

    def _publish(self, figures: Figures) -> None:
        if figures.measured is not None:
            for origin, values in (('', figures.measured), ('model_', figures.model)):
                self._figures(figures.stamp, origin, values)
            self.outputs['efficiency_uncertainty'].publish(
                figures.stamp, *figures.uncertainty[:3])
        self._say(figures.stamp, 'efficiency', figures.reason)

    def _figures(self, stamp: int, origin: str, figures: Performance) -> None:
        self.outputs[f'{origin}efficiency'].publish(
            stamp, figures.volumetric, figures.hydromechanical, figures.overall)
        self.outputs[f'{origin}losses'].publish(
            stamp, figures.slip, figures.torque_loss_ratio, figures.torque_loss)

    def _watch(self, watched: Watched) -> None:
        stamp = watched.stamp
        for name, entry in (watched.resistances or Resistances(None, None))._asdict().items():
            self._resistance(stamp, _RESISTANCES[name], entry)
        said = watched.verdict
        if said is None:
            self._say(stamp, 'watch', watched.reason)
            return
        for name, innovation in said.innovations.items():
            if f'{name}_residual' in self.outputs:
                self.outputs[f'{name}_residual'].publish(
                    stamp, innovation.value, innovation.deviation, said.levels[name])
        self.outputs['verdict'].pack(stamp, verdict.named(stamp, said))
        observer = self._observer
        if said.failing:
            message, values = verdict.alarm(
                said, observer.origin, verdict.to_diagnose(self.settings),
                observer.signatures.unseen, observer.balances.closed)
            if said.failing != self._failing:
                self.get_logger().warning(message)
            self._tell(stamp, 'watch', WARN, message, values)
        else:
            self._tell(stamp, 'watch', OK, 'the model describes the drive', {
                **verdict.fine(said.levels, said.innovations, observer.watch.blocks,
                               observer.balances.closed),
                'resistances': watched.why_none or 'valid'})
        self._failing = said.failing

    def _resistance(self, stamp: int, topic: str, entry: Estimate | None) -> None:
        if entry is not None and topic in self.outputs:
            self.outputs[topic].publish(stamp, entry.value, entry.model or 0.0, entry.uncertainty)

    def _say(self, stamp: int, what: str, reason: str) -> None:
        """Tell whether something is valid."""
        if reason:
            reason = '; '.join((reason, *(f'{name}: {entry.refused}' for name, entry in
                                          self.inputs.items() if entry.refused)))
        self._tell(stamp, what, STALE if reason else OK,
                   f'not valid: {reason}' if reason else 'valid',
                   {'valid': str(not reason).lower()})

    def _tell(self, stamp: int, what: str, level: int, message: str, values) -> None:
        self._diagnostics.publish(
            stamp, f'{self.get_fully_qualified_name()}: {what}', level, message, values)


def main() -> int:
    """Run the node."""
    return run_node(Estimator)


if __name__ == '__main__':
    sys.exit(main())
