# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The launch file, where ROS 2's launch is installed (it does not come from PyPI)."""
from importlib.util import module_from_spec, spec_from_file_location

from hst_drive.resources import share
import pytest
import yaml

launch = pytest.importorskip('launch')
pytest.importorskip('launch_ros')


@pytest.fixture(scope='module')
def file():
    """Return the launch file as a module."""
    spec = spec_from_file_location('drive_launch', share('launch', 'drive.launch.py'))
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_argument_is_a_parameter_of_its_node(file):
    """By name and type, as the YAML of the nodes has them."""
    listed = yaml.safe_load(share('config', 'drive.yaml').read_text())
    for name, (default, meaning, kind, node) in file.ARGUMENTS.items():
        assert isinstance(listed[f'/**/{node}']['ros__parameters'][name], kind), name
        kind(default)
        assert meaning


def test_it_declares_its_arguments_and_starts_all_nodes(file):
    """Each node is watched: when one ends, all do."""
    from hst_drive.nodes.wiring import NODES
    from launch.actions import DeclareLaunchArgument, RegisterEventHandler
    from launch_ros.actions import Node

    found = file.generate_launch_description().entities
    assert {entity.name for entity in found if isinstance(entity, DeclareLaunchArgument)} == {
        *file.ARGUMENTS, 'config', 'rig', 'namespace', 'lockstep', 'managed', 'clock',
        'diagnostics'}
    assert [entity.node_executable for entity in found if isinstance(entity, Node)] == [
        *NODES, 'manager']
    assert sum(isinstance(entity, RegisterEventHandler) for entity in found) == len(NODES)
