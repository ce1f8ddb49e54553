# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The controller in the loop of ros2_control, with a stand-in for its C++ side.

The stand-in does what their documentation says (control.ros.org, Jazzy).
forward_command_controller:
topic ``~/commands``, std_msgs/Float64MultiArray; a message of another length than ``joints`` is
passed over; what came last holds. joint_state_broadcaster: position, velocity and effort of all
joints on /joint_states, NaN for an interface that a joint has not.
"""
import math

from hst_drive.bag.channels import load_channel_map
from hst_drive.resources import share
import pytest
import yaml

from .machine import surroundings
from .processes import node, wait_for

rclpy = pytest.importorskip('rclpy')
CONFIG = share('config', 'ros2_control.yaml')
TIMES = ('-p', 'feedback_timeout:=2.0', '-p', 'setpoint_timeout:=2.0')


class Ros2Control:
    """A controller_manager with one forward_command_controller and a joint_state_broadcaster."""

    def __init__(self, machine, **other):
        from rclpy.qos import qos_profile_system_default
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Float64MultiArray
        name = 'swash_controller'
        given = {**yaml.safe_load(CONFIG.read_text())[name]['ros__parameters'], **other}
        self.machine, self.interfaces = machine, dict.fromkeys(given['joints'], math.nan)
        self.passed_over = 0
        self.node = rclpy.create_node(name, context=machine.context)
        for key, value in given.items():
            self.node.declare_parameter(key, value)
        machine.executor.add_node(self.node)
        self.node.create_subscription(Float64MultiArray, f'/{name}/commands', self._write,
                                      qos_profile_system_default)
        self.states = self.node.create_publisher(JointState, '/joint_states',
                                                 qos_profile_system_default)
        self.count, self.message = 0, JointState

    def _write(self, message):
        if len(message.data) != len(self.interfaces):
            self.passed_over += 1
            return
        self.interfaces.update(zip(self.interfaces, message.data))

    def update(self, speed, wish=19.0):
        """Do what an update of the controller_manager does."""
        self.count += 1
        nan = math.nan
        self.states.publish(self.message(
            header=_now(self.node), name=['drill', 'swash'],
            position=[nan, nan], velocity=[speed + 1e-3 * math.sin(self.count), nan],
            effort=[100.0, nan]))
        self.machine.tick(reading=None, wish=wish)

    def until(self, condition, **what):
        wait_for(lambda: self.update(**what) or condition())

    def destroy(self):
        self.machine.executor.remove_node(self.node)
        self.node.destroy_node()


def _now(owner):
    from std_msgs.msg import Header
    return Header(stamp=owner.get_clock().now().to_msg())


@pytest.fixture
def given(tmp_path):
    """Return the shipped parameters, with a map of what passes /joint_states."""
    shown = load_channel_map(share('config', 'channels_ros2_control.yaml'))
    entries = {name: {'from': entry.source} for name, entry in shown.entries.items()
               if entry.source.startswith('/joint_states')}
    (tmp_path / 'map.yaml').write_text(yaml.safe_dump({'channels': entries}))
    return ('-r', '__ns:=/loop', '--params-file', str(CONFIG), '-p',
            f'channels:={tmp_path / "map.yaml"}', *TIMES)


def test_commands_reach_the_interface_and_states_the_controller(given):
    with surroundings('loop') as machine:
        loop = Ros2Control(machine)
        with node('controller', *given, '-p', 'forward_scale:=0.1', '-p', 'stop_time:=0.1'):
            loop.until(lambda: loop.interfaces['swash'] > 0.3, speed=10.0)
            assert machine.told['message'] == 'running' and loop.passed_over == 0
            # A tenth for each volt of a command. The two topics need not come at the same time.
            loop.until(lambda: any(loop.interfaces['swash'] == pytest.approx(0.1 * value)
                                   for _, value in machine.commands[-3:]), speed=10.0)
            # The reading is gone from the states: a fault, the ramp, zero at the interface.
            loop.until(lambda: machine.told.get('fault') == 'feedback_not_finite', speed=math.nan)
            loop.until(lambda: loop.interfaces['swash'] == 0.0, speed=10.0)
        loop.destroy()


def test_a_controller_with_other_joints_is_told(given):
    """It would pass our messages over without a word."""
    with surroundings('loop') as machine, node('controller', *given):
        loop = Ros2Control(machine, joints=['swash', 'feed'])
        loop.until(lambda: '/swash_controller has the joints swash, feed; expected' in
                   machine.told.get('message', ''), speed=10.0)
        assert machine.told['level'] == b'\1' and loop.passed_over > 0
        assert math.isnan(loop.interfaces['swash'])
        loop.destroy()


def test_what_is_shipped_fits_together():
    """Names of both sides in one file; the map's entries are channels of the estimator."""
    content = yaml.safe_load(CONFIG.read_text())
    ours = content['/**/controller']['ros__parameters']
    theirs = content[ours['forward_to'].lstrip('/')]['ros__parameters']
    assert theirs['joints'] == [ours['forward_joint']]
    manager = content['controller_manager']['ros__parameters']
    assert ours['sample_time'] * manager['update_rate'] == pytest.approx(1.0)
    assert ours['forward_to'].lstrip('/') in manager
    assert set(ours) <= set(yaml.safe_load(share('config', 'drive.yaml').read_text())[
        '/**/controller']['ros__parameters'])
