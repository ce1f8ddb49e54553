# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Sections of a bag: each sample is in exactly one, and only stamps stay in memory."""
import os
from pathlib import Path
import random
import subprocess
import sys
import tracemalloc

from hst_drive.bag import BagWriter, ChannelMap, read_log, write_run
from hst_drive.bag.cdr import Codec
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.long_bag import bag_sections
from hst_drive.errors import InputError
import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin

from .records import make_run
from .test_foreign import MAP, messages, write

ROOT = Path(__file__).parents[2]
VECTOR = 'geometry_msgs/msg/Vector3Stamped'


def check(sections, whole, seconds, before, after):
    """Compare sections, put together, with what the whole bag holds."""
    own, values = [], {name: [] for name in whole.channels}
    for number, (run, start, end) in enumerate(sections):
        keep = (run.time >= start) & (run.time < end)
        own.append(run.time[keep])
        for name, parts in values.items():
            parts.append(run[name][keep])
        assert run.time[0] == pytest.approx(start - before if number else 0.0, abs=0.021)
        if number + 1 < len(sections):
            assert run.time[-1] == pytest.approx(end + after, abs=0.021)
            assert end - start == pytest.approx(seconds)
    np.testing.assert_allclose(np.concatenate(own), whole.time, atol=1e-6)
    for name, parts in values.items():
        np.testing.assert_allclose(np.concatenate(parts), whole[name], rtol=1e-9, err_msg=name)


@pytest.mark.parametrize('seconds', [1.0, 59.0, 100.0, 260.0, 301.0])
def test_every_sample_is_in_one_section(tmp_path, seconds):
    write_run(tmp_path / 'b', make_run(round(100 * seconds)))
    sections = list(bag_sections(tmp_path / 'b', ChannelMap(), 100.0, 5.0, 2.0))
    assert len(sections) == max(round(seconds / 100.0), 1)
    check(sections, read_log(tmp_path / 'b'), 100.0, 5.0, 2.0)


