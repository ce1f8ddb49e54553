# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Bags through rosbag2_py: the real one where it is installed, else one with its interface.

What goes through it must be what goes through pip's mcap.
"""
from importlib.util import find_spec
import json
import os
from pathlib import Path
import shutil
import subprocess
import sys

from hst_drive.bag import BagWriter, find_storage, read_log, write_run
from hst_drive.bag.mcap_sink import McapSink
from hst_drive.bag.rosbag2 import bag_blocks
from hst_drive.bag.topics import Qos
from hst_drive.errors import InputError
import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from .records import make_run
from .test_bags import VECTOR, vector

ROOT = Path(__file__).parents[2]
HERE = Path(__file__).parent / 'stand_in'
NAMES = ('/drive/a', '/drive/b')


@pytest.fixture
def ros(monkeypatch):
    """Have rosbag2_py."""
    if find_spec('rosbag2_py') is None:
        monkeypatch.syspath_prepend(HERE)
    yield
    for name in ('rosbag2_py', 'hst_drive.bag.ros_bag'):
        sys.modules.pop(name, None)


@pytest.fixture
def pip(monkeypatch):
    """Have no rosbag2_py."""
    monkeypatch.setitem(sys.modules, 'rosbag2_py', None)


def written(folder, **options):
    """Write two topics, stamps not in order; return what was written."""
    rows = [(NAMES[index % 2], vector(10**18 + index, float(index)),
             10**18 + 10**6 * (index - 50 * (index % 7 == 0)), 10**18 + index)
            for index in range(300)]
    with BagWriter(folder, custom_data={'scenario': 'step'}, **options) as bag:
        for name, reliability in zip(NAMES, ('reliable', 'best_effort')):
            bag.add_topic(name, VECTOR, qos=Qos(reliability))
        for row in rows:
            bag.write(*row)
        assert bag.message_count == 300 and bag.counts() == dict.fromkeys(NAMES, 150)
    return rows


def read(folder, wanted=NAMES):
    """Return what our reader gives of each topic."""
    *_, = blocks = list(bag_blocks(folder, wanted.__contains__, []))
    found = {}
    for stream in (stream for block in blocks for stream in block):
        entry = found.setdefault(stream.topic, (stream.type, stream.definition,
                                                stream.schema_encoding, stream.encoding, []))
        entry[-1].extend(zip(stream.order, stream.log_time, stream.data))
    return found


@pytest.mark.parametrize('compressed', [True, False])
def test_both_read_the_same_from_what_either_wrote(tmp_path, ros, monkeypatch, compressed):
    rows = written(tmp_path / 'ros', compressed=compressed)
    assert written(tmp_path / 'pip', compressed=compressed, sink=McapSink) == rows
    through_ros = [read(tmp_path / name) for name in ('ros', 'pip')]
    monkeypatch.setitem(sys.modules, 'rosbag2_py', None)
    through_pip = [read(tmp_path / name) for name in ('ros', 'pip')]
    assert all(found == through_pip[1] for found in (*through_ros, through_pip[0]))
    for topic in NAMES:
        assert through_ros[0][topic][-1] == [
            (order, at, data) for order, (name, data, at, _) in enumerate(rows) if name == topic]


def test_another_reader_accepts_it(tmp_path, ros):
    rows = written(tmp_path / 'bag')
    with Reader(tmp_path / 'bag') as reader:
        assert reader.message_count == len(rows)
        found = [(entry.topic, data, at) for entry, at, data in reader.messages()]
        best_effort = {entry.topic: entry.ext.offered_qos_profiles[0].reliability.name
                       for entry in reader.connections}
    assert sorted(found) == sorted(row[:3] for row in rows)
    assert 'scenario: step' in (tmp_path / 'bag' / 'metadata.yaml').read_text()
    assert best_effort == dict(zip(NAMES, ('RELIABLE', 'BEST_EFFORT')))


def test_a_topic_that_is_not_wanted_is_announced_without_messages(tmp_path, ros):
    written(tmp_path / 'bag')
    assert len(read(tmp_path / 'bag', NAMES[:1])[NAMES[1]][-1]) == 0
    assert not any(entry[-1] for entry in read(tmp_path / 'bag', ()).values())


def test_a_recording_comes_back_in_blocks(tmp_path, ros, monkeypatch):
    from hst_drive.bag import ros_bag
    monkeypatch.setattr(ros_bag, 'BLOCK', 150)
    run = make_run(500)
    write_run(tmp_path / 'bag', run)
    found = read_log(tmp_path / 'bag')
    for name, values in run.channels.items():
        np.testing.assert_array_equal(found[name], values)


def test_which_one_is_used(ros, monkeypatch):
    assert find_storage().sink.__name__ == 'RosSink'
    monkeypatch.setitem(sys.modules, 'rosbag2_py', None)
    assert find_storage().sink is McapSink


def test_damage_is_told_in_one_line(tmp_path, ros):
    """It stops reading at damage without a word; the counts say that something is missing."""
    written(tmp_path / 'bag', sink=McapSink, chunk_seconds=0.05)
    path = tmp_path / 'bag' / 'bag_0.mcap'
    data = bytearray(path.read_bytes())
    data[len(data) // 4:len(data) // 3] = bytes(len(data) // 3 - len(data) // 4)
    path.write_bytes(data)
    with pytest.raises(InputError, match='bag_0.mcap: damaged: \\d+ of the messages'):
        read(tmp_path / 'bag')


def test_what_is_no_mcap_file_is_told_in_one_line(tmp_path, ros):
    (tmp_path / 'bag.mcap').write_bytes(b'hello')
    with pytest.raises(InputError, match='bag.mcap: damaged or no MCAP file'):
        list(bag_blocks(tmp_path / 'bag.mcap', NAMES.__contains__, []))


def test_what_cannot_be_written_is_an_os_error(tmp_path, ros, monkeypatch):
    """The disk is full: rosbag2_py goes on, the recorder must not."""
    with pytest.raises(InputError, match='exists already'):
        BagWriter(tmp_path)
    with BagWriter(tmp_path / 'bag') as bag:
        with pytest.raises(OSError, match='before first write'):
            bag.write('/drive/none', b'', 1)
        bag.flush()
        monkeypatch.setattr(shutil, 'disk_usage', lambda _: shutil._ntuple_diskusage(9, 9, 0))
        with pytest.raises(OSError, match='No space left'):
            bag.flush()


def test_verbs_give_the_same_figures(tmp_path, pip):
    """On a machine without pip's mcap, of which the stand-in alone makes use."""
    write_run(tmp_path / 'bag', make_run(1500))
    hidden = tmp_path / 'hidden'
    hidden.mkdir()
    (hidden / 'sitecustomize.py').write_text(
        'import sys, rosbag2_py\n'
        "for name in [name for name in sys.modules if name.split('.')[0] in "
        "('mcap', 'lz4', 'zstandard')]:\n"
        '    sys.modules[name] = None\n' if find_spec('rosbag2_py') is None else '')
    found = []
    for path in (f'{hidden}:{HERE}:{ROOT}', str(ROOT)):
        done = subprocess.run(
            [sys.executable, '-m', 'hst_drive', 'compare', str(tmp_path / 'bag'), '--json', '-'],
            env={**os.environ, 'PYTHONPATH': path}, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        found.append({name: (entry['samples'], entry['rmse'], entry['bias'], entry['max_abs'])
                      for name, entry in json.loads(done.stdout)['signals'].items()})
    assert found[0] == found[1]
