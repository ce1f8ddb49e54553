# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What reads and writes MCAP files here: ROS 2's rosbag2_py, else the mcap library of PyPI.

A stock machine with ROS 2 has the first and no package of the second; one without ROS has the
second. What rosbag2_py reads has no checksums verified; whole files are told from cut ones before.
"""
from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple, Protocol

from hst_drive.bag.packages import on_use
from hst_drive.bag.stream import Stream


class Announced(NamedTuple):
    """
    A topic as a bag holds it; ``profiles`` are its QoS as a YAML list with names.

    ``encoding`` is that of its definition, ``coding`` that of its messages.
    """

    name: str
    type: str
    definition: str
    encoding: str
    type_hash: str
    profiles: str
    coding: str = 'cdr'


class Sink(Protocol):
    """
    One bag that is written; it creates the folder, which is not there yet.

    What cannot be written raises OSError. ``counts`` has the messages by announced topic.
    """

    counts: dict[str, int]

    def add_topic(self, topic: Announced) -> None:
        """Announce a topic that is not announced yet."""

    def write(self, name: str, data: bytes, log_time: int, publish_time: int) -> None:
        """Append a message."""

    def flush(self) -> None:
        """Bring what is held in memory to the file, as far as this one can."""

    def close(self) -> None:
        """Finish the bag; twice is harmless."""


class Storage(NamedTuple):
    """How MCAP files are read, as ``mcap_bag.read_streams`` says, and what writes them."""

    read_streams: Callable[[Path, Callable[[str], bool]], Iterator[list[Stream]]]
    sink: Callable[[Path, Mapping[str, str], float, bool], Sink]


def find_storage() -> Storage:
    """
    Return what reads and writes MCAP files on this machine.

    Raises
    ------
    InputError
        If nothing does; one line that says what to install.

    """
    try:
        import rosbag2_py   # noqa: F401
    except ImportError:     # or it was built for another Python
        return Storage(on_use('hst_drive.bag.mcap_bag').read_streams,
                       on_use('hst_drive.bag.mcap_sink').McapSink)
    from hst_drive.bag.ros_bag import read_streams, RosSink
    return Storage(read_streams, RosSink)
