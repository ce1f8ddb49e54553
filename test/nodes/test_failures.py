# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs that do not come to their end: killed nodes, Ctrl-C, a killed run."""
import signal

from hst_drive.bag import read_log
import pytest

from .processes import alive, children, PATIENCE, start, wait_for

pytest.importorskip('rclpy')
NODES = {'plant', 'load_profile', 'controller', 'estimator', 'recorder'}


def recording(folder):
    """Return whether the recorder has brought anything to the disk."""
    return any(path.stat().st_size > 20000 for path in folder.glob('*.mcap'))


def begin(tmp_path, *arguments):
    """Start a long run and wait until it records; return it, its nodes and its bag."""
    bag = tmp_path / 'bag'
    process = start('run', 'layered_ground', '--duration', '3600', '-o', str(bag), *arguments)
    wait_for(lambda: process.poll() is not None or recording(bag))
    nodes = children(process.pid)
    assert set(nodes) == NODES, process.communicate()
    return process, nodes, bag


@pytest.mark.parametrize('victim', sorted(NODES - {'recorder'}))
def test_a_node_that_dies_ends_the_run_and_the_bag_is_whole(tmp_path, victim):
    process, nodes, bag = begin(tmp_path)
    import os
    os.kill(nodes[victim], signal.SIGKILL)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1
    assert f'node {victim} was killed by SIGKILL' in err and str(bag) in err
    assert not any(map(alive, nodes.values()))
    assert len(read_log(bag)) > 20


def test_a_plant_that_is_told_to_stop_ends_the_run_as_a_failure(tmp_path):
    import os
    process, nodes, bag = begin(tmp_path)
    os.kill(nodes['plant'], signal.SIGINT)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1
    assert 'node plant ended before the run did' in err and str(bag) in err
    assert 'Traceback' not in err and not any(map(alive, nodes.values()))
    assert len(read_log(bag)) > 20


def test_a_killed_recorder_leaves_a_bag_that_can_be_saved(tmp_path):
    import os
    process, nodes, bag = begin(tmp_path)
    os.kill(nodes['recorder'], signal.SIGKILL)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1
    assert 'node recorder was killed' in err and 'hst-drive recover' in err
    assert not any(map(alive, nodes.values()))
    saved = start('recover', str(bag), '-o', str(tmp_path / 'saved'))
    _, err = saved.communicate(timeout=PATIENCE)
    assert saved.returncode == 0, err
    assert len(read_log(tmp_path / 'saved')) > 20


@pytest.mark.parametrize('pace', ['--fast', '--realtime'])
def test_a_full_disk_ends_the_run_with_its_reason_and_the_bag_can_be_saved(tmp_path, pace):
    """The size of files is limited instead: to a writer that looks the same."""
    bag = tmp_path / 'bag'
    process = start('run', 'layered_ground', '--duration', '3600', '-o', str(bag), pace,
                    file_size=150_000)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1 and 'Traceback' not in err, err
    assert 'node recorder' in err and 'cannot be written: File too large' in err
    assert 'hst-drive recover' in err
    saved = start('recover', str(bag), '-o', str(tmp_path / 'saved'))
    _, err = saved.communicate(timeout=PATIENCE)
    assert saved.returncode == 0, err
    assert len(read_log(tmp_path / 'saved')) > 20


@pytest.mark.parametrize('pace', ['--fast', '--realtime'])
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_leaves_a_complete_bag(tmp_path, pace, number):
    process, nodes, bag = begin(tmp_path, pace)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, err
    assert 'interrupted' in out and str(bag) in out
    assert 'Traceback' not in err
    assert not any(map(alive, nodes.values()))
    assert len(read_log(bag)) > 20


def test_a_killed_run_leaves_no_orphans_and_a_complete_bag(tmp_path):
    process, nodes, bag = begin(tmp_path)
    process.kill()
    process.communicate(timeout=PATIENCE)
    wait_for(lambda: not any(map(alive, nodes.values())))
    assert len(read_log(bag)) > 20
