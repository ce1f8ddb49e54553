# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Whole runs, with real processes and real DDS, and their bags."""
from collections import Counter
import json
import subprocess
import sys

from hst_drive.bag import read_log
from hst_drive.measure.run import Run
from hst_drive.nodes import runner
from hst_drive.nodes.runner import speed_held
import numpy as np
import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import get_typestore, Stores

from .processes import messages, run

pytest.importorskip('rclpy')
SECONDS = 6
STEPS = 100 * SECONDS


@pytest.fixture(scope='module')
def lockstep(tmp_path_factory):
    """Return folder, output and JSON of a short run in lockstep."""
    folder = tmp_path_factory.mktemp('run')
    code, out, err = run('run', 'paper_step', '-o', str(folder / 'bag'), '--duration',
                         str(SECONDS), '--json', str(folder / 'run.json'))
    assert code == 0, err
    return folder / 'bag', out, json.loads((folder / 'run.json').read_text())


def test_rosbags_reads_every_message_of_every_step(lockstep):
    store = get_typestore(Stores.ROS2_JAZZY)
    stamps = {}
    with Reader(lockstep[0]) as reader:
        for connection, logged, data in reader.messages():
            message = store.deserialize_cdr(data, connection.msgtype)
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            assert logged == stamp
            assert message.header.frame_id
            stamps.setdefault(connection.topic.removeprefix('/drive/'), []).append(stamp)
    wanted = list(10**9 + 10**7 * np.arange(STEPS))
    for topic in ('pump_command', 'pprv_command', 'speed_setpoint', 'oil_temperature',
                  'pump_outlet_pressure', 'motor_inlet_flow', 'motor'):
        assert stamps[topic] == wanted, topic
    assert 0 < len(stamps['efficiency']) <= STEPS / 10
    assert len({len(stamps[name]) for name in (
        'efficiency', 'model_efficiency', 'losses', 'model_losses')}) == 1


def test_the_drive_starts_at_rest_and_reaches_its_speed(lockstep):
    record = read_log(lockstep[0])
    assert len(record) == STEPS
    assert record.time[-1] - record.time[0] == pytest.approx(SECONDS - 0.01)
    assert abs(record['motor_speed'][0]) < 0.1
    assert record['pump_outlet_pressure'][0] == pytest.approx(3e5, abs=1e5)
    assert record['motor_speed'][-50:].mean() == pytest.approx(100 * np.pi / 30, rel=0.02)
    # The first command is kp * e alone: 0.02 * 10.47.
    assert record['pump_command'][0] == pytest.approx(0.209, abs=0.002)


def test_the_estimator_is_silent_at_standstill_and_close_to_the_model_later(lockstep):
    store = get_typestore(Stores.ROS2_JAZZY)
    found = {}
    with Reader(lockstep[0]) as reader:
        chosen = [c for c in reader.connections if 'efficiency' in c.topic or 'losses' in c.topic]
        for connection, logged, data in reader.messages(chosen):
            vector = store.deserialize_cdr(data, connection.msgtype).vector
            found.setdefault(connection.topic.removeprefix('/drive/'), []).append(
                (logged, vector.x, vector.y, vector.z))
    found = {name: np.array(rows) for name, rows in found.items()}
    assert all(np.isfinite(rows).all() for rows in found.values())
    assert found['efficiency'][0, 0] > 10**9 + 10**8
    last, model = found['efficiency'][-1, 1:], found['model_efficiency'][-1, 1:]
    assert last[0] == pytest.approx(model[0], abs=0.01)
    assert last[2] == pytest.approx(last[0] * last[1], abs=1e-6)
    assert found['losses'][-1, 1] == pytest.approx(100 * (1 - last[0]), abs=1e-6)


def test_the_report_says_where_and_how_well(lockstep):
    bag, out, result = lockstep
    assert str(bag) in out and 'worst excursion' in out
    assert result['messages'] == len(messages(bag))
    assert result['seconds'] == pytest.approx(SECONDS)
    assert result['speed']['mean'] == pytest.approx(100 * np.pi / 30, rel=0.02)


def test_a_loaded_machine_records_the_same(lockstep, tmp_path):
    busy = [subprocess.Popen([sys.executable, '-c', 'while True: pass']) for _ in range(2)]
    try:
        code, _, err = run('run', 'paper_step', '-o', str(tmp_path / 'bag'), '--duration',
                           str(SECONDS))
    finally:
        for process in busy:
            process.kill()
            process.wait()
    assert code == 0, err
    assert messages(tmp_path / 'bag') == messages(lockstep[0])


def test_another_seed_records_other_noise(lockstep, tmp_path):
    code, _, err = run('run', 'paper_step', '-o', str(tmp_path / 'bag'), '--duration', '1',
                       '--seed', '7', '--topic', 'case_drain_flow', '--truth', '--rate', '200')
    assert code == 0, err
    record, other = read_log(tmp_path / 'bag'), read_log(lockstep[0])
    assert len(record) == 200
    assert not np.array_equal(record['motor_speed'][::2][:50], other['motor_speed'][:50])
    counts = Counter(topic for topic, _, _ in messages(tmp_path / 'bag'))
    assert counts['/drive/case_drain_flow'] == counts['/drive/truth/motor'] == 200


