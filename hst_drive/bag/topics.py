# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
THE table of topics: what is published where, in which type, unit, frame and quality of service.

The nodes, the recorder, the reader of bags and the documentation all go by it. It is data
without ROS. Quantities for which ROS has no stamped standard type (voltage, flow, displacement,
ratio) travel as geometry_msgs/Vector3Stamped, whose x carries the value in SI and whose
frame_id names the component. ``FluidPressure`` is absolute, ``Temperature`` is in degC, as their
definitions say.
"""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.channels import Channel, CHANNELS
from hst_drive.units import from_si

NAMESPACE = '/drive'
TRUTH = 'truth/'
"""Sub-namespace of the noise-free values, which only a simulated rig can publish."""
ATMOSPHERE = 101325.0
"""Standard atmosphere, Pa: absolute pressure = gauge pressure + ATMOSPHERE."""


class Qos(NamedTuple):
    """Quality of service that a publisher offers."""

    reliability: str = 'reliable'
    durability: str = 'volatile'
    depth: int = 100


class Field(NamedTuple):
    """
    One number of a message.

    Attributes
    ----------
    path : str
        Where it is, e.g. ``'vector.x'`` or ``'velocity[0]'``.
    unit : str
        Unit in the message.
    title : str
        What it is.
    channel : str or None
        Name of the channel of a log that it carries; None if it is for display only.
    absolute : bool
        The message holds absolute pressure, the channel gauge pressure.

    """

    path: str
    unit: str
    title: str
    channel: str | None = None
    absolute: bool = False

    def from_channel(self, value):
        """Convert an SI value (Pa gauge) of the channel to the message's unit."""
        return from_si(value + ATMOSPHERE if self.absolute else value, self.unit)


class Topic(NamedTuple):
    """
    One topic; ``name`` is relative to the namespace unless it begins with a slash.

    ``on`` says whether its publisher is on by default, ``recorded`` whether the recorder takes it.
    """

    name: str
    type: str
    frame: str
    publisher: str
    fields: tuple[Field, ...]
    qos: Qos = Qos()
    on: bool = True
    recorded: bool = True

    def full_name(self, namespace: str = NAMESPACE) -> str:
        """Return the resolved name in a namespace."""
        return self.name if self.name.startswith('/') else f'{namespace.rstrip("/")}/{self.name}'


VECTOR3_STAMPED = 'geometry_msgs/msg/Vector3Stamped'
FLUID_PRESSURE = 'sensor_msgs/msg/FluidPressure'
TEMPERATURE = 'sensor_msgs/msg/Temperature'
JOINT_STATE = 'sensor_msgs/msg/JointState'
CLOCK = 'rosgraph_msgs/msg/Clock'
DIAGNOSTIC_ARRAY = 'diagnostic_msgs/msg/DiagnosticArray'
BOOL = 'std_msgs/msg/Bool'


def _of(channel: Channel) -> Topic:
    """Return the topic that a channel has for itself."""
    kind, path, unit = {
        'Pa': (FLUID_PRESSURE, 'fluid_pressure', 'Pa'),
        'K': (TEMPERATURE, 'temperature', 'degC')}.get(
            channel.unit, (VECTOR3_STAMPED, 'vector.x', channel.unit))
    return Topic(channel.name, kind, channel.frame, channel.publisher, (
        Field(path, unit, channel.title, channel.name, absolute=kind == FLUID_PRESSURE),),
        on=channel.on)


def _joint(name: str, *more: Field) -> Topic:
    """Return the JointState that carries some channels."""
    carried = [channel for channel in CHANNELS.values() if channel.joint == name]
    return Topic(name, JOINT_STATE, name, carried[0].publisher, (*more, *(
        Field({'rad/s': 'velocity[0]', 'N.m': 'effort[0]'}[channel.unit], channel.unit,
              channel.title, channel.name) for channel in carried)), on=carried[0].on)


def _ratios(name: str, origin: str) -> Topic:
    return Topic(name, VECTOR3_STAMPED, 'motor', 'estimator', (
        Field('vector.x', '1', f'volumetric efficiency, {origin}'),
        Field('vector.y', '1', f'hydro-mechanical efficiency, {origin}'),
        Field('vector.z', '1', f'overall efficiency, {origin}')))


def _losses(name: str, origin: str) -> Topic:
    return Topic(name, VECTOR3_STAMPED, 'motor', 'estimator', (
        Field('vector.x', '%', f'slip, {origin}'),
        Field('vector.y', '%', f'torque loss, {origin}'),
        Field('vector.z', 'N.m', f'torque loss, {origin}')))


def _resistance(name: str, title: str, **more) -> Topic:
    return Topic(name, VECTOR3_STAMPED, 'motor', 'estimator', (
        Field('vector.x', 'Pa.s/m^3', title),
        Field('vector.y', 'Pa.s/m^3', f'{title}, from the loss model; 0: it gives none'),
        Field('vector.z', 'Pa.s/m^3', f'{title}, standard uncertainty')), **more)


def _residual(name: str, unit: str, title: str, frame: str, **more) -> Topic:
    return Topic(f'{name}_residual', VECTOR3_STAMPED, frame, 'estimator', (
        Field('vector.x', unit, f'{title}, measured minus calibrated model'),
        Field('vector.y', unit, f'{title}, standard deviation to expect of that'),
        Field('vector.z', '1', f'{title}, evidence that it fails; 1: alarm')), **more)


