# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Efficiency, slip and torque loss of the hydromotor, measured and by the loss model."""
from __future__ import annotations

from collections.abc import Callable
import math
import sys

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hst_drive.bag.topics import TOPICS
from hst_drive.losses.efficiency import (Limits, Performance, performance, predicted,
                                         reason_not_valid)
from hst_drive.nodes.base import DriveNode, GATHER, main as run_node
from hst_drive.nodes.endpoints import BILLION, qos_profile
from hst_drive.nodes.parameters import Parameter
from hst_drive.rig import default_rig, load_rig, Rig

_SIGNALS = {'motor': ('speed', 'load_torque'), 'pump_outlet_pressure': ('pressure',),
            'motor_inlet_flow': ('flow',)}
LossModel = Callable[[float, float], Performance]


def table_model(rig: Rig) -> LossModel:
    """Return the loss model of the rig's own tables: performance over pressure and speed."""
    motor = rig.motor

    def model(pressure: float, speed: float) -> Performance:
        return predicted(pressure, speed, motor.displacement,
                         float(motor.leakage(pressure, abs(speed))) * (1 if speed > 0 else -1),
                         float(motor.mechanical_efficiency(pressure, abs(speed))))

    return model


class Estimator(DriveNode):
    """
    Publishes the figures of merit at its own rate, from smoothed signals of one time.

    Where the signals say nothing (standstill, no pressure, a sensor that is silent) it
    publishes no figure, and on /diagnostics why.
    """

    role = 'estimator'
    parameters = (
        Parameter('rig', '', 'rig file; empty: the shipped test rig'),
        Parameter('rate', 10.0, 'estimates per second', 'Hz', 0.1, 100.0),
        Parameter('time_constant', 0.5, 'smoothing of the signals', 's', 0.0, 60.0),
        Parameter('timeout', 0.5, 'a signal that is older is missing', 's', 0.01, 60.0),
        Parameter('minimum_speed', 0.5, 'below it no figure is valid', 'rad/s', 0.01, 100.0),
        Parameter('minimum_pressure', 5e5, 'below it no figure is valid', 'Pa', 1e3, 1e8),
    )

    def configure(self) -> None:
        """Build the loss model."""
        settings = self.settings
        rig = load_rig(settings['rig']) if settings['rig'] else default_rig()
        rig.require('motor', purpose='the estimator')
        self._displacement = rig.motor.displacement
        self._model = table_model(rig)
        self._limits = Limits(settings['minimum_speed'], settings['minimum_pressure'])
        self._period = round(BILLION / settings['rate'])
        self._values = dict.fromkeys(
            (name for names in _SIGNALS.values() for name in names), math.nan)
        self._stamps = dict.fromkeys(_SIGNALS, None)
        self._next: int | None = None
        self.gather = GATHER if self.lockstep else 0.0

    def activate(self) -> None:
        """Open the endpoints."""
        self.publish_to('efficiency', 'model_efficiency', 'losses', 'model_losses')
        topic = TOPICS['/diagnostics']
        self._diagnostics = self.create_publisher(
            DiagnosticArray, topic.name, qos_profile(topic.qos))
        for name in _SIGNALS:
            self.listen_to(name, lambda stamp, values, name=name: self._measured(
                name, stamp, values[-len(_SIGNALS[name]):]))
        super().activate()
        if not self.lockstep:
            self.create_timer(self._period / BILLION, lambda: self._estimate(self.now()))

    def _measured(self, topic: str, stamp: int, values: tuple[float, ...]) -> None:
        self.handled += 1
        last = self._stamps[topic]
        elapsed = 0.0 if last is None else (stamp - last) / BILLION
        weight = 1.0 if last is None or elapsed <= 0.0 else -math.expm1(
            -elapsed / max(self.settings['time_constant'], 1e-9))
        for name, value in zip(_SIGNALS[topic], values):
            known = self._values[name]
            self._values[name] = value if not math.isfinite(known) else (
                known + weight * (value - known) if math.isfinite(value) else math.nan)
        self._stamps[topic] = stamp
        if self.lockstep and all(known == stamp for known in self._stamps.values()):
            self._next = stamp if self._next is None else self._next
            if stamp >= self._next:
                self._next += self._period
                self._estimate(stamp)
            self.answers.done(stamp)

    def _estimate(self, stamp: int) -> None:
        patience = self.settings['timeout'] * BILLION
        for topic, names in _SIGNALS.items():
            if self._stamps[topic] is None or stamp - self._stamps[topic] > patience:
                self._values.update(dict.fromkeys(names, math.nan))
        value = self._values
        signals = (value['pressure'], value['flow'], value['speed'], value['load_torque'])
        reason = reason_not_valid(*signals, limits=self._limits)
        if not reason:
            measured = performance(*signals, self._displacement)
            model = self._model(value['pressure'], value['speed'])
            self._publish(stamp, '', measured)
            self._publish(stamp, 'model_', model)
        self._tell(stamp, reason)

    def _publish(self, stamp: int, origin: str, figures: Performance) -> None:
        self.outputs[f'{origin}efficiency'].publish(
            stamp, figures.volumetric, figures.hydromechanical, figures.overall)
        self.outputs[f'{origin}losses'].publish(stamp, figures.slip, figures.torque_loss_ratio)

    def _tell(self, stamp: int, reason: str) -> None:
        status = DiagnosticStatus(
            name=f'{self.get_fully_qualified_name()}: efficiency', hardware_id='motor',
            level=DiagnosticStatus.STALE if reason else DiagnosticStatus.OK,
            message=f'not valid: {reason}' if reason else 'valid',
            values=[KeyValue(key='valid', value=str(not reason).lower())])
        message = DiagnosticArray(status=[status])
        message.header.stamp = Time(sec=stamp // BILLION, nanosec=stamp % BILLION)
        self._diagnostics.publish(message)


def main() -> int:
    """Run the node."""
    return run_node(Estimator)


if __name__ == '__main__':
    sys.exit(main())
