# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The readings that the plant publishes, and when."""
from __future__ import annotations

from collections.abc import Iterable, Mapping

from hst_drive.bag.topics import TRUTH
from hst_drive.model import SensorBank
from hst_drive.nodes import wiring
from hst_drive.nodes.endpoints import Output, topic_named

BURST = 10
"""Steps whose readings go out together when time runs as fast as it goes; see ``sync``."""


class Readings:
    """
    Publishers of readings, with and without noise.

    What the controller answers goes out at once, so that it works while the rest is published.
    The rest may go out in bursts: a message costs little, but to wake who reads it costs much.

    Parameters
    ----------
    node : DriveNode
        Owner; gets the publishers among its ``outputs``.
    names : iterable of str
        Topics of the table.
    sensors : SensorBank
        Says the noise.
    truth : bool
        Publish the values without noise as well.
    burst : int
        Samples to publish together.

    """

    def __init__(self, node, names: Iterable[str], sensors: SensorBank, truth: bool, burst: int):
        self._burst = burst
        self._samples = 0
        self._unsent: list[tuple[Output, int, list[float]]] = []
        for name in names:
            topic = topic_named(name)
            sensor = sensors.sensors.get(topic.fields[0].channel)
            node.outputs[name] = Output(node, topic, sensor.noise_std**2 if sensor else 0.0)
        if truth:
            node.publish_to(*(f'{TRUTH}{name}' for name in names))
        self._outputs = [
            (output, name in wiring.READS['controller'], name.startswith(TRUTH),
             [field.channel or 'motor_angle' for field in output.topic.fields])
            for name, output in node.outputs.items()]

    def publish(self, stamp: int, readings: Mapping[str, float], truth: Mapping[str, float]
                ) -> None:
        """Publish a sample that was taken at ``stamp`` (ns), SI by channel, or keep it a while."""
        for output, answered, noiseless, channels in self._outputs:
            source = truth if noiseless else readings
            values = [source[channel] for channel in channels]
            if answered:
                output.publish(stamp, *values)
            else:
                self._unsent.append((output, stamp, values))
        self._samples += 1
        if self._samples % self._burst == 0:
            self.send()

    def send(self) -> None:
        """Publish what is still kept."""
        unsent, self._unsent = self._unsent, []
        for output, stamp, values in unsent:
            output.publish(stamp, *values)
