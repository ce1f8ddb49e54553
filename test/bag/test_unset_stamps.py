# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages whose stamp nobody set, and holes that no replay should bridge."""
from hst_drive.bag import read_log
from hst_drive.errors import InputError
from hst_drive.measure.useful import missing_rows, refuse_starved
import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

STORE = get_typestore(Stores.ROS2_JAZZY)
VECTOR, JOINTS = 'geometry_msgs/msg/Vector3Stamped', 'sensor_msgs/msg/JointState'
ROWS, PERIOD, AGE = 400, 10_000_000, 700_000     # ns
WALL = 1_760_000_000 * 10**9


def header(stamp):
    time, head = (STORE.types[name] for name in (
        'builtin_interfaces/msg/Time', 'std_msgs/msg/Header'))
    return head(time(*divmod(int(stamp), 10**9)), '')


def write(folder, begin, stamps_of_commands):
    """Write commands and speeds of the same 4 s; commands count up."""
    three = STORE.types['geometry_msgs/msg/Vector3']
    with Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        topics = {kind: bag.add_connection(name, kind, typestore=STORE) for name, kind in (
            ('/drive/pump_command', VECTOR), ('/drive/motor', JOINTS))}
        for k, stamp in enumerate(stamps_of_commands):
            true = begin + k * PERIOD
            for kind, message in (
                    (VECTOR, STORE.types[VECTOR](header(stamp), three(float(k), 0.0, 0.0))),
                    (JOINTS, STORE.types[JOINTS](
                        header(true), ['motor'], np.zeros(1), np.array([0.1 * k]),
                        np.zeros(1)))):
                bag.write(topics[kind], WALL + k * PERIOD + AGE,
                          STORE.serialize_cdr(message, kind))
    return folder


@pytest.mark.parametrize('unset', [[200], [0], range(100, 350), [*range(50), 399]])
@pytest.mark.parametrize('begin', [WALL, 50 * 10**9], ids=['wall', 'simulated'])
def test_a_stamp_of_0_is_none(tmp_path, unset, begin):
    """When the message was published counts, on the clock of those around it."""
    stamps = begin + np.arange(ROWS) * PERIOD
    stamps[list(unset)] = 0
    run = read_log(write(tmp_path / 'bag', begin, stamps))
    np.testing.assert_allclose(run.time, np.arange(ROWS) * 0.01, atol=1e-6)
    np.testing.assert_array_equal(run['pump_command'], np.arange(ROWS))
    assert any(f'/drive/pump_command: {len(list(unset))} messages with stamp 0' in note
               for note in run.notes)


def test_simulated_time_may_begin_at_0(tmp_path):
    run = read_log(write(tmp_path / 'bag', 0, np.arange(ROWS) * PERIOD))
    np.testing.assert_array_equal(run['pump_command'], np.arange(ROWS))
    assert not any('stamp 0' in note for note in run.notes)


def test_a_clock_that_is_set_on_the_way_is_refused(tmp_path):
    """A controller board without a battery begins in 1970."""
    table = np.column_stack([np.arange(ROWS) * 0.01, np.ones(ROWS), 0.1 * np.arange(ROWS)])
    table[200:, 0] += 1.76e9
    path = tmp_path / 'log.csv'
    np.savetxt(path, table, delimiter=',', comments='',
               header='time[s],pump_command[V],motor_speed[rad/s]')
    with pytest.raises(InputError, match='no samples for 1.76e[+]09 s after 1.99 s; expected at '
                                         'most 3600 s'):
        read_log(path)


def test_a_log_without_most_of_a_command_is_refused(tmp_path):
    stamps = WALL + np.arange(ROWS) * PERIOD
    run = read_log(write(tmp_path / 'bag', WALL, stamps))
    values = run['pump_command'].copy()
    values[100:] = np.nan
    run.channels['pump_command'] = values
    with pytest.raises(InputError, match='pump_command is missing in 300 of 400 rows'):
        refuse_starved(run.source, missing_rows(run), len(run))
    values[100:205] = 1.0
    refuse_starved(run.source, missing_rows(run), len(run))
