# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Bags: independent readers accept what is written, and it comes back as it was."""
import tracemalloc

from hst_drive.bag import BagWriter, read_log, write_run
from hst_drive.bag.cdr import Codec
from hst_drive.bag.definitions import find_definition, find_hash, parse_definition
from hst_drive.bag.standard_types import STANDARD_TYPES
from hst_drive.bag.topics import CHANNEL_FIELDS, TOPICS
from hst_drive.errors import InputError
from hst_drive.measure.run import Run
from hypothesis import given, settings, strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_ros2.decoder import DecoderFactory
import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader, StoragePlugin
from rosbags.rosbag2 import Writer as OtherWriter
from rosbags.typesys import get_typestore, Stores
import yaml

from .records import make_run, write_bag

VECTOR = 'geometry_msgs/msg/Vector3Stamped'


def vector(at, x):
    codec = Codec(VECTOR, find_definition(VECTOR))
    return codec.encode({'header': {'stamp': {'sec': at // 10**9, 'nanosec': at % 10**9}},
                         'vector': {'x': x}})


@settings(max_examples=15, deadline=None)
@given(st.data())
def test_a_recording_comes_back(tmp_path_factory, data):
    names = data.draw(st.lists(st.sampled_from(sorted(CHANNEL_FIELDS)), min_size=1, unique=True))
    run = make_run(data.draw(st.integers(10, 40)), data.draw(st.integers(0, 99)), names)
    folder = tmp_path_factory.mktemp('bag') / 'b'
    write_run(folder, run, namespace=data.draw(st.sampled_from(['/drive', '/a/b', '/'])))
    back = read_log(folder)
    np.testing.assert_allclose(back.time, run.time, atol=1e-9)
    assert set(back.channels) == set(names)
    for name in names:
        np.testing.assert_allclose(back[name], run[name], rtol=1e-12, atol=1e-9)
    assert back.notes == ()


def test_missing_samples_stay_missing(tmp_path):
    run = make_run(100)
    run['motor_speed'][30:50] = np.nan
    run['pump_command'][:10] = np.nan
    write_run(tmp_path / 'b', run)
    back = read_log(tmp_path / 'b')
    np.testing.assert_array_equal(np.isnan(back['motor_speed']), np.isnan(run['motor_speed']))
    np.testing.assert_array_equal(np.isnan(back['pump_command']), np.isnan(run['pump_command']))


@pytest.mark.parametrize('compressed', [True, False])
def test_independent_readers_accept_the_folder(tmp_path, compressed):
    folder = tmp_path / 'b'
    with BagWriter(folder, custom_data={'scenario': 'step'}, compressed=compressed) as bag:
        for topic in TOPICS.values():
            bag.add_topic(topic.full_name(), topic.type, qos=topic.qos)
        for index in range(500):
            at = 10**18 + index * 10**7
            bag.write('/drive/pump_command', vector(at, index), at, at - 1000)
    with Reader(folder) as reader:
        assert reader.message_count == 500
        assert {c.topic: c.msgtype for c in reader.connections} == {
            topic.full_name(): topic.type for topic in TOPICS.values()}
        for connection in reader.connections:
            assert connection.digest.startswith('RIHS01_')
            assert connection.ext.offered_qos_profiles[0].reliability.name == 'RELIABLE'
    metadata = yaml.safe_load((folder / 'metadata.yaml').read_text())
    assert metadata['rosbag2_bagfile_information']['version'] == 9
    assert metadata['rosbag2_bagfile_information']['custom_data'] == {'scenario': 'step'}
    with AnyReader([folder]) as reader:
        read = [(at, reader.deserialize(raw, connection.msgtype).vector.x)
                for connection, at, raw in reader.messages()]
    assert read == [(10**18 + i * 10**7, float(i)) for i in range(500)]
    with open(folder / 'b_0.mcap', 'rb') as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == 'ros2'
        decoded = [m.decoded_message.vector.x for m in reader.iter_decoded_messages()]
        summary = reader.get_summary()
        assert [m.name for m in reader.iter_metadata()] == ['rosbag2', 'rosbag2']
    assert decoded == list(map(float, range(500)))
    assert len(summary.chunk_indexes) == 5
    assert all(index.message_index_offsets for index in summary.chunk_indexes)
    assert {schema.encoding for schema in summary.schemas.values()} == {'ros2msg'}


def test_definitions_are_those_of_the_other_type_store():
    store = get_typestore(Stores.ROS2_JAZZY)
    for topic in TOPICS.values():
        text, _ = store.generate_msgdef(topic.type, ros_version=2)
        ours = parse_definition(topic.type, find_definition(topic.type))
        assert ours == parse_definition(topic.type, text)
        assert find_hash(topic.type) == store.hash_rihs01(topic.type)


def test_the_built_in_definitions_are_those_of_the_other_type_store():
    store = get_typestore(Stores.ROS2_JAZZY)
    for kind, (text, digest) in STANDARD_TYPES.items():
        other = parse_definition(kind, store.generate_msgdef(kind, ros_version=2)[0])
        assert parse_definition(kind, text)[kind] == other[kind]
        assert digest == store.hash_rihs01(kind)


def test_an_existing_folder_is_not_overwritten(tmp_path):
    with pytest.raises(InputError, match='exists already'):
        BagWriter(tmp_path)


@pytest.mark.parametrize('plugin', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_bags_of_another_writer_are_read(tmp_path, plugin):
    store = get_typestore(Stores.ROS2_JAZZY)
    kind = store.types[VECTOR]
    header, time, three = (store.types[name] for name in (
        'std_msgs/msg/Header', 'builtin_interfaces/msg/Time', 'geometry_msgs/msg/Vector3'))
    with OtherWriter(tmp_path / 'b', version=9, storage_plugin=plugin) as bag:
        connection = bag.add_connection('/rig/pump_command', VECTOR, typestore=store)
        for index in range(50):
            message = kind(header(time(5, index * 10**7), 'p'), three(float(index), 0.0, 0.0))
            bag.write(connection, 7 * 10**9 + index, store.serialize_cdr(message, VECTOR))
    run = read_log(tmp_path / 'b')
    np.testing.assert_allclose(run.time, np.arange(50) * 0.01, atol=1e-9)
    np.testing.assert_array_equal(run['pump_command'], np.arange(50.0))


@pytest.mark.parametrize('compression', list(CompressionType))
@pytest.mark.parametrize('chunked', [True, False])
def test_lone_files_of_the_format_s_own_writer_are_read(tmp_path, compression, chunked):
    path = tmp_path / 'lone.mcap'
    with open(path, 'wb') as file:
        writer = Writer(file, chunk_size=2000, compression=compression, use_chunking=chunked)
        writer.start()
        schema = writer.register_schema(VECTOR, 'ros2msg', find_definition(VECTOR).encode())
        channel = writer.register_channel('/pump_command', 'cdr', schema)
        for index in range(100):
            at = 10**18 + index * 10**7
            writer.add_message(channel, at, vector(at, index), at)
        writer.finish()
    np.testing.assert_array_equal(read_log(path)['pump_command'], np.arange(100.0))


def test_split_bags_are_joined(tmp_path):
    run = make_run(400)
    first, second = run.between(0, 2), run.between(2, 9)
    write_run(tmp_path / 'b', first)
    write_run(tmp_path / 'c', Run('c', second.time, second.channels))
    (tmp_path / 'c' / 'c_0.mcap').rename(tmp_path / 'b' / 'b_1.mcap')
    text = (tmp_path / 'b' / 'metadata.yaml').read_text()
    (tmp_path / 'b' / 'metadata.yaml').write_text(text.replace(
        '  - b_0.mcap\n', '  - b_0.mcap\n  - b_1.mcap\n'))
    assert len(read_log(tmp_path / 'b')) == 400


def test_a_folder_without_metadata_is_read_with_a_note(tmp_path):
    write_run(tmp_path / 'b', make_run())
    (tmp_path / 'b' / 'metadata.yaml').unlink()
    run = read_log(tmp_path / 'b')
    assert len(run) == 400
    assert any('metadata.yaml is missing' in note for note in run.notes)


def test_two_drives_in_one_bag_need_a_choice(tmp_path):
    times = [10**18 + i * 10**7 for i in range(20)]
    folder = write_bag(tmp_path / 'b', {
        f'/{name}/pump_command': (VECTOR, [(at, vector(at, x)) for at in times])
        for name, x in (('a', 1.0), ('b', 2.0))})
    with pytest.raises(InputError, match='several drives.*/a, /b.*--channels'):
        read_log(folder)
    (tmp_path / 'map.yaml').write_text('namespace: /b\n')
    assert read_log(folder, tmp_path / 'map.yaml')['pump_command'][0] == 2.0


def test_a_bag_with_none_of_our_topics_says_what_it_holds(tmp_path):
    folder = write_bag(tmp_path / 'b', {'/cmd_vel': (VECTOR, [(10**18, vector(1, 1.0))])})
    with pytest.raises(InputError, match=r'none of our topics is.*/cmd_vel \(.*--channels') as why:
        read_log(folder)
    assert '\n' not in str(why.value)


def test_a_topic_of_another_type_is_left_out_with_a_note(tmp_path):
    times = [10**18 + i * 10**7 for i in range(20)]
    kind = 'sensor_msgs/msg/Temperature'
    folder = write_bag(tmp_path / 'b', {
        '/drive/pump_command': (VECTOR, [(at, vector(at, 1.0)) for at in times]),
        '/drive/pprv_command': (kind, [(at, b'') for at in times])})
    run = read_log(folder)
    assert list(run.channels) == ['pump_command']
    assert any('/drive/pprv_command: is sensor_msgs' in note for note in run.notes)


@pytest.mark.parametrize('content, said', [
    ({}, 'this directory is no bag'),
    ({'metadata.yaml': 'a: 1'}, 'not the metadata of a bag'),
    ({'metadata.yaml': '{'}, 'cannot be read as YAML'),
    ({'metadata.yaml': 'rosbag2_bagfile_information: {relative_file_paths: [x.mcap]}'},
     'names x.mcap, which is not there'),
    ({'x.mcap.zstd': 'junk'}, 'x.mcap.zstd: damaged: cannot be decompressed'),
    ({'x.mcap': 'hello'}, 'not an MCAP file'),
    ({'x.db3': 'hello' * 99}, 'no sqlite3 bag'),
])
def test_folders_that_are_no_bags(tmp_path, content, said):
    for name, text in content.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=said):
        read_log(tmp_path)


def test_a_flipped_bit_is_noticed(tmp_path):
    write_run(tmp_path / 'b', make_run())
    path = tmp_path / 'b' / 'b_0.mcap'
    data = bytearray(path.read_bytes())
    data[len(data) // 4] ^= 4
    path.write_bytes(data)
    with pytest.raises(InputError, match='damaged .*hst-drive recover'):
        read_log(tmp_path / 'b')


def test_a_long_recording_keeps_little_of_what_it_has_written(tmp_path):
    """A chunk costs the bytes of its index; that the file's end holds them all is read back."""
    names, data = [f'/t{place}' for place in range(20)], vector(0, 1.0)
    with BagWriter(tmp_path / 'b') as bag:
        for name in names:
            bag.add_topic(name, VECTOR)
        tracemalloc.start()
        try:
            for second in range(600):
                for name in names:
                    bag.write(name, data, second * 10**9)
                bag.flush()
                if second == 99:
                    before = tracemalloc.get_traced_memory()[0]
            grown = tracemalloc.get_traced_memory()[0] - before
        finally:
            tracemalloc.stop()
    # 20 topics of 10 bytes and 83 more; the buffer of BytesIO grows in steps of an eighth.
    assert grown / 500 < 1.3 * (20 * 10 + 83)
    with open(bag.path, 'rb') as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert len(reader.get_summary().chunk_indexes) == 600
        found = [message.log_time for _, _, message in reader.iter_messages(topics=['/t7'])]
    assert found == [second * 10**9 for second in range(600)]
