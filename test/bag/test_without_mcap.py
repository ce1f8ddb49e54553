# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A machine without the package mcap, as a stock one is after rosdep and colcon."""
import json
import subprocess
import sys

from hst_drive.bag import write_csv, write_run
from hst_drive.measure.run import Run
from hst_drive.model import Drive
from hst_drive.rig import default_rig
import numpy as np
import pytest
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

from ..nodes.processes import environment, PATIENCE, TREE


@pytest.fixture(scope='module')
def logs(tmp_path_factory):
    """Return a folder with the same recording as CSV, as MCAP and as sqlite3."""
    folder = tmp_path_factory.mktemp('logs')
    time = np.arange(0, 12, 0.01)
    drive = Drive(default_rig())
    inputs = {'pump_command': np.where(time < 6, 5.7, 5.9), 'pprv_command': 5.6 + 0 * time,
              'oil_temperature': 320.0 + 0 * time, 'load_disturbance': 0 * time}
    signals = drive.simulate(time, inputs, drive.initial_state(
        pump_command=5.7, pprv_command=5.6, speed=10.0))
    noise = np.random.default_rng(1)
    run = Run('drilling', time, {
        **{name: inputs[name] for name in ('pump_command', 'pprv_command', 'oil_temperature')},
        **{name: signals[name] + size * noise.standard_normal(len(time)) for name, size in (
            ('pump_outlet_pressure', 2e4), ('motor_speed', 0.02), ('load_torque', 0.5))}})
    write_csv(folder / 'log.csv', run)
    write_run(folder / 'mcap', run)
    store = get_typestore(Stores.ROS2_JAZZY)
    with Reader(folder / 'mcap') as source, Writer(
            folder / 'db3', version=9, storage_plugin=StoragePlugin.SQLITE3) as target:
        topics = {entry.id: target.add_connection(entry.topic, entry.msgtype, typestore=store)
                  for entry in source.connections}
        for entry, stamp, data in source.messages():
            target.write(topics[entry.id], stamp, data)
    return folder


@pytest.fixture(scope='module')
def without(tmp_path_factory):
    """Return the environment of a process that cannot import what MCAP needs."""
    hidden = tmp_path_factory.mktemp('hidden')
    for name in ('mcap', 'lz4', 'zstandard'):
        (hidden / f'{name}.py').write_text(
            f"raise ModuleNotFoundError(\"No module named '{name}'\", name='{name}')\n")
    return {**environment(), 'PYTHONPATH': f'{hidden}:{TREE}'}


def call(where, *arguments):
    done = subprocess.run([sys.executable, '-m', 'hst_drive', *arguments], env=where,
                          capture_output=True, text=True, timeout=PATIENCE)
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize('verb', ['compare', 'diagnose', 'report', 'recover'])
def test_an_mcap_bag_is_refused_in_one_line_that_says_what_to_do(logs, without, verb, tmp_path):
    output = ['-o', str(tmp_path / 'out')] * (verb in ('report', 'recover'))
    code, out, err = call(without, verb, str(logs / 'mcap'), *output)
    assert code == 2 and not out
    last, = [line for line in err.splitlines() if line.startswith('hst-drive: the')]
    assert "'mcap' is missing" in last or "'lz4' is missing" in last
    assert 'pip install mcap' in last and 'Traceback' not in err


def test_a_cut_bag_is_told_as_cut_whatever_is_missing(logs, without, tmp_path):
    data = next((logs / 'mcap').glob('*.mcap')).read_bytes()
    (tmp_path / 'cut.mcap').write_bytes(data[:len(data) // 2])
    code, out, err = call(without, 'compare', str(tmp_path / 'cut.mcap'))
    last, = [line for line in err.splitlines() if line.startswith('hst-drive: ')]
    assert code == 2 and 'cut.mcap: the bag was cut off' in last and 'pip install mcap' in last


def test_csv_and_sqlite3_are_read(logs, without):
    """With the figures that the MCAP bag gives where the package is there."""
    found = {}
    for name, where in (('log.csv', without), ('db3', without), ('mcap', environment())):
        code, out, err = call(where, 'compare', str(logs / name), '--json', '-')
        assert code == 0, err
        found[name] = json.loads(out)['signals']['motor_speed']['rmse']
    assert found['db3'] == found['mcap']
    assert found['log.csv'] == pytest.approx(found['mcap'], rel=1e-3)


@pytest.mark.slow
def test_a_csv_file_is_diagnosed_and_reported(logs, without, tmp_path):
    code, _, err = call(without, 'report', str(logs / 'log.csv'), '-o',
                        str(tmp_path / 'page.html'))
    assert code == 0, err
    assert 'What is missing' in (tmp_path / 'page.html').read_text()


def test_the_recorder_says_what_it_lacks(without, tmp_path):
    done = subprocess.run(
        [sys.executable, '-m', 'hst_drive.nodes.recorder', '--ros-args', '-p',
         f'output:={tmp_path / "bag"}'], env=without, capture_output=True, text=True,
        timeout=PATIENCE)
    assert done.returncode == 2 and 'pip install mcap' in done.stderr
    assert len(done.stderr.splitlines()) == 1 and not (tmp_path / 'bag').exists()
