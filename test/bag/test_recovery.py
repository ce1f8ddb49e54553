# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A recorder that is killed, and files that are cut: what is there can be saved."""
import os
from pathlib import Path
import signal
import struct
import subprocess
import sys

from hst_drive.bag import BagWriter, read_log, recover, write_run
from hst_drive.bag.mcap_bag import salvage_streams
from hst_drive.errors import InputError
from hypothesis import given, settings, strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer
import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from .records import make_run

ROOT = Path(__file__).parents[2]
RECORDER = """
import sys
from hst_drive.bag import BagWriter
from hst_drive.bag.cdr import Codec
from hst_drive.bag.definitions import find_definition
kind = 'geometry_msgs/msg/Vector3Stamped'
codec = Codec(kind, find_definition(kind))
bag = BagWriter(sys.argv[1])
bag.add_topic('/drive/pump_command', kind)
index = 0
while True:
    at = 10**18 + index * 10**7
    bag.write('/drive/pump_command', codec.encode({
        'header': {'stamp': {'sec': at // 10**9, 'nanosec': at % 10**9}},
        'vector': {'x': float(index)}}), at)
    index += 1
    if index % 1000 == 0:
        print(index, flush=True)
"""


def test_a_killed_recorder_loses_at_most_a_second_of_data(tmp_path):
    folder = tmp_path / 'killed'
    process = subprocess.Popen(
        [sys.executable, '-c', RECORDER, str(folder)], stdout=subprocess.PIPE, text=True,
        env={**os.environ, 'PYTHONPATH': str(ROOT)})
    written = 0
    while written < 5000:
        written = int(process.stdout.readline())
    process.send_signal(signal.SIGKILL)
    process.communicate()
    with pytest.raises(InputError, match='cut off .* messages can be read; save them with: '
                                         f'hst-drive recover {folder} -o {folder}_recovered'):
        read_log(folder)
    found = recover(folder, tmp_path / 'saved')
    assert found.messages >= written - 100
    assert found.damaged == 0
    run = read_log(tmp_path / 'saved')
    np.testing.assert_array_equal(run['pump_command'], np.arange(found.messages, dtype=float))
    with Reader(tmp_path / 'saved') as reader:
        assert reader.message_count == found.messages


@settings(max_examples=25, deadline=None)
@given(share=st.floats(0.001, 0.999))
def test_a_cut_file_is_told_and_its_whole_part_saved(tmp_path_factory, share):
    tmp_path = tmp_path_factory.mktemp('cut')
    run = make_run(600)
    write_run(tmp_path / 'b', run)
    path = tmp_path / 'b' / 'b_0.mcap'
    data = path.read_bytes()
    path.write_bytes(data[:int(len(data) * share)])
    with pytest.raises(InputError) as why:
        read_log(tmp_path / 'b')
    assert '\n' not in str(why.value)
    if 'save them' not in str(why.value):
        assert 'nothing can be read' in str(why.value) or 'not an MCAP' in str(why.value)
        return
    recover(tmp_path / 'b', tmp_path / 'saved')
    back = read_log(tmp_path / 'saved')
    for name in back.channels:
        np.testing.assert_allclose(back[name], run[name][:len(back)], rtol=1e-12, atol=1e-9)


def test_the_chunks_beside_a_damaged_one_are_saved(tmp_path):
    run = make_run(1000)
    write_run(tmp_path / 'b', run)
    path = tmp_path / 'b' / 'b_0.mcap'
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 255
    path.write_bytes(data)
    found = recover(path, tmp_path / 'saved')
    assert found.damaged == 1
    assert found.messages == 6 * 900
    back = read_log(tmp_path / 'saved')
    assert len(back) == 900


def test_a_whole_bag_is_recovered_as_it_was(tmp_path):
    run = make_run()
    write_run(tmp_path / 'b', run)
    recover(tmp_path / 'b', tmp_path / 'saved')
    with Reader(tmp_path / 'b') as one, Reader(tmp_path / 'saved') as other:
        assert [c._replace(owner=None) for c in one.connections] == [
            c._replace(owner=None) for c in other.connections]
        assert [(c.topic, at, raw) for c, at, raw in one.messages()] == [
            (c.topic, at, raw) for c, at, raw in other.messages()]


@pytest.mark.parametrize('make, said', [
    (lambda path: None, 'no such file'),
    (lambda path: path.mkdir(), 'no MCAP file'),
    (lambda path: path.write_text('x'), 'no MCAP file'),
    (lambda path: path.write_bytes(b'\x89MCAP0\r\n'), 'not a single message'),
])
def test_what_cannot_be_recovered(tmp_path, make, said):
    make(tmp_path / 'b')
    with pytest.raises(InputError, match=said):
        recover(tmp_path / 'b', tmp_path / 'saved')
    assert not (tmp_path / 'saved').exists()


