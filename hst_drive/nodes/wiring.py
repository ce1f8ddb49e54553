# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which node reads which topics; who publishes them is in the table of topics. No ROS here."""
from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from hst_drive.bag.topics import TOPICS, WITH_READING
from hst_drive.channels import LINES
from hst_drive.errors import InputError

NODES = ('plant', 'load_profile', 'controller', 'estimator', 'recorder')
SENSORS = tuple(name for name, topic in TOPICS.items() if topic.publisher == 'plant'
                and topic.recorded and not name.startswith('/'))
"""Topics of the plant that a rig's sensors would publish."""

READS: dict[str, tuple[str, ...]] = {
    'plant': ('pump_command', 'pprv_command', 'load_torque_command', 'oil_temperature_command',
              'sync'),
    'load_profile': ('/clock', 'sync'),
    'controller': ('motor', 'speed_setpoint', 'manual_pump_command', 'sync'),
    'estimator': ('motor', 'pump_outlet_pressure', 'motor_inlet_flow', 'pump_command',
                  'pprv_command', 'oil_temperature', 'motor_inlet_pressure', 'case_drain_flow',
                  'pump', 'pump_displacement', 'line_a_pressure', 'line_b_pressure',
                  'charge_pressure', 'motor_torque', 'valve_command', 'pump_torque', 'pump_power',
                  'motor_displacement_command', 'sync'),
    'recorder': ('sync',),
}
"""Topics by reader; the recorder reads those that it is asked to record as well."""


_OTHERS = ('motor_inlet_pressure', 'motor_outlet_pressure', 'pprv_command', 'load_torque_residual')
_FLOW = ('motor_inlet_flow', 'motor_flow_residual')
_LACKS = {'open': (*LINES, 'charge_pressure'), 'closed': ('pump_outlet_pressure', *_OTHERS),
          'valve': ('charge_pressure', 'pump_command', *_OTHERS)}
_ADDS = {'open': (), 'closed': (*LINES, 'charge_pressure', 'motor_torque'),
         'valve': (*LINES, 'motor_torque', 'valve_command')}
_OFF = {'open': (), 'closed': _FLOW, 'valve': (*_FLOW, 'pump_outlet_pressure')}
CIRCUITS = ('open', 'closed')
"""Circuits that the nodes can run."""


def nodes_of(circuit: str, source: str) -> tuple[str, ...]:
    """
    Return the nodes of a run; ``source`` is the rig file, for the message.

    Raises
    ------
    InputError
        If the nodes cannot run the circuit.

    """
    if circuit not in CIRCUITS:
        raise InputError(f"{source}: 'circuit: {circuit}': the nodes run {' and '.join(CIRCUITS)} "
                         "ones; give the rig of one, or judge logs of this with 'diagnose'")
    return NODES


def comes(name: str, extra: Iterable[str], circuit: str) -> bool:
    """Say whether a topic is there in a circuit; ``extra`` as of ``readings``."""
    return name not in _LACKS[circuit] and (
        name in (*extra, *_ADDS[circuit]) or TOPICS[name].on and name not in _OFF[circuit]
        or WITH_READING.get(name) in (*extra, *_ADDS[circuit]))


def asked(extra: Iterable[str], circuit: str) -> tuple[str, ...]:
    """Return the extra topics; raises ``InputError`` if the circuit's plant has not one."""
    extra, there = tuple(extra), [name for name in SENSORS if name not in _LACKS[circuit]]
    for name in extra:
        if name not in there:
            near = get_close_matches(name, there, n=1)
            raise InputError(f"topic '{name}' is none of the plant's; " + (
                f"did you mean '{near[0]}'?" if near else f"it has {', '.join(there)}"))
    return extra


def readings(extra: Iterable[str] = (), circuit: str = 'open') -> tuple[str, ...]:
    """
    Return the names of the topics that the plant publishes as a rig's sensors would.

    Parameters
    ----------
    extra : iterable of str
        Topics that are off by default and shall be on.
    circuit : str
        One of ``CIRCUITS``: not all have all.

    Raises
    ------
    InputError
        If a name is not one of the plant's topics.

    """
    extra = asked(extra, circuit)
    return tuple(name for name in SENSORS if comes(name, extra, circuit))


def recorded(nodes: Iterable[str], extra: Iterable[str] = (), truth: bool = False,
             circuit: str = 'open') -> tuple[str, ...]:
    """Return the names of the topics to record when these nodes run, in the table's order."""
    nodes, sensors = set(nodes), readings(extra, circuit)
    names = [name for name, topic in TOPICS.items() if topic.publisher in nodes
             and topic.recorded and comes(name, sensors, circuit)
             and (name in sensors or topic.publisher != 'plant')]
    return (*names, *(f'truth/{name}' for name in sensors if truth))


def readers(topic: str, partners: Iterable[str], taken: Iterable[str]) -> int:
    """Return how many of the partners read a topic; ``taken`` is what the recorder takes."""
    taken = set(taken)
    return sum(topic in READS.get(node, ()) or (node == 'recorder' and topic in taken)
               for node in partners)
