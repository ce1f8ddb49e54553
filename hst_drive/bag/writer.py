# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Writing rosbag2 folders, with whatever writes MCAP files on this machine (``storage``)."""
from __future__ import annotations

from collections.abc import Callable, Mapping
import os
from pathlib import Path
from typing import Any

from hst_drive.bag.cdr import Codec
from hst_drive.bag.definitions import find_definition, find_hash, full_type
from hst_drive.bag.storage import Announced, find_storage, Sink
from hst_drive.bag.topics import CHANNEL_FIELDS, JOINT_STATE, NAMESPACE, Qos, Topic
from hst_drive.errors import InputError
from hst_drive.measure.run import Run
import numpy as np
import yaml

_FOREVER = {'sec': 9223372036, 'nsec': 854775807}
_SECOND = 1_000_000_000


def qos_profile(qos: Qos) -> dict[str, Any]:
    """Return a QoS profile as rosbag2 writes it; history and depth are not known to a recorder."""
    return {'history': 'unknown', 'depth': 0, 'reliability': qos.reliability,
            'durability': qos.durability, 'deadline': dict(_FOREVER), 'lifespan': dict(_FOREVER),
            'liveliness': 'automatic', 'liveliness_lease_duration': dict(_FOREVER),
            'avoid_ros_namespace_conventions': False}


class BagWriter:
    """
    Writer of one rosbag2 folder; also a context manager.

    Parameters
    ----------
    folder : path
        The folder to create.
    custom_data : mapping of str to str, optional
        Kept in metadata.yaml, e.g. the scenario and its seed.
    chunk_seconds : float
        The longest span of data (s) that is held in memory; rosbag2_py has a size in its place.
    compressed : bool
        Whether chunks are compressed with zstd.
    sink : callable, optional
        What writes; by default what this machine has.

    Raises
    ------
    InputError
        If the folder exists or cannot be created, or nothing here writes bags.

    """

    def __init__(self, folder: str | os.PathLike[str], *,
                 custom_data: Mapping[str, str] | None = None,
                 chunk_seconds: float = 1.0, compressed: bool = True,
                 sink: Callable[..., Sink] | None = None):
        sink = sink or find_storage().sink
        self.folder = Path(folder)
        self.path = self.folder / f'{self.folder.resolve().name}_0.mcap'
        try:
            self.folder.mkdir(parents=True)
            self.folder.rmdir()     # the sink makes it: rosbag2_py takes none that is there
            self._sink = sink(self.folder.resolve(), custom_data or {}, chunk_seconds, compressed)
        except FileExistsError:
            raise InputError(f'{folder}: exists already; bags are not overwritten: choose another '
                             'name or remove it') from None
        except OSError as error:
            raise InputError(f'{folder}: cannot be created: {error.strerror}') from None

    def add_topic(self, name: str, type_name: str, definition: str | None = None,
                  type_hash: str | None = None, qos: Qos | str = Qos(),
                  encoding: str = 'ros2msg', coding: str = 'cdr') -> None:
        """
        Announce a topic; a topic announced before is left as it is.

        Parameters
        ----------
        name : str
            Resolved name, e.g. ``'/drive/pump_command'``.
        type_name : str
            E.g. ``'geometry_msgs/msg/Vector3Stamped'``.
        definition, type_hash : str, optional
            Looked up in share/ (or the built-in standard types) when left out.
        qos : Qos or str
            What the publisher offers; a str is a YAML text from another bag, kept as it is.
        encoding : str
            Of the definition: 'ros2msg' or 'ros2idl'.
        coding : str
            Of the messages.

        """
        if name in self._sink.counts:
            return
        type_name = full_type(type_name)
        text = qos if isinstance(qos, str) else yaml.safe_dump(
            [qos_profile(qos)], sort_keys=False)
        self._sink.add_topic(Announced(
            name, type_name, find_definition(type_name) if definition is None else definition,
            encoding, find_hash(type_name) if type_hash is None else type_hash,
            text.rstrip('\n'), coding))

    def write(self, name: str, data: bytes, log_time: int,
              publish_time: int | None = None) -> None:
        """
        Append a message.

        Parameters
        ----------
        name : str
            Topic, announced by ``add_topic``.
        data : bytes
            CDR with its 4 bytes of header, as ROS 2 serialises it.
        log_time, publish_time : int
            When it was received and published, ns.

        """
        self._sink.write(name, data, log_time, log_time if publish_time is None else publish_time)

    def flush(self) -> None:
        """Bring what is held in memory to the file; call it now and then on a quiet bag."""
        self._sink.flush()

    @property
    def message_count(self) -> int:
        """Messages written so far."""
        return sum(self._sink.counts.values())

    def counts(self) -> dict[str, int]:
        """Return the number of messages by topic."""
        return dict(self._sink.counts)

    def close(self) -> None:
        """Finish the bag; twice is harmless."""
        self._sink.close()

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def write_run(folder: str | os.PathLike[str], run: Run, *, namespace: str = NAMESPACE,
              start: int = 1_700_000_000 * _SECOND) -> None:
    """
    Write a recording as a bag with the topics of the table; needs no ROS.

    Parameters
    ----------
    folder : path
        The folder to create.
    run : Run
        Channels that no topic carries are left out; samples that are NaN are not written.
    namespace : str
        Of the topics.
    start : int
        Time of the run's t = 0 in the bag, ns since 1970.

    """
    carried: dict[str, tuple[Topic, dict[str, np.ndarray]]] = {}
    for channel, values in run.channels.items():
        if channel in CHANNEL_FIELDS:
            topic, field = CHANNEL_FIELDS[channel]
            columns = carried.setdefault(topic.name, (topic, {}))[1]
            columns[field.path] = field.from_channel(values)
    stamps = start + np.round(run.time * 1e9).astype(np.int64)
    rows: list[tuple[int, int, str, bytes]] = []
    with BagWriter(folder) as bag:
        for order, (topic, columns) in enumerate(carried.values()):
            name = topic.full_name(namespace)
            bag.add_topic(name, topic.type, qos=topic.qos)
            keep = ~np.isnan(np.stack(list(columns.values()))).all(axis=0)
            chosen = {path: values[keep] for path, values in columns.items()}
            chosen['header.stamp.sec'] = stamps[keep] // _SECOND
            chosen['header.stamp.nanosec'] = stamps[keep] % _SECOND
            messages = Codec(topic.type, find_definition(topic.type)).encode_columns(
                _template(topic, columns), chosen)
            rows += [(int(at), order, name, data) for at, data in zip(stamps[keep], messages)]
        for at, _, name, data in sorted(rows, key=lambda row: row[:2]):
            bag.write(name, data, at)


def _template(topic: Topic, columns: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Return the constant part of a topic's messages, sequences at the length they need."""
    template: dict[str, Any] = {'header': {'frame_id': topic.frame}}
    if topic.type == JOINT_STATE:
        template['name'] = [topic.frame]
        template.update({path.partition('[')[0]: [0.0] for path in columns})
    return template