@pytest.mark.parametrize('length', [2**62, 2**63 + 5, 2**64 - 1])
def test_a_chunk_that_claims_more_than_there_can_be(tmp_path, length):
    """Its length is damaged: what the file has of it is read, and no more."""
    write_run(tmp_path / 'bag', make_run())
    file = next((tmp_path / 'bag').glob('*.mcap'))
    data = bytearray(file.read_bytes())
    at = 8
    while data[at] != 0x06:
        at += 9 + struct.unpack_from('<Q', data, at + 1)[0]
    struct.pack_into('<Q', data, at + 1, length)
    (tmp_path / 'claims.mcap').write_bytes(data)
    with pytest.raises(InputError, match='a record goes beyond its file.*hst-drive recover'):
        read_log(tmp_path / 'claims.mcap')
    assert recover(tmp_path / 'claims.mcap', tmp_path / 'saved').messages > 0


def test_what_is_saved_keeps_the_order_in_which_it_was_written(tmp_path):
    """So that a clock that was set back is still seen."""
    run = make_run(600)
    write_run(tmp_path / 'b', run)
    path = tmp_path / 'b' / 'b_0.mcap'
    with BagWriter(tmp_path / 'set') as bag:
        for stream in salvage_streams(path)[0]:
            bag.add_topic(stream.topic, stream.type, stream.definition)
        rows = sorted((log, stream.topic, data) for stream in salvage_streams(path)[0]
                      for log, data in zip(stream.log_time, stream.data))
        middle = rows[len(rows) // 2][0]
        for log, topic, data in rows:
            lost = 3 * 10**9 if log >= middle else 0
            sec = int.from_bytes(data[4:8], 'little') - lost // 10**9
            bag.write(topic, data[:4] + sec.to_bytes(4, 'little') + data[8:], log - lost)
    recover(tmp_path / 'set', tmp_path / 'saved')
    for name in ('set', 'saved'):
        back = read_log(tmp_path / name)
        assert any('set back by 3 s' in note for note in back.notes)
        np.testing.assert_allclose(back['motor_speed'], run['motor_speed'], rtol=1e-12)


def with_a_camera(path, run, profiles=''):
    """Write a recording as an MCAP file in which a topic of protobuf stands beside ours."""
    write_run(path.with_suffix(''), run)
    with open(path, 'wb') as file:
        writer = Writer(file)
        writer.start('ros2')
        schema = writer.register_schema('foxglove.Image', 'protobuf', b'\n\x81\x02\xff')
        camera = writer.register_channel('/camera', 'protobuf', schema)
        for stream in salvage_streams(path.with_suffix('') / f'{path.stem}_0.mcap')[0]:
            schema = writer.register_schema(stream.type, 'ros2msg', stream.definition.encode())
            channel = writer.register_channel(stream.topic, 'cdr', schema,
                                              {'offered_qos_profiles': profiles})
            for log, data in zip(stream.log_time, stream.data):
                writer.add_message(channel, log, data, log)
                writer.add_message(camera, log, b'\xff\xd8', log)
        writer.finish()


def test_topics_of_another_coding_stand_beside_ours(tmp_path):
    run = make_run(60)
    with_a_camera(tmp_path / 'b.mcap', run)
    np.testing.assert_allclose(read_log(tmp_path / 'b.mcap')['motor_speed'], run['motor_speed'])
    assert recover(tmp_path / 'b.mcap', tmp_path / 'saved').damaged == 0
    for path in (tmp_path / 'b.mcap', tmp_path / 'saved' / 'saved_0.mcap'):
        with open(path, 'rb') as file:
            summary = make_reader(file).get_summary()
        found = {channel.topic: channel for channel in summary.channels.values()}
        assert found['/camera'].message_encoding == 'protobuf'
        assert summary.schemas[found['/camera'].schema_id].data == b'\n\x81\x02\xff'
        assert found['/drive/motor'].message_encoding == 'cdr'


@pytest.mark.parametrize('profiles', ['reliable', '5'])
def test_profiles_that_are_none_are_left_out(tmp_path, profiles):
    with_a_camera(tmp_path / 'b.mcap', make_run(60), profiles)
    recover(tmp_path / 'b.mcap', tmp_path / 'saved')
    assert len(read_log(tmp_path / 'saved')) == 60


def test_a_cut_file_with_a_record_that_is_too_short_is_told(tmp_path):
    write_run(tmp_path / 'b', make_run(600))
    data = (tmp_path / 'b' / 'b_0.mcap').read_bytes()
    path = tmp_path / 'cut.mcap'
    path.write_bytes(data[:8] + b'\6' + struct.pack('<Q', 3) + b'abc' + data[8:-100])
    with pytest.raises(InputError, match='cut off'):
        read_log(path)
