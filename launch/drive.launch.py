# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
All nodes of the drive with a scenario.

    ros2 launch hst_drive drive.launch.py scenario:=layered_ground output:=my_bag duration:=30

It ends when the plant has reached the duration, or when any node ends; the recorder is the last
to go. Simulated time in lockstep unless ``lockstep:=false``.

Unlike ``hst-drive run`` this starts from rest and takes gains, rig and hidden effects from the
nodes' parameters, not from the scenario; a scenario of commands by hand needs
``mode:=open_loop``.

``managed:=true`` starts them as lifecycle nodes, which a manager configures and activates in
order. Two drives in one ROS domain: ``namespace`` for each, and in lockstep ``clock`` and
``diagnostics`` as well, for those two topics are global (docs/integration.md).
"""
from hst_drive.nodes.wiring import NODES
from hst_drive.resources import share
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, RegisterEventHandler, Shutdown
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = {
    'scenario': ('paper_step', 'name of a shipped scenario, or a file', str, 'load_profile'),
    'log': ('', 'drilling log or recording whose load is drilled', str, 'load_profile'),
    'channels': ('', 'channel map of the recording', str, 'load_profile'),
    'duration': ('30.0', 'length of the run in s', float, 'plant'),
    'seed': ('1', "seed of the sensors' noise", int, 'plant'),
    'speed': ('0.0', 'in lockstep: times real time; 0: as fast as it goes', float, 'plant'),
    'mode': ('closed_loop', 'closed_loop or open_loop', str, 'controller'),
    'output': ('drive_bag', 'folder to record to; must not exist', str, 'recorder'),
}
"""Launch argument: default, meaning, type, node whose parameter it is."""


def generate_launch_description():
    """Return the nodes and when to end."""
    namespace = LaunchConfiguration('namespace')
    common = {'lockstep': ParameterValue(LaunchConfiguration('lockstep'), value_type=bool),
              'partners': list(NODES)}
    remappings = [('/clock', LaunchConfiguration('clock')),
                  ('/diagnostics', LaunchConfiguration('diagnostics'))]
    nodes = {}
    for name in NODES:
        own = {key: ParameterValue(LaunchConfiguration(key), value_type=kind)
               for key, (_, _, kind, node) in ARGUMENTS.items() if node == name}
        if name in ('plant', 'load_profile', 'estimator'):
            own['rig'] = ParameterValue(LaunchConfiguration('rig'), value_type=str)
        nodes[name] = Node(
            package='hst_drive', executable=name, namespace=namespace, output='screen',
            parameters=[LaunchConfiguration('config'), common, own],
            arguments=['--managed', LaunchConfiguration('managed')],
            remappings=remappings, sigterm_timeout='15')
    manager = Node(package='hst_drive', executable='manager', namespace=namespace,
                   output='screen', parameters=[{'nodes': [*reversed(NODES)]}],
                   condition=IfCondition(LaunchConfiguration('managed')))
    return LaunchDescription([
        DeclareLaunchArgument('config', default_value=str(share('config', 'drive.yaml')),
                              description='parameters of all nodes'),
        DeclareLaunchArgument('rig', default_value='', description='rig file'),
        DeclareLaunchArgument('namespace', default_value='drive', description='of all topics'),
        DeclareLaunchArgument('lockstep', default_value='true',
                              description='simulated time; false: the clock on the wall'),
        DeclareLaunchArgument('managed', default_value='false', choices=['true', 'false'],
                              description='lifecycle nodes with a manager'),
        DeclareLaunchArgument('clock', default_value='/clock', description='name of that topic'),
        DeclareLaunchArgument('diagnostics', default_value='/diagnostics',
                              description='name of that topic'),
        *(DeclareLaunchArgument(name, default_value=default, description=meaning)
          for name, (default, meaning, _, _) in ARGUMENTS.items()),
        *nodes.values(),
        manager,
        *(RegisterEventHandler(OnProcessExit(
            target_action=node, on_exit=[Shutdown(reason=f'{name} has ended')]))
          for name, node in nodes.items()),
    ])
