# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A recording drilled again by the nodes: the controller in the loop with a recorded load."""
import json
import math

from hst_drive.bag import read_log
import numpy as np
import pytest
from rosbags.rosbag2 import Writer
from rosbags.typesys import get_typestore, Stores

from .processes import run, TREE

pytest.importorskip('rclpy')
RIG = TREE / 'config' / 'rig' / 'test_rig.yaml'
RPM = math.pi / 30.0


@pytest.fixture(scope='module')
def first(tmp_path_factory):
    """Return the folder of a run in changing rock and its figures."""
    folder = tmp_path_factory.mktemp('first')
    code, _, err = run('run', 'layered_ground', '-o', str(folder / 'bag'), '--duration', '12',
                       '--json', str(folder / 'run.json'))
    assert code == 0, err
    return folder / 'bag', json.loads((folder / 'run.json').read_text())


def test_the_same_load_under_other_gains(first, tmp_path):
    """The load is the recorded one to the bit; twice the integral gain halves the error."""
    rig = tmp_path / 'rig.yaml'
    rig.write_text(RIG.read_text().replace('ki_V_per_rad: 0.45', 'ki_V_per_rad: 0.9'))
    code, _, err = run('run', 'recorded', '--log', str(first[0]), '--rig', str(rig), '-o',
                       str(tmp_path / 'bag'), '--json', str(tmp_path / 'run.json'))
    assert code == 0, err
    before, after = read_log(first[0]), read_log(tmp_path / 'bag')
    assert len(after) == len(before)
    for name in ('pprv_command', 'speed_setpoint'):
        np.testing.assert_array_equal(after[name], before[name])
    drilling = after.time > 6.0
    assert after['load_torque'][drilling].mean() == pytest.approx(
        before['load_torque'][drilling].mean(), rel=0.02)
    # Against a load that ramps, the error of a PI loop is the ramp over its integral gain.
    figures = json.loads((tmp_path / 'run.json').read_text())
    assert figures['speed']['rms_error'] < first[1]['speed']['rms_error']
    code, out, err = run('compare', str(tmp_path / 'bag'))
    assert code == 0, err
    assert 'explains the measurements down to the noise' in out


def test_the_load_of_a_foreign_bag(tmp_path):
    """A step of torque on another machine, in lbf.ft, without commands or set point."""
    store = get_typestore(Stores.ROS2_JAZZY)
    float64 = store.types['std_msgs/msg/Float64']
    with Writer(tmp_path / 'foreign', version=9) as bag:
        topic = bag.add_connection('/rig/tq', 'std_msgs/msg/Float64', typestore=store)
        for i in range(200):
            torque = (100.0 if i < 120 else 160.0) / 1.3558179483
            bag.write(topic, 10**18 + i * 4 * 10**7, store.serialize_cdr(
                float64(torque), topic.msgtype))
    mapping = tmp_path / 'map.yaml'
    mapping.write_text('channels:\n  load_torque: {from: /rig/tq.data, unit: lbf.ft}\n')
    code, _, err = run('run', 'recorded', '--log', str(tmp_path / 'foreign'), '--channels',
                       str(mapping), '-o', str(tmp_path / 'bag'))
    assert code == 0, err
    assert 'speed_setpoint is not in it; 100 rpm throughout' in err
    found = read_log(tmp_path / 'bag')
    for when, torque in ((4.5, 100.0), (7.7, 160.0)):
        near = np.abs(found.time - when) < 0.3
        assert found['load_torque'][near].mean() == pytest.approx(torque, rel=0.02)
        assert found['motor_speed'][near].mean() == pytest.approx(100 * RPM, rel=0.02)


@pytest.mark.parametrize('log, what', (
    (None, "'recording.file' is missing; name a recording there or give one with --log"),
    ('nothing', 'nothing: cannot be read'),
    ('text.csv', 'no load in it')))
def test_what_cannot_be_played_is_one_line(tmp_path, log, what):
    (tmp_path / 'text.csv').write_text('time[s],motor_speed[rpm]\n' + ''.join(
        f'{i / 100},{100 + i % 3}\n' for i in range(50)))
    asked = ['--log', str(tmp_path / log)] if log else []
    code, _, err = run('run', 'recorded', *asked, '-o', str(tmp_path / 'bag'))
    assert code == 2 and what in err and len(err.strip().splitlines()) == 1, err
    assert not (tmp_path / 'bag').exists()
