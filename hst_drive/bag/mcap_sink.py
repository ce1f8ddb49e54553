# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Writing the MCAP file and metadata.yaml (version 9) of a bag with pip's mcap, as Jazzy does.

Chunks are compressed (zstd), carry a checksum and an index, and are on disk after at most a
second of data, so that a recorder that is killed leaves nearly everything.
"""
from __future__ import annotations

from collections.abc import Iterator, Mapping
import os
from pathlib import Path
from typing import Any

from hst_drive.bag.storage import Announced
from mcap.data_stream import RecordBuilder
from mcap.records import ChunkIndex
from mcap.writer import CompressionType, Writer
import yaml

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


class McapSink:
    """One bag that is written by pip's mcap; ``storage.Sink`` says more."""

    def __init__(self, folder: Path, custom_data: Mapping[str, str], chunk_seconds: float,
                 compressed: bool):
        self.counts: dict[str, int] = {}
        self._folder, self._custom_data = folder, dict(custom_data)
        self._name = f'{folder.name}_0.mcap'
        folder.mkdir()
        self._file = open(folder / self._name, 'wb')
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
        self._topics: dict[str, dict[str, Any]] = {}
        self._write_metadata_record()
        self._writer.flush()

    def add_topic(self, topic: Announced) -> None:
        """Announce a topic."""
        key = (topic.type, topic.definition)
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(
                topic.type, topic.encoding, topic.definition.encode('utf-8', 'surrogateescape'))
        self._ids[topic.name] = self._writer.register_channel(
            topic.name, topic.coding, self._schemas[key],
            {'offered_qos_profiles': topic.profiles, 'topic_type_hash': topic.type_hash})
        self.counts[topic.name] = 0
        self._topics[topic.name] = {
            'name': topic.name, 'type': topic.type, 'serialization_format': topic.coding,
            'offered_qos_profiles': yaml.safe_load(topic.profiles) or [],
            'type_description_hash': topic.type_hash}

    def write(self, name: str, data: bytes, log_time: int, publish_time: int) -> None:
        """Append a message."""
        if self._start is None:
            self._start = self._end = log_time
        if self._chunk_start is None:
            self._chunk_start = log_time
        elif not -self._chunk_time < log_time - self._chunk_start < self._chunk_time:
            self._writer.flush()
            self._chunk_start = log_time
        self._start = min(self._start, log_time)
        self._end = max(self._end, log_time)
        self.counts[name] += 1
        self._writer.add_message(self._ids[name], log_time, data, publish_time)

    def flush(self) -> None:
        """Bring what is held in memory to the file."""
        self._writer.flush()
        self._chunk_start = None

    def close(self) -> None:
        """Finish the MCAP file and write metadata.yaml, in that order; twice is harmless."""
        if self._file.closed:
            return
        self._write_metadata_record()
        self._writer.finish()
        self._file.close()
        text = yaml.safe_dump({'rosbag2_bagfile_information': self._metadata()}, sort_keys=False)
        partial = self._folder / '.metadata.yaml.part'
        partial.write_text(text, encoding='utf-8')
        os.replace(partial, self._folder / 'metadata.yaml')

    def _write_metadata_record(self) -> None:
        text = yaml.safe_dump(self._metadata(), sort_keys=False)
        self._writer.add_metadata('rosbag2', {'serialized_metadata': text})

    def _metadata(self) -> dict[str, Any]:
        start = {'nanoseconds_since_epoch': self._start or 0}
        duration = {'nanoseconds': self._end - (self._start or 0)}
        return {
            'version': 9, 'storage_identifier': 'mcap', 'duration': duration,
            'starting_time': start, 'message_count': sum(self.counts.values()),
            'topics_with_message_count': [
                {'topic_metadata': topic, 'message_count': self.counts[name]}
                for name, topic in self._topics.items()],
            'compression_format': '', 'compression_mode': '',
            'relative_file_paths': [self._name],
            'files': [{'path': self._name, 'starting_time': dict(start),
                       'duration': dict(duration), 'message_count': sum(self.counts.values())}],
            'custom_data': self._custom_data or None, 'ros_distro': 'jazzy'}