@pytest.mark.parametrize('plugin', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_foreign_bags_in_any_storage_and_order(tmp_path, plugin):
    found = messages(3000)
    for first in range(0, len(found), 50):      # each a little late or early
        part = found[first:first + 50]
        random.Random(first).shuffle(part)
        found[first:first + 50] = part
    folder = write(tmp_path / 'b', found, plugin)
    check(list(bag_sections(folder, MAP, 10.0, 2.0, 1.0)), read_log(folder, MAP), 10.0, 2.0, 1.0)


def vector(at, x):
    codec = Codec(VECTOR, find_definition(VECTOR))
    return codec.encode({'header': {'stamp': {'sec': at // 10**9, 'nanosec': at % 10**9}},
                         'vector': {'x': x}})


def one_after_the_other(folder, times, topics=('/d/pump_command', '/d/motor_inlet_flow')):
    """Write all of a topic before the next one, as a converter may."""
    with BagWriter(folder) as bag:
        for topic in topics:
            bag.add_topic(topic, VECTOR)
        for topic in topics:
            for at in times:
                bag.write(topic, vector(at, float(at % 7)), at)
    return folder


def test_topics_written_one_after_the_other(tmp_path):
    folder = one_after_the_other(tmp_path / 'b', range(10**18, 10**18 + 300 * 10**9, 2 * 10**7))
    check(list(bag_sections(folder, ChannelMap(), 60.0, 5.0, 2.0)), read_log(folder), 60.0, 5.0,
          2.0)


def test_a_hole_of_years_is_stepped_over(tmp_path):
    """A clock that starts at zero and is set once the network is there."""
    times = [*range(0, 30 * 10**9, 10**7), *range(10**18, 10**18 + 90 * 10**9, 10**7)]
    sections = list(bag_sections(one_after_the_other(tmp_path / 'b', times), ChannelMap(), 60.0,
                                 5.0, 2.0))
    own = [((run.time >= start) & (run.time < end)).sum() for run, start, end in sections]
    assert sum(own) == len(times)
    assert 2 <= len(sections) <= 3


def test_a_clock_set_back_is_told_and_put_right(tmp_path):
    times = np.arange(0, 400 * 10**9, 2 * 10**7) + 10**18
    times[15000:] -= 200 * 10**9
    with BagWriter(tmp_path / 'b') as bag:
        bag.add_topic('/d/pump_command', VECTOR)
        for row, at in enumerate(times.tolist()):     # received in order, stamped out of it
            bag.write('/d/pump_command', vector(at, float(row)), 10**18 + row * 2 * 10**7)
    whole = read_log(tmp_path / 'b')
    np.testing.assert_array_equal(whole['pump_command'], np.arange(len(times)))
    sections = list(bag_sections(tmp_path / 'b', ChannelMap(), 60.0, 5.0, 2.0))
    check(sections, whole, 60.0, 5.0, 2.0)
    assert all('the clock was set back by 200 s' in section.run.notes[0] for section in sections)


def test_a_command_that_was_sent_long_ago_still_holds(tmp_path):
    with BagWriter(tmp_path / 'b') as bag:
        for topic in ('/d/speed_setpoint', '/d/motor_inlet_flow'):
            bag.add_topic(topic, VECTOR)
        for second in (0, 100):
            bag.write('/d/speed_setpoint', vector(second * 10**9, 10.0 + second), second * 10**9)
        for row in range(30000):
            bag.write('/d/motor_inlet_flow', vector(row * 10**7, float(row)), row * 10**7)
    check(list(bag_sections(tmp_path / 'b', ChannelMap(), 60.0, 5.0, 2.0)),
          read_log(tmp_path / 'b'), 60.0, 5.0, 2.0)


def test_a_denser_topic_of_which_nothing_is_wanted_does_not_count(tmp_path):
    """A joint that tells its angle alone, recorded from 5 s before the others on."""
    kind = 'sensor_msgs/msg/JointState'
    codec = Codec(kind, find_definition(kind))
    with BagWriter(tmp_path / 'b') as bag:
        bag.add_topic('/d/motor', kind)
        bag.add_topic('/d/pump_command', VECTOR)
        for at in range(10**18, 10**18 + 200 * 10**9, 10**7):
            bag.write('/d/motor', codec.encode({'header': {'stamp': {'sec': at // 10**9}},
                                                'name': ['motor'], 'position': [1.0]}), at)
            if at >= 10**18 + 5 * 10**9 and at % (2 * 10**7) == 0:
                bag.write('/d/pump_command', vector(at, float(at % 7)), at)
    check(list(bag_sections(tmp_path / 'b', ChannelMap(), 60.0, 5.0, 2.0)),
          read_log(tmp_path / 'b'), 60.0, 5.0, 2.0)


def test_a_full_disk_is_told(tmp_path):
    write_run(tmp_path / 'b', make_run(9000))
    code = ('import resource; from hst_drive.bag import ChannelMap; '
            'from hst_drive.bag.long_bag import bag_sections; '
            'resource.setrlimit(resource.RLIMIT_FSIZE, (50000, 50000)); '
            f'next(bag_sections({str(tmp_path / "b")!r}, ChannelMap(), 60.0, 5.0, 2.0))')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True,
                          env={**os.environ, 'TMPDIR': str(tmp_path)}, cwd=ROOT)
    assert 'InputError' in done.stderr and 'set TMPDIR to another folder' in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ['b']


@pytest.mark.parametrize(('topic', 'told'), [
    ('/other', 'none of our topics'), ('/d/pump_command', 'no messages|none of our')])
def test_nothing_of_ours_is_told(tmp_path, topic, told):
    with BagWriter(tmp_path / 'b') as bag:
        bag.add_topic(topic, VECTOR)
        if topic == '/other':
            bag.write(topic, vector(0, 1.0), 0)
    with pytest.raises(InputError, match=told):
        list(bag_sections(tmp_path / 'b', ChannelMap(), 60.0, 5.0, 2.0))


def test_the_numbers_are_not_kept_in_memory(tmp_path):
    peaks = []
    for minutes in (4, 16):
        folder = tmp_path / str(minutes)
        write_run(folder, make_run(6000 * minutes))
        tracemalloc.start()
        for _ in bag_sections(folder, ChannelMap(), 60.0, 10.0, 5.0):
            pass
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # Five topics in this bag: stamps, and as much for a while. Read whole, numbers take 110.
    assert peaks[1] - peaks[0] < 6000 * 12 * 5 * 8 * 2