def test_real_time_keeps_the_clock(tmp_path):
    code, _, err = run('run', 'paper_step', '--realtime', '-o', str(tmp_path / 'bag'),
                       '--duration', '2')
    assert code == 0, err
    found = messages(tmp_path / 'bag')
    counts = Counter(topic.rpartition('/')[2] for topic, _, _ in found)
    # The plant catches up what a busy machine delays: no sample is left out.
    assert counts['motor'] == counts['motor_inlet_flow'] == 200
    assert counts['pump_command'] >= 100, 'most, on a busy machine'
    times = [time for _, time, _ in found]
    assert times == sorted(times)
    stamps = sorted(int.from_bytes(data[4:8], 'little') * 10**9
                    + int.from_bytes(data[8:12], 'little')
                    for topic, _, data in found if topic.endswith('/motor'))
    assert set(np.diff(stamps)) == {10**7}


@pytest.mark.parametrize('arguments, words', [
    (('paper_stp',), ('paper_stp', 'paper_step')),
    (('paper_step', '--effect', 'motor_leakage.nothing=1'), ('nothing', 'conductance')),
    (('paper_step', '--effect', 'what is this'), ('id.parameter=value',)),
    (('paper_step', '--effect', 'valve_lag'), ('valve_lag', "'circuit: open'", 'leave it out')),
    (('paper_step', '--topic', 'pump_command'), ('pump_command', 'motor')),
    (('paper_step', '--rate', '5000'), ('--rate', '1000')),
    (('paper_step', '--speed', '0'), ('--speed 0', '0.001')),
    (('paper_step', '--log', 'hole.csv'), ('paper_step.yaml', 'hole.csv', 'real_log')),
    (('paper_step', '--topic', 'case_drain'), ('case_drain_flow',)),
    (('paper_step', '--json', 'nowhere/a.json'), ('nowhere/a.json', 'cannot be written')),
    (('paper_step', '--rig', 'nowhere.yaml'), ('nowhere.yaml',)),
    (('paper_step', '-o', '.'), ('exists already',)),
    (('paper_step', '-o', '/proc/no/bag'), ('/proc/no/bag', 'cannot be made', '-o')),
])
def test_wrong_input_is_refused_before_anything_starts(arguments, words, tmp_path):
    output = () if '-o' in arguments else ('-o', str(tmp_path / 'bag'))
    code, out, err = run('run', *arguments, *output)
    assert (code, out) == (2, '')
    assert len(err.strip().splitlines()) == 1
    assert all(word in err for word in words), err
    assert not (tmp_path / 'bag').exists()


def test_an_empty_line_of_a_node_is_heard_like_any_other():
    """As of an effect of somebody else's that prints: who reads the node's output must go on."""
    progress = {'time': 0.0, 'wall': 0.0, 'end': False}
    for line in ('', 'progress 1.50 0.250 end'):
        runner._hear(progress, 'plant', line)
    assert progress == {'time': 1.5, 'wall': 0.25, 'end': True}


def test_a_jump_of_the_set_point_is_no_excursion():
    time = np.arange(400) * 0.01
    wanted = np.where(time < 2, 10.0, 4.0)
    speed = wanted + np.where(time < 2, 10.0, 6.0) * np.exp(-(time % 2) / 0.1) * np.where(
        time < 2, -1.0, 1.0)
    speed[300] += 0.7
    found = speed_held(Run('made', time, {'motor_speed': speed, 'speed_setpoint': wanted}))
    assert found['worst_at'] == 3.0 and abs(found['worst_error'] - 0.7) < 0.01


def test_a_run_shorter_than_half_a_sample_time_is_one_sample(tmp_path):
    code, _, err = run('run', 'paper_step', '-o', str(tmp_path / 'bag'), '--duration', '0.4',
                       '--rate', '1', patience=30.0)
    assert code == 0, err
    with Reader(tmp_path / 'bag') as reader:
        assert reader.topics['/drive/motor'].msgcount == 1


@pytest.mark.parametrize('home', [None, '/proc/nowhere'])
def test_a_run_needs_no_home(home, tmp_path, monkeypatch):
    for name in ('ROS_LOG_DIR', 'ROS_HOME', 'HOME'):
        monkeypatch.delenv(name, raising=False)
    if home:
        monkeypatch.setenv('HOME', home)
    monkeypatch.setenv('PYTHONNOUSERSITE', '1')
    code, _, err = run('run', 'paper_step', '-o', str(tmp_path / 'bag'), '--duration', '0.5')
    assert code == 0, err
    assert (tmp_path / 'bag' / 'metadata.yaml').is_file()


def test_a_stop_by_the_controller_is_told(tmp_path):
    """A set point that is too high, once: the run itself goes on to its end."""
    scenario = tmp_path / 'fast.yaml'
    scenario.write_text(
        'title: too fast\nduration_s: 2\nspeed_setpoint: {kind: ramps, time_s: [0, 1], '
        'speed_rpm: [0, 400]}\nload: {kind: constant, torque_N_m: 100}\n'
        'oil_temperature: {temperature_degC: 50}\n', encoding='utf-8')
    code, _, err = run('run', str(scenario), '-o', str(tmp_path / 'bag'))
    assert code == 0, err
    assert err.count('the controller stopped the drive: setpoint_invalid') == 1, err
