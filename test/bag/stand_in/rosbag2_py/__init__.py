# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What of ROS 2 Jazzy's rosbag2_py (0.26) can be had without ROS, over pip's mcap.

Names, arguments (those without a name in the bindings are positional only), types that the
bindings take, and failures (RuntimeError) are its own; so is what it writes.
"""
from enum import Enum
import os
from pathlib import Path
import struct

from mcap.exceptions import McapError
from mcap.reader import make_reader, NonSeekingReader
from mcap.writer import CompressionType, Writer
import yaml


class _Record:
    """A class of the bindings: fields with types, as keywords or in order."""

    fields = {}     # name -> (type, default); a field without a default: (type,)

    def __init__(self, *values, **named):
        given = dict(zip(self.fields, values, strict=False)) | named
        if set(given) - set(self.fields) or len(values) > len(self.fields):
            raise TypeError('incompatible constructor arguments')
        for name, (kind, *default) in self.fields.items():
            if name not in given and not default:
                raise TypeError('incompatible constructor arguments')
            setattr(self, name, _typed(given.get(name, *default), kind))


def _typed(value, kind):
    if not isinstance(value, kind):
        raise TypeError(f'incompatible function arguments: {value!r} is no {kind}')
    return value


class ConverterOptions(_Record):
    fields = {'input_serialization_format': (str, ''), 'output_serialization_format': (str, '')}


class StorageOptions(_Record):
    fields = {
        'uri': (str,), 'storage_id': (str, ''), 'max_bagfile_size': (int, 0),
        'max_bagfile_duration': (int, 0), 'max_cache_size': (int, 0),
        'storage_preset_profile': (str, ''), 'storage_config_uri': (str, ''),
        'snapshot_mode': (bool, False), 'start_time_ns': (int, -1), 'end_time_ns': (int, -1),
        'custom_data': (dict, {})}


class StorageFilter(_Record):
    fields = {
        'topics': (list, []), 'services_events': (list, []), 'regex': (str, ''),
        'exclude_topics': (list, []), 'exclude_service_events': (list, []),
        'regex_to_exclude': (str, '')}


class TopicMetadata(_Record):
    fields = {
        'id': (int,), 'name': (str,), 'type': (str,), 'serialization_format': (str,),
        'offered_qos_profiles': (list, []), 'type_description_hash': (str, '')}


class TopicInformation(_Record):
    fields = {'topic_metadata': (TopicMetadata,), 'message_count': (int,)}


class MessageDefinition(_Record):
    fields = {'topic_type': (str,), 'encoding': (str,), 'encoded_message_definition': (str,),
              'type_hash': (str,)}


class BagMetadata(_Record):
    fields = {'version': (int, 9), 'message_count': (int, 0),
              'topics_with_message_count': (list, [])}


ReadOrderSortBy = Enum('ReadOrderSortBy', ['ReceivedTimestamp', 'PublishedTimestamp', 'File'])


class ReadOrder(_Record):
    fields = {'sort_by': (ReadOrderSortBy, ReadOrderSortBy.ReceivedTimestamp),
              'reverse': (bool, False)}


def to_rclcpp_qos_vector(serialized, version, /):
    _typed(version, int)
    if not _typed(serialized, str):
        return []
    profiles = yaml.safe_load(serialized)
    if any(profile['reliability'] not in ('reliable', 'best_effort') for profile in profiles):
        raise RuntimeError('bad conversion')
    return profiles


class SequentialReader:
    """Reads a lone MCAP file; not its folders."""

    def __init__(self):
        self._file = None

    def open(self, options, converter, /):
        _typed(converter, ConverterOptions)
        if Path(_typed(options, StorageOptions).uri).is_dir():
            raise RuntimeError('the stand-in reads single files')
        try:
            self._file = open(options.uri, 'rb')
            self._summary = make_reader(self._file).get_summary()
        except (OSError, McapError, struct.error) as error:
            raise RuntimeError(str(error)) from None
        if any(channel.schema_id not in self._summary.schemas
               for channel in self._summary.channels.values()):
            raise RuntimeError('Could not find schema for topic')
        self._filter, self._order = [], ReadOrderSortBy.ReceivedTimestamp
        self._restart()

    def set_read_order(self, order, /):
        self._order = _typed(order, ReadOrder).sort_by
        self._restart()
        return True

    def set_filter(self, chosen, /):
        self._filter = _typed(chosen, StorageFilter).topics
        self._restart()

    def get_metadata(self):
        counts = self._summary.statistics.channel_message_counts
        topics = [TopicInformation(TopicMetadata(
            number, channel.topic, self._summary.schemas[channel.schema_id].name,
            channel.message_encoding), counts.get(number, 0))
            for number, channel in self._summary.channels.items()]
        return BagMetadata(message_count=self._summary.statistics.message_count,
                           topics_with_message_count=topics)

    def get_all_topics_and_types(self):
        return [entry.topic_metadata for entry in self.get_metadata().topics_with_message_count]

    def get_all_message_definitions(self):
        return [MessageDefinition(schema.name, schema.encoding, schema.data.decode(), '')
                for schema in self._summary.schemas.values()]

    def has_next(self):
        if self._next is None:
            try:
                self._next = next(self._messages, None)
            except Exception:
                return False    # it logs the problem, and that is all
        return self._next is not None

    def read_next(self):
        if not self.has_next():
            raise RuntimeError('Bag is at end. No next message.')
        (_, channel, message), self._next = self._next, None
        return channel.topic, message.data, message.log_time

    def _restart(self):
        self._file.seek(0)
        in_file = self._order is ReadOrderSortBy.File
        reader = NonSeekingReader(self._file) if in_file else make_reader(self._file)
        self._messages = iter(reader.iter_messages(
            topics=self._filter or None, log_time_order=not in_file))
        self._next = None


class SequentialWriter:
    """Writes a folder with one MCAP file."""

    def __init__(self):
        self._file = None

    def open(self, options, converter, /):
        _typed(converter, ConverterOptions)
        folder = Path(_typed(options, StorageOptions).uri)
        if folder.is_dir():
            raise RuntimeError(f"Bag directory already exists ({folder}), can't overwrite "
                               'existing bag')
        config = {}
        if options.storage_config_uri:
            config = yaml.safe_load(Path(options.storage_config_uri).read_text())
        folder.mkdir(parents=True)
        self._options, self._folder = options, folder
        self._file = open(folder / f'{folder.name}_0.mcap', 'wb')
        self._writer = Writer(self._file, chunk_size=config.get('chunkSize', 768 * 1024),
                              compression=CompressionType[
                                  config.get('compression', 'None').upper()],
                              enable_crcs=not config.get('noChunkCRC', True))
        self._writer.start('ros2', 'stand-in')
        self._topics, self._channels, self._times = {}, {}, []

    def create_topic(self, topic, /):
        name = _typed(topic, TopicMetadata).name
        if name in self._topics:
            return
        self._topics[name] = TopicInformation(topic, 0)
        # rosbag2 looks for the definition in share/, as this does.
        from hst_drive.bag.definitions import find_definition
        schema = self._writer.register_schema(topic.type, 'ros2msg',
                                              find_definition(topic.type).encode())
        self._channels[name] = self._writer.register_channel(
            name, topic.serialization_format, schema,
            {'offered_qos_profiles': yaml.safe_dump(topic.offered_qos_profiles),
             'topic_type_hash': topic.type_description_hash})

    def write(self, name, data, received, sent=None, /):
        _typed(received, int), _typed(data, bytes)
        if self._file is None:
            raise RuntimeError('Bag is not open. Call open() before writing.')
        if name not in self._topics:
            raise RuntimeError(f"Failed to write on topic '{name}'. Call create_topic() before "
                               'first write.')
        self._writer.add_message(self._channels[name], received, data,
                                 received if sent is None else _typed(sent, int))
        self._topics[name].message_count += 1
        self._times = [min([*self._times, received]), max([*self._times, received])]

    def close(self):
        if self._file is None:
            return
        self._writer.finish()
        self._file.close()
        path, self._file = Path(self._file.name).name, None
        count = sum(entry.message_count for entry in self._topics.values())
        start, end = self._times or (0, 0)
        span = {'duration': {'nanoseconds': end - start},
                'starting_time': {'nanoseconds_since_epoch': start}, 'message_count': count}
        (self._folder / 'metadata.yaml').write_text(yaml.safe_dump({
            'rosbag2_bagfile_information': {
                'version': 9, 'storage_identifier': 'mcap', **span,
                'topics_with_message_count': [
                    {'topic_metadata': {key: value for key, value in
                                        vars(entry.topic_metadata).items() if key != 'id'},
                     'message_count': entry.message_count} for entry in self._topics.values()],
                'compression_format': '', 'compression_mode': '', 'relative_file_paths': [path],
                'files': [{'path': path, **span}],
                'custom_data': self._options.custom_data or None,
                'ros_distro': os.environ.get('ROS_DISTRO', '')}}, sort_keys=False))
