# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Controller and estimator of a machine of your own, kept up by a manager.

    ros2 launch hst_drive machine.launch.py channels:=$PWD/map.yaml rig:=$PWD/my_rig.yaml

A node that ends or is killed is started again; the manager tells of it on /diagnostics and brings
it up. A controller that comes back stays at 0 V until it is started (docs/integration.md). With
``respawn:=false`` the manager only tells.
"""
from hst_drive.resources import share
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

NODES = ('estimator', 'controller')
RESPAWN_DELAY = 1.0     # s


def generate_launch_description():
    """Return the nodes and their manager."""
    def given(name, kind=str):
        return ParameterValue(LaunchConfiguration(name), value_type=kind)

    common = {'namespace': LaunchConfiguration('namespace'), 'output': 'screen'}
    own = {'channels': given('channels'), 'hardware_id': given('hardware_id')}
    return LaunchDescription([
        DeclareLaunchArgument('config', default_value=str(share('config', 'drive.yaml')),
                              description='parameters of the nodes'),
        DeclareLaunchArgument('channels', default_value='',
                              description='channel map; empty: our own topics'),
        DeclareLaunchArgument('rig', default_value='', description='rig file'),
        DeclareLaunchArgument('namespace', default_value='drive', description='of all topics'),
        DeclareLaunchArgument('hardware_id', default_value='',
                              description='name of the machine in /diagnostics'),
        DeclareLaunchArgument('respawn', default_value='true', choices=['true', 'false'],
                              description='start and bring up again what has ended'),
        *(Node(package='hst_drive', executable=name, **common,
               parameters=[LaunchConfiguration('config'), own,
                           *([{'rig': given('rig')}] if name == 'estimator' else [])],
               arguments=['--managed'], sigterm_timeout='15',
               respawn=LaunchConfiguration('respawn'), respawn_delay=RESPAWN_DELAY)
          for name in NODES),
        Node(package='hst_drive', executable='manager', **common,
             parameters=[{'nodes': [*NODES], 'bring_back': given('respawn', bool),
                          'hardware_id': given('hardware_id')}]),
    ])
