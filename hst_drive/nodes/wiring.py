# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which node reads which topics; who publishes them is in the table of topics. No ROS here."""
from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from hst_drive.bag.topics import TOPICS, WITH_READING
from hst_drive.errors import InputError

NODES = ('plant', 'load_profile', 'controller', 'estimator', 'recorder')
SENSORS = tuple(name for name, topic in TOPICS.items() if topic.publisher == 'plant'
                and topic.recorded and not name.startswith('/'))
"""Topics of the plant that a rig's sensors would publish."""

READS: dict[str, tuple[str, ...]] = {
    'plant': ('pump_command', 'pprv_command', 'oil_temperature_command', 'sync'),
    'load_profile': ('/clock', 'sync'),
    'controller': ('motor', 'speed_setpoint', 'manual_pump_command', 'sync'),
    'estimator': ('motor', 'pump_outlet_pressure', 'motor_inlet_flow', 'pump_command',
                  'pprv_command', 'oil_temperature', 'motor_inlet_pressure', 'case_drain_flow',
                  'pump', 'pump_displacement', 'sync'),
    'recorder': ('sync',),
}
"""Topics by reader; the recorder reads those that it is asked to record as well."""


def readings(extra: Iterable[str] = ()) -> tuple[str, ...]:
    """
    Return the names of the topics that the plant publishes as a rig's sensors would.

    Parameters
    ----------
    extra : iterable of str
        Topics that are off by default and shall be on.

    Raises
    ------
    InputError
        If a name is not one of the plant's topics.

    """
    extra = tuple(extra)
    for name in extra:
        if name not in SENSORS:
            near = get_close_matches(name, SENSORS, n=1)
            raise InputError(f"topic '{name}' is none of the plant's; " + (
                f"did you mean '{near[0]}'?" if near else f"it has {', '.join(SENSORS)}"))
    return tuple(name for name in SENSORS if TOPICS[name].on or name in extra)


def recorded(nodes: Iterable[str], extra: Iterable[str] = (), truth: bool = False
             ) -> tuple[str, ...]:
    """Return the names of the topics to record when these nodes run, in the table's order."""
    nodes, sensors = set(nodes), readings(extra)
    names = [name for name, topic in TOPICS.items()
             if topic.publisher in nodes and topic.recorded
             and (name in sensors if topic.publisher == 'plant'
                  else topic.on or WITH_READING.get(name) in sensors)]
    return (*names, *(f'truth/{name}' for name in sensors if truth))


def readers(topic: str, partners: Iterable[str], taken: Iterable[str]) -> int:
    """Return how many of the partners read a topic; ``taken`` is what the recorder takes."""
    taken = set(taken)
    return sum(topic in READS.get(node, ()) or (node == 'recorder' and topic in taken)
               for node in partners)
