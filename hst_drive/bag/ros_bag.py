# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
MCAP files through rosbag2_py, which comes with ROS 2.

It tells the time at which a message was received, not the one at which it was published, and
neither checks a chunk's checksum nor says when it stopped at damage: what came is counted.
"""
from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
import errno
from pathlib import Path
import shutil
from tempfile import NamedTemporaryFile

from hst_drive.bag.storage import Announced
from hst_drive.bag.stream import BLOCK, Stream
from hst_drive.errors import InputError
import rosbag2_py
import yaml

_DAMAGE = (RuntimeError, ValueError, IndexError, MemoryError, OverflowError)
# What C++ throws comes as these.
_CHUNK = 1 << 16    # bytes: 0.3 s of a drive's 22 topics at 100 Hz, lost if the recorder is killed
_ROOM = 1 << 20     # bytes on the disk, several chunks and the end of the file
_QOS_VERSION = 9    # of the metadata since which QoS have names


def read_streams(path: Path, wanted: Callable[[str], bool]) -> Iterator[list[Stream]]:
    """
    Yield the messages of the wanted topics of a finished file, block by block.

    All topics come each time, with new messages or without.

    Raises
    ------
    InputError
        If the file is damaged, or is no MCAP file.

    """
    try:
        yield from _blocks(path, wanted)
    except _DAMAGE as error:
        why = ' '.join(str(error).split()) or 'wrong lengths'
        raise InputError(f'{path}: damaged or no MCAP file ({why})') from None


def _blocks(path: Path, wanted: Callable[[str], bool]) -> Iterator[list[Stream]]:
    reader = rosbag2_py.SequentialReader()
    reader.open(rosbag2_py.StorageOptions(uri=str(path), storage_id='mcap'),
                rosbag2_py.ConverterOptions('', ''))
    reader.set_read_order(rosbag2_py.ReadOrder(rosbag2_py.ReadOrderSortBy.File, False))
    texts = {entry.topic_type: entry for entry in reader.get_all_message_definitions()}
    streams: dict[str, Stream] = {}
    stated: Counter[str] = Counter()
    for entry in reader.get_metadata().topics_with_message_count:
        topic = entry.topic_metadata
        text = texts[topic.type]
        stream = streams.setdefault(topic.name, Stream(
            topic.name, topic.type, text.encoded_message_definition, text.encoding,
            topic.serialization_format, {}))
        stated[topic.name] += entry.message_count
        if stream.type != topic.type and wanted(topic.name):
            raise InputError(f'{path}: {topic.name} is of two types, {stream.type} and '
                             f'{topic.type}; leave the topic out of the channel map')
    chosen = set(filter(wanted, streams))
    if chosen:
        reader.set_filter(rosbag2_py.StorageFilter(topics=sorted(chosen)))
    taken = 0
    while chosen and reader.has_next():
        name, data, at = reader.read_next()
        if name not in chosen:
            continue    # events of services pass the filter
        stream = streams[name]
        stream.data.append(data)
        stream.log_time.append(at)
        stream.publish_time.append(at)
        stream.order.append(taken)
        stated[name] -= 1
        taken += 1
        if taken % BLOCK == 0:
            yield list(streams.values())
            streams = {name: stream.emptied() for name, stream in streams.items()}
    missing = sum(stated[name] for name in chosen)
    if missing:
        raise InputError(f'{path}: damaged: {missing} of the messages that it states cannot be '
                         'read')
    yield list(streams.values())


@contextmanager
def _as_os_error() -> Iterator[None]:
    try:
        yield
    except RuntimeError as error:
        raise OSError(errno.EIO, ' '.join(str(error).split())) from None


class RosSink:
    """One bag that is written by rosbag2_py; ``storage.Sink`` says more."""

    def __init__(self, folder: Path, custom_data: Mapping[str, str], chunk_seconds: float,
                 compressed: bool):
        self.counts: dict[str, int] = {}
        self._folder = folder
        self._writer = rosbag2_py.SequentialWriter()
        with NamedTemporaryFile('w', prefix='hst_drive_', suffix='.yaml') as config:
            yaml.safe_dump({'compression': 'Zstd' if compressed else 'None', 'chunkSize': _CHUNK,
                            'compressionLevel': 'Fastest', 'noChunkCRC': False}, config)
            config.flush()
            with _as_os_error():
                self._writer.open(
                    rosbag2_py.StorageOptions(
                        uri=str(folder), storage_id='mcap', storage_config_uri=config.name,
                        custom_data=dict(custom_data)),
                    rosbag2_py.ConverterOptions('cdr', 'cdr'))

    def add_topic(self, topic: Announced) -> None:
        """Announce a topic; rosbag2_py looks the definition up itself."""
        with _as_os_error():
            self._writer.create_topic(rosbag2_py.TopicMetadata(
                id=len(self.counts), name=topic.name, type=topic.type,
                serialization_format='cdr',
                offered_qos_profiles=rosbag2_py.to_rclcpp_qos_vector(
                    topic.profiles, _QOS_VERSION),
                type_description_hash=topic.type_hash))
        self.counts[topic.name] = 0

    def write(self, name: str, data: bytes, log_time: int, publish_time: int) -> None:
        """Append a message."""
        with _as_os_error():
            self._writer.write(name, data, log_time, publish_time)
        self.counts[name] += 1

    def flush(self) -> None:
        """Say when the disk is full, which rosbag2_py does not; it has no way to flush."""
        if shutil.disk_usage(self._folder).free < _ROOM:
            raise OSError(errno.ENOSPC, 'No space left on device')

    def close(self) -> None:
        """Finish the bag; twice is harmless."""
        with _as_os_error():
            self._writer.close()
