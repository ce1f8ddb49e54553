# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Nodes as programs on a machine that lacks what they need."""
import ast
import subprocess
import sys

import pytest

from .processes import environment, PATIENCE, TREE

PROGRAMS = ('controller', 'estimator', 'load_profile', 'manager', 'plant', 'recorder')


def started(name, hidden, tmp_path):
    """Return what a program says that cannot import a package."""
    (tmp_path / f'{hidden}.py').write_text(
        f'raise ModuleNotFoundError("No module named {hidden!r}", name={hidden!r})\n')
    return subprocess.run(
        [sys.executable, '-c', f'from hst_drive.nodes.entry import {name}; raise SystemExit({name}'
         '())'], env={**environment(), 'PYTHONPATH': f'{tmp_path}:{TREE}'}, text=True,
        capture_output=True, timeout=PATIENCE)


@pytest.mark.parametrize('name, hidden', [
    ('controller', 'rclpy'), ('manager', 'lifecycle_msgs'), ('plant', 'numpy'),
    ('recorder', 'yaml')])
def test_a_missing_package_is_one_line_that_says_what_to_do(name, hidden, tmp_path):
    if hidden != 'rclpy':
        pytest.importorskip('rclpy')
    done = started(name, hidden, tmp_path)
    assert done.returncode == 1 and not done.stdout
    line, = done.stderr.splitlines()
    assert line.startswith(f"{name}: the Python package '{hidden}'") and 'rosdep install' in line


def test_a_fault_of_our_own_is_not_taken_for_a_missing_package():
    from hst_drive.nodes import entry
    with pytest.raises(ImportError, match='nothing_like_it'):
        entry.run('nothing_like_it')


def test_to_be_told_to_stop_while_packages_are_still_being_read_is_no_fault(tmp_path):
    """As launch tells all nodes when one of them could not start."""
    (tmp_path / 'rclpy.py').write_text('raise KeyboardInterrupt')
    code = 'from hst_drive.nodes.entry import plant; raise SystemExit(plant())'
    done = subprocess.run(
        [sys.executable, '-c', code],
        env={**environment(), 'PYTHONPATH': f'{tmp_path}:{TREE}'}, text=True,
        capture_output=True, timeout=PATIENCE)
    assert (done.returncode, done.stdout, done.stderr) == (0, '', '')


def test_every_program_that_is_installed_starts_this_way():
    tree = ast.parse((TREE / 'setup.py').read_text())
    texts = [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)]
    assert ' = hst_drive.nodes.entry:' in texts
    nodes = next(ast.literal_eval(node.value) for node in tree.body
                 if isinstance(node, ast.Assign) and node.targets[0].id == 'NODES')
    from hst_drive.nodes import entry
    assert sorted([*nodes, 'manager']) == sorted(PROGRAMS)
    for name in PROGRAMS:
        assert getattr(entry, name).args == (name,)
