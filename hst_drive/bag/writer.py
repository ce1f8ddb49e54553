# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Writing rosbag2 folders: metadata.yaml (version 9) and an MCAP file, as ROS 2 Jazzy writes them.

Chunks are compressed (zstd), carry a checksum and an index, and are on disk after at most a
second of data, so that a recorder that is killed leaves nearly everything.
"""
from __future__ import annotations

from collections.abc import Iterator, Mapping
import os
from pathlib import Path
from typing import Any

from hst_drive.bag.cdr import Codec
from hst_drive.bag.definitions import find_definition, find_hash, full_type
from hst_drive.bag.topics import CHANNEL_FIELDS, JOINT_STATE, NAMESPACE, Qos, Topic
from hst_drive.errors import InputError
from hst_drive.measure.run import Run
from mcap.data_stream import RecordBuilder
from mcap.records import ChunkIndex
from mcap.writer import CompressionType, Writer
import numpy as np
import yaml

_FOREVER = {'sec': 9223372036, 'nsec': 854775807}
_SECOND = 1_000_000_000


class _ChunkIndexes:
    """
    Where the chunks of a file lie, as the bytes that its end will hold.

    It takes the place of the list in which mcap's writer keeps an object for each chunk: 2.2 kB
    a second in a recording of 22 topics, 8 MB in an hour. As bytes it is 0.3 kB.
    """

    def __init__(self):
        self._packed = RecordBuilder()

    def append(self, index: ChunkIndex) -> None:
        """Take the index of one chunk."""
        index.write(self._packed)

    def __iter__(self) -> Iterator[_ChunkIndexes]:
        return iter([self])

    def write(self, builder: RecordBuilder) -> None:
        """Write all of them, once, at the end of the file."""
        builder.write(self._packed.end())


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
        The longest span of data (s) that is held in memory.
    compressed : bool
        Whether chunks are compressed with zstd.

    Raises
    ------
    InputError
        If the folder exists or cannot be created.

    """

    def __init__(self, folder: str | os.PathLike[str], *,
                 custom_data: Mapping[str, str] | None = None,
                 chunk_seconds: float = 1.0, compressed: bool = True):
        self.folder = Path(folder)
        self.path = self.folder / f'{self.folder.resolve().name}_0.mcap'
        self.custom_data = dict(custom_data or {})
        try:
            self.folder.mkdir(parents=True)
        except FileExistsError:
            raise InputError(f'{folder}: exists already; bags are not overwritten: choose another '
                             'name or remove it') from None
        except OSError as error:
            raise InputError(f'{folder}: cannot be created: {error.strerror}') from None
        self._file = open(self.path, 'wb')
        self._writer = Writer(self._file, chunk_size=1 << 20, compression=(
            CompressionType.ZSTD if compressed else CompressionType.NONE))
        # No public way leads there.
        self._writer._Writer__chunk_indices = _ChunkIndexes()
        self._writer.start(profile='ros2', library='hst_drive')
        self._chunk_time = int(chunk_seconds * _SECOND)
        self._chunk_start: int | None = None
        self._start: int | None = None
        self._end = 0
        self._schemas: dict[tuple[str, str], int] = {}
        self._ids: dict[str, int] = {}
        self._counts: dict[str, int] = {}
        self._topics: dict[str, dict[str, Any]] = {}
        self._write_metadata_record()
        self._writer.flush()

    def add_topic(self, name: str, type_name: str, definition: str | None = None,
                  type_hash: str | None = None, qos: Qos | str = Qos(),
                  encoding: str = 'ros2msg') -> None:
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

        """
        if name in self._ids:
            return
        type_name = full_type(type_name)
        if definition is None:
            definition = find_definition(type_name)
        if type_hash is None:
            type_hash = find_hash(type_name)
        profiles = yaml.safe_load(qos) if isinstance(qos, str) else [qos_profile(qos)]
        key = (type_name, definition)
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(
                type_name, encoding, definition.encode())
        text = qos if isinstance(qos, str) else yaml.safe_dump(profiles, sort_keys=False)
        self._ids[name] = self._writer.register_channel(
            name, 'cdr', self._schemas[key],
            {'offered_qos_profiles': text.rstrip('\n'), 'topic_type_hash': type_hash})
        self._counts[name] = 0
        self._topics[name] = {
            'name': name, 'type': type_name, 'serialization_format': 'cdr',
            'offered_qos_profiles': profiles or [], 'type_description_hash': type_hash}

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
        if self._start is None:
            self._start = self._end = log_time
        if self._chunk_start is None:
            self._chunk_start = log_time
        elif not -self._chunk_time < log_time - self._chunk_start < self._chunk_time:
            self._writer.flush()
            self._chunk_start = log_time
        self._start = min(self._start, log_time)
        self._end = max(self._end, log_time)
        self._counts[name] += 1
        self._writer.add_message(self._ids[name], log_time, data,
                                 log_time if publish_time is None else publish_time)

    def flush(self) -> None:
        """Bring what is held in memory to the file; call it now and then on a quiet bag."""
        self._writer.flush()
        self._chunk_start = None

    @property
    def message_count(self) -> int:
        """Messages written so far."""
        return sum(self._counts.values())

    def counts(self) -> dict[str, int]:
        """Return the number of messages by topic."""
        return dict(self._counts)

    def close(self) -> None:
        """Finish the MCAP file and write metadata.yaml, in that order; twice is harmless."""
        if self._file.closed:
            return
        self._write_metadata_record()
        self._writer.finish()
        self._file.close()
        text = yaml.safe_dump({'rosbag2_bagfile_information': self._metadata()}, sort_keys=False)
        partial = self.folder / '.metadata.yaml.part'
        partial.write_text(text, encoding='utf-8')
        os.replace(partial, self.folder / 'metadata.yaml')

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _write_metadata_record(self) -> None:
        text = yaml.safe_dump(self._metadata(), sort_keys=False)
        self._writer.add_metadata('rosbag2', {'serialized_metadata': text})

    def _metadata(self) -> dict[str, Any]:
        start = {'nanoseconds_since_epoch': self._start or 0}
        duration = {'nanoseconds': self._end - (self._start or 0)}
        return {
            'version': 9, 'storage_identifier': 'mcap', 'duration': duration,
            'starting_time': start, 'message_count': self.message_count,
            'topics_with_message_count': [
                {'topic_metadata': topic, 'message_count': self._counts[name]}
                for name, topic in self._topics.items()],
            'compression_format': '', 'compression_mode': '',
            'relative_file_paths': [self.path.name],
            'files': [{'path': self.path.name, 'starting_time': dict(start),
                       'duration': dict(duration), 'message_count': self.message_count}],
            'custom_data': self.custom_data or None, 'ros_distro': 'jazzy'}


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
