# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of a node from one declaration: default, description, unit, range, choices."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any, NamedTuple

from hst_drive.errors import InputError
from hst_drive.nodes import wiring
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.parameter import Parameter as RosParameter

_TYPES = {bool: RosParameter.Type.BOOL, int: RosParameter.Type.INTEGER,
          float: RosParameter.Type.DOUBLE, str: RosParameter.Type.STRING,
          list: RosParameter.Type.STRING_ARRAY}
_QOS = 'qos_overrides.'
JOINT = "name of a joint in the messages' array name"
YAML_FILE = 'path of a YAML file'


class Parameter(NamedTuple):
    """
    One parameter of a node.

    ``low`` and ``high`` bound a number (both or none); ``choices`` are the texts that there are,
    ``form`` says what a text must be where they cannot be listed.
    A ``live`` parameter counts at once. Any other is read when the node is configured, and
    read-only where that happens once; ``at_start`` is one that is read before.
    """

    name: str
    default: Any
    description: str
    unit: str = ''
    low: float | None = None
    high: float | None = None
    live: bool = False
    choices: tuple[str, ...] = ()
    at_start: bool = False
    form: str = ''

    def descriptor(self, managed: bool = False) -> ParameterDescriptor:
        """Return what ``ros2 param describe`` shows."""
        unit = f' [{self.unit}]' if self.unit else ''
        constraints = [f'unit: {self.unit}'] * bool(self.unit)
        if self.choices:
            some = 'some' if isinstance(self.default, list) else 'one'
            constraints.append(f'{some} of: {", ".join(self.choices)}')
        constraints += [self.form] * bool(self.form)
        result = ParameterDescriptor(
            name=self.name, type=_TYPES[type(self.default)].value,
            description=f'{self.description}{unit}',
            read_only=not self.live and (self.at_start or not managed),
            additional_constraints='; '.join(constraints))
        if self.low is not None and self.high is not None:
            if isinstance(self.default, float):
                result.floating_point_range = [FloatingPointRange(
                    from_value=float(self.low), to_value=float(self.high), step=0.0)]
            else:
                result.integer_range = [IntegerRange(
                    from_value=int(self.low), to_value=int(self.high), step=1)]
        return result

    def read(self, value: Any) -> Any:
        """
        Return the value as a node works with it.

        Raises
        ------
        InputError
            If it is none of the choices.

        """
        listed = isinstance(self.default, list)
        value = [text for text in value if text] if listed else value
        wrong = [text for text in (value if listed else [value]) if text not in self.choices]
        if self.choices and wrong:
            near = get_close_matches(wrong[0], self.choices, n=1)
            raise InputError(f"parameter {self.name}: '{wrong[0]}' is none of its values; " + (
                f"did you mean '{near[0]}'?" if near else f'expected {", ".join(self.choices)}'))
        return value


def declare(node, parameters: Iterable[Parameter], managed: bool = False) -> dict[str, Any]:
    """Declare the parameters and return their values by name."""
    values = {}
    for parameter in parameters:
        # rclpy takes an empty list for one of bytes: [''] stands for no texts.
        default = [''] if parameter.default == [] else parameter.default
        values[parameter.name] = parameter.read(node.declare_parameter(
            parameter.name, default, parameter.descriptor(managed)).value)
    return values


def undeclared(node, of_topics: bool) -> list[str]:
    """
    Return a line for each parameter that was given but is none of the node's.

    Those ``of_topics`` (qos_overrides) are known once the endpoints are open.
    """
    names = [name for name in node.get_parameters_by_prefix('')
             if name.startswith(_QOS) == of_topics]
    lines = []
    # rclpy has no public way to ask what was given.
    for name in getattr(node, '_parameter_overrides', {}):
        if not node.has_parameter(name) and name.startswith(_QOS) == of_topics:
            near = get_close_matches(name, names, n=1)
            lines.append(f"parameter '{name}' is none of this node's and is not used; "
                         + (f"did you mean '{near[0]}'?" if near else
                            f'it has {", ".join(sorted(names))}'))
    return lines


PRIORITY = Parameter(
    'priority', 0, 'real-time priority (SCHED_RR), before all ordinary work of the machine; 0: '
    'ordinary', low=0, high=99, at_start=True)
COMMON = (
    Parameter('lockstep', False, 'simulated time: the nodes wait for each other in every step',
              at_start=True),
    Parameter('partners', [], 'nodes that this run consists of; the plant starts when all are '
              'connected and, in lockstep, waits for them', choices=wiring.NODES, at_start=True),
    Parameter('lookahead', False, 'in lockstep: load_profile plays ahead of the clock, and the '
              'plant sends readings in bursts', at_start=True),
    Parameter('circuit', 'open', "the rig's hydraulic circuit, which says what topics there are",
              choices=wiring.CIRCUITS, at_start=True),
    PRIORITY,
)
"""Parameters that every node of a run has."""


def markdown(nodes: Mapping[str, Iterable[Parameter]]) -> str:
    """Return the parameters by node as Markdown for the documentation."""
    lines = []
    for name, parameters in nodes.items():
        lines += [f'## {name}', '', '| parameter | default | unit | range or choices | may change '
                  '| what it is |', '|---|---|---|---|---|---|']
        for entry in parameters:
            limits = (f'{entry.low:g} to {entry.high:g}' if entry.low is not None
                      else ', '.join(entry.choices) or entry.form)
            default = str(entry.default).lower() if isinstance(
                entry.default, bool) else repr(entry.default)
            when = ('at any time' if entry.live else
                    'at start' if entry.at_start else 'until configured')
            lines.append(f'| `{entry.name}` | `{default}` | {entry.unit} | {limits} | {when} | '
                         f'{entry.description} |')
        lines.append('')
    return '\n'.join(lines)
