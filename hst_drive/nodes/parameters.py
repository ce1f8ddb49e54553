# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of a node from one declaration: default, description, unit, range."""
from __future__ import annotations

from difflib import get_close_matches
from typing import Any, NamedTuple

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.parameter import Parameter as RosParameter

_TYPES = {bool: RosParameter.Type.BOOL, int: RosParameter.Type.INTEGER,
          float: RosParameter.Type.DOUBLE, str: RosParameter.Type.STRING,
          list: RosParameter.Type.STRING_ARRAY}
_QOS = 'qos_overrides.'


class Parameter(NamedTuple):
    """
    One parameter of a node.

    ``low`` and ``high`` bound a number (both or none). A parameter that is not ``live`` is read
    when the node is configured and says that it is read-only.
    """

    name: str
    default: Any
    description: str
    unit: str = ''
    low: float | None = None
    high: float | None = None
    live: bool = False

    def descriptor(self) -> ParameterDescriptor:
        """Return what ``ros2 param describe`` shows."""
        unit = f' [{self.unit}]' if self.unit else ''
        result = ParameterDescriptor(
            name=self.name, type=_TYPES[type(self.default)].value,
            description=f'{self.description}{unit}', read_only=not self.live,
            additional_constraints=f'unit: {self.unit}' if self.unit else '')
        if self.low is not None and self.high is not None:
            if isinstance(self.default, float):
                result.floating_point_range = [FloatingPointRange(
                    from_value=float(self.low), to_value=float(self.high), step=0.0)]
            else:
                result.integer_range = [IntegerRange(
                    from_value=int(self.low), to_value=int(self.high), step=1)]
        return result


def declare(node, parameters: tuple[Parameter, ...]) -> dict[str, Any]:
    """Declare the parameters and return their values by name."""
    values = {}
    for parameter in parameters:
        listed = isinstance(parameter.default, list)
        # rclpy takes an empty list for one of bytes: [''] stands for no texts.
        default = parameter.default or [''] if listed else parameter.default
        value = node.declare_parameter(parameter.name, default, parameter.descriptor()).value
        values[parameter.name] = [text for text in value if text] if listed else value
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


COMMON = (
    Parameter('lockstep', False, 'simulated time: the nodes wait for each other in every step'),
    Parameter('partners', [], 'nodes that this run consists of; the plant starts when all are '
              'connected and, in lockstep, waits for them'),
    Parameter('lookahead', False, 'in lockstep: load_profile plays ahead of the clock, and the '
              'plant sends readings in bursts'),
    Parameter('priority', 0, 'real-time priority (SCHED_RR), before all ordinary work of the '
              'machine; 0: ordinary', low=0, high=99),
)
"""Parameters that every node has."""