TOPICS: dict[str, Topic] = {entry.name: entry for entry in (
    *(_of(channel) for channel in CHANNELS.values() if not channel.joint),
    _joint('motor', Field('position[0]', 'rad', 'hydromotor angle')),
    _joint('pump'),
    _ratios('efficiency', 'from the measured signals'),
    _ratios('model_efficiency', 'from the loss model'),
    _losses('losses', 'from the measured signals'),
    _losses('model_losses', 'from the loss model'),
    Topic('efficiency_uncertainty', VECTOR3_STAMPED, 'motor', 'estimator', (
        Field('vector.x', '1', 'volumetric efficiency (and slip), standard uncertainty'),
        Field('vector.y', '1', 'hydro-mechanical efficiency, standard uncertainty'),
        Field('vector.z', '1', 'overall efficiency, standard uncertainty'))),
    _resistance('leakage_resistance', 'resistance of all leakage'),
    _resistance('port_resistance', 'inlet port resistance R_1'),
    _resistance('external_leakage_resistance', 'external leakage resistance R_el', on=False),
    _resistance('internal_leakage_resistance', 'internal leakage resistance R_2', on=False),
    _residual('pump_flow', 'm^3/s', 'pump flow', 'pump'),
    _residual('motor_flow', 'm^3/s', 'hydromotor flow', 'motor'),
    _residual('motor_torque', 'N.m', 'hydromotor torque', 'motor'),
    _residual('load_torque', 'N.m', 'load torque', 'motor'),
    _residual('pump_displacement', 'm^3/rad', 'pump stroke', 'pump', on=False),
    _residual('case_drain_flow', 'm^3/s', 'case drain flow', 'motor_case', on=False),
    _residual('line_a_pressure', 'Pa', 'pressure of line A, the low one', 'line_a', on=False),
    _residual('line_b_pressure', 'Pa', 'pressure of line B, the low one', 'line_b', on=False),
    _residual('charge_pressure', 'Pa', 'charge pressure', 'charge', on=False),
    _residual('line_pressure', 'Pa', 'pressure drop of the line', 'motor_inlet', on=False),
    Topic('verdict', JOINT_STATE, 'motor', 'estimator', ()),
    Topic('oil_temperature_command', TEMPERATURE, 'oil', 'load_profile', (
        Field('temperature', 'degC', 'oil temperature that the test bench sets'),),
        recorded=False),
    Topic('load_torque_command', VECTOR3_STAMPED, 'motor', 'load_profile', (
        Field('vector.x', 'N.m', 'torque against the motion that the test bench sets'),),
        on=False, recorded=False),
    Topic('manual_pump_command', VECTOR3_STAMPED, 'pump', 'load_profile', (
        Field('vector.x', 'V', 'pump command of a manual run'),), recorded=False),
    Topic('emergency_stop', BOOL, '', 'operator', (),
          qos=Qos(durability='transient_local', depth=1), on=False, recorded=False),
    Topic('sync', DIAGNOSTIC_ARRAY, '', 'all nodes', (), on=False, recorded=False),
    Topic('/diagnostics', DIAGNOSTIC_ARRAY, 'motor', 'estimator', ()),
    Topic('/clock', CLOCK, '', 'plant', (Field('clock', 's', 'simulated time'),),
          qos=Qos(depth=10), on=False),
)}

# What the topics without numbers say.
_WORDS = {'emergency_stop': 'true stops the drive; stays until a reset',
          'sync': 'nodes of a run find each other and keep step',
          'verdict': '`name`: effects that could be missing, the likeliest first; `unknown`: none '
                     'of the catalogue; empty: no balance fails. Of each `position`: size (SI), '
                     '`velocity`: share that it explains (0 to 1), `effort`: failing for s. Then '
                     '`EFFECT.rate`: growth a second (SI) and the ends of its 95 % interval',
          '/diagnostics': 'whether the figures are valid; which balance fails and what it lacks'}
WITH_READING: dict[str, str] = {
    'external_leakage_resistance': 'case_drain_flow',
    'internal_leakage_resistance': 'case_drain_flow',
    'motor_flow_residual': 'motor_inlet_flow',
    **{f'{name}_residual': name for name in (
        'pump_displacement', 'case_drain_flow', 'line_a_pressure', 'line_b_pressure',
        'charge_pressure')},
    'line_pressure_residual': 'motor_inlet_pressure',
}
"""Topics of the estimator that come with a reading which may be off."""

CHANNEL_FIELDS: dict[str, tuple[Topic, Field]] = {
    field.channel: (topic, field)
    for topic in TOPICS.values() for field in topic.fields if field.channel}
"""Topic and field that carry a channel."""

STANDARD_UNITS: dict[tuple[str, str], tuple[str, bool]] = {
    (FLUID_PRESSURE, 'fluid_pressure'): ('Pa', True),
    (TEMPERATURE, 'temperature'): ('degC', False),
    (JOINT_STATE, 'position'): ('rad', False),
    (JOINT_STATE, 'velocity'): ('rad/s', False),
    (JOINT_STATE, 'effort'): ('N.m', False),
}
"""Unit of a standard message's field as its definition fixes it, and whether it is absolute."""


def markdown() -> str:
    """Return the table as Markdown for the documentation."""
    rows = ['| topic | type | field | quantity | unit | frame | published by | QoS | default |',
            '|---|---|---|---|---|---|---|---|---|']
    for topic in TOPICS.values():
        qos = f'{topic.qos.reliability}, {topic.qos.durability}, {topic.qos.depth}'
        cells = [(f'`{field.path}`', field.title,
                  f'{field.unit} absolute' if field.absolute else field.unit)
                 for field in topic.fields] or [('', _WORDS[topic.name], '')]
        for path, title, unit in cells:
            rows.append(f'| `{topic.full_name()}` | {topic.type} | {path} | '
                        f'{title} | {unit} | {topic.frame} | {topic.publisher} | {qos} | '
                        f'{"on" if topic.on else "off"} |')
    return '\n'.join(rows) + '\n'
