# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The launch file: with ROS 2's launch where it is installed, else with a stand-in of it."""
from contextlib import ExitStack
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
import signal
import subprocess
import sys

from hst_drive.nodes.wiring import NODES
from hst_drive.resources import share
import pytest
from rosbags.rosbag2 import Reader
import yaml

from . import launch_stand_in
from .nodes.processes import environment, PATIENCE

REAL = bool(find_spec('launch') and find_spec('launch_ros'))


def loaded(monkeypatch, name):
    """Return a launch file as a module."""
    if not REAL:
        launch_stand_in.install(monkeypatch)
    spec = spec_from_file_location('loaded', share('launch', f'{name}.launch.py'))
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def file(monkeypatch):
    return loaded(monkeypatch, 'drive')


def test_every_argument_is_a_parameter_of_its_node(file):
    """By name and type, as the YAML of the nodes has them."""
    listed = yaml.safe_load(share('config', 'drive.yaml').read_text())
    for name, (default, meaning, kind, node) in file.ARGUMENTS.items():
        assert isinstance(listed[f'/**/{node}']['ros__parameters'][name], kind), name
        kind(default)
        assert meaning


def test_it_declares_its_arguments_and_starts_all_nodes(file):
    """Each node is watched: when one ends, all do."""
    found = file.generate_launch_description().entities
    kinds = [type(entity).__name__ for entity in found]
    assert {entity.name for entity in found
            if type(entity).__name__ == 'DeclareLaunchArgument'} == {
        *file.ARGUMENTS, 'config', 'rig', 'namespace', 'lockstep', 'managed', 'clock',
        'diagnostics'}
    assert [entity.node_executable for entity in found if type(entity).__name__ == 'Node'] == [
        *NODES, 'manager']
    assert kinds.count('RegisterEventHandler') == len(NODES)


def _bag_has_readings(bag, seconds):
    with Reader(bag) as reader:
        counts = {entry.topic: entry.msgcount for entry in reader.connections}
    assert counts['/drive/motor'] >= 99 * seconds
    assert counts['/drive/pump_command'] >= 99 * seconds


@pytest.mark.skipif(REAL, reason='the real one is there')
@pytest.mark.parametrize('managed', ['false', 'true'])
def test_the_nodes_run_with_what_launch_gives_them(file, managed, tmp_path):
    """Each a process, as launch starts it; it ends the others when the plant is done."""
    bag = tmp_path / 'bag'
    started = launch_stand_in.commands(
        file.generate_launch_description(),
        {'duration': '4.0', 'output': str(bag), 'managed': managed}, tmp_path)
    assert ('manager' in started) == (managed == 'true')
    with ExitStack() as stack:
        running = {}
        for name, arguments in started.items():
            running[name] = process = subprocess.Popen(
                [sys.executable, '-m', f'hst_drive.nodes.{name}', *arguments],
                env=environment(), text=True, stderr=subprocess.PIPE)
            stack.callback(process.kill)
        running['plant'].wait(PATIENCE)
        for process in running.values():
            process.send_signal(signal.SIGINT)
        for name, process in running.items():
            _, said = process.communicate(timeout=PATIENCE)
            assert process.returncode == 0, f'{name}: {said}'
    _bag_has_readings(bag, 4)


@pytest.mark.skipif(REAL, reason='the real one is there')
@pytest.mark.parametrize('respawn', ['true', 'false'])
def test_a_machine_of_your_own_is_kept_up(monkeypatch, respawn, tmp_path):
    """Respawn and the manager's bring_back go together; both nodes take the map."""
    made = loaded(monkeypatch, 'machine').generate_launch_description()
    started = launch_stand_in.commands(
        made, {'respawn': respawn, 'channels': 'map.yaml'}, tmp_path)
    assert list(started) == ['estimator', 'controller', 'manager']
    for name in ('estimator', 'controller'):
        assert started[name][0] == '--managed'
        assert _parameters(started[name])['channels'] == 'map.yaml'
    manager = _parameters(started['manager'])
    assert manager['nodes'] == ['estimator', 'controller']
    assert manager['bring_back'] is (respawn == 'true')
    kept = {node.node_executable: node.respawn for node in made.entities
            if type(node).__name__ == 'Node'}
    assert kept == {'estimator': 'respawn', 'controller': 'respawn', 'manager': False}


def _parameters(arguments):
    """Return what the files of parameters of a command say, the last one counts."""
    found = {}
    for option, path in zip(arguments, arguments[1:]):
        if option == '--params-file':
            for entry in yaml.safe_load(Path(path).read_text()).values():
                found.update(entry['ros__parameters'])
    return found


@pytest.mark.skipif(not REAL, reason="needs ROS 2's launch")
def test_launch_leaves_a_bag(file, tmp_path):
    from launch import LaunchService

    bag = tmp_path / 'bag'
    service = LaunchService()
    service.context.launch_configurations.update(duration='4.0', output=str(bag))
    service.include_launch_description(file.generate_launch_description())
    assert service.run() == 0
    _bag_has_readings(bag, 4)
