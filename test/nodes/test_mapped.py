# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""One channel map for live nodes and bags: any type, any name, over real DDS."""
from contextlib import ExitStack
import math
import subprocess
import sys
import time

from hst_drive.bag import read_log
from hst_drive.bag.channels import load_channel_map, parse_channel_map
from hst_drive.errors import InputError
from hst_drive.rig import default_rig
import numpy as np
import pytest

from .machine import surroundings
from .processes import environment, node as process, PATIENCE, wait_for

rclpy = pytest.importorskip('rclpy')
ATMOSPHERE = 101325.0


class Rig:
    """A node that reads through a map, and publishers of any type."""

    def __init__(self, context):
        self.node = rclpy.create_node('mapped', namespace='/mapped', context=context)
        self.node.wall = self.node.get_clock()
        self.node.now = lambda: self.node.get_clock().now().nanoseconds
        self.executor = rclpy.executors.SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.publishers = {}
        self.found = []

    def read(self, channel, entry, timeout=30.0):
        from hst_drive.nodes.mapped import MappedInput, search_for
        made = MappedInput(self.node, parse_channel_map({'channels': {channel: entry}}, 'm.yaml'),
                           channel, lambda *pair: self.found.append(pair), timeout)
        self.node.inputs = {channel: made}
        search_for(self.node)
        return made

    def send(self, topic, message, qos=10):
        if topic not in self.publishers:
            self.publishers[topic] = self.node.create_publisher(type(message), topic, qos)
        self.publishers[topic].publish(message)
        self.executor.spin_once(timeout_sec=0.02)


@pytest.fixture(scope='module')
def context():
    context = rclpy.Context()
    rclpy.init(context=context)
    yield context
    rclpy.shutdown(context=context)


@pytest.fixture
def rig(context):
    made = Rig(context)
    yield made
    made.node.destroy_node()


def message(kind, **members):
    """Return a message; members as ``a__b=value`` of a member's member."""
    package, name = kind.split('/')
    made = getattr(__import__(f'{package}.msg', fromlist=[name]), name)()
    for path, value in members.items():
        *way, last = path.split('__')
        owner = made
        for step in way:
            owner = getattr(owner, step)
        setattr(owner, last, value)
    return made


def stamped(kind, **members):
    return message(kind, header__stamp__sec=7, header__stamp__nanosec=5, **members)


JOINTS = {'name': ['feed', 'drill'], 'velocity': [1.0, 12.0], 'effort': [2.0, 150.0]}


@pytest.mark.parametrize('channel, entry, sent, expected', [
    ('motor_speed', {'unit': 'rpm'}, ('.data', message('std_msgs/Float64', data=60.0)),
     2 * math.pi),
    ('pump_command', {'unit': 'V', 'scale': 0.5, 'offset': 1.0},
     ('.data', message('std_msgs/Float32', data=4.0)), 3.0),
    ('motor_inlet_flow', {'unit': 'L/min'},
     ('.data[2]', message('std_msgs/Float64MultiArray', data=[1.0, 2.0, 90.0])), 1.5e-3),
    ('motor_speed', {}, ('.velocity[drill]', stamped('sensor_msgs/JointState', **JOINTS)), 12.0),
    ('load_torque', {'scale': -1}, ('.effort[1]', stamped('sensor_msgs/JointState', **JOINTS)),
     -150.0),
    ('pump_outlet_pressure', {},
     ('.fluid_pressure', stamped('sensor_msgs/FluidPressure', fluid_pressure=5e6)),
     5e6 - ATMOSPHERE),
    ('motor_inlet_pressure', {'unit': 'bar', 'absolute': True},
     ('.vector.y', stamped('geometry_msgs/Vector3Stamped', vector__y=30.0)), 3e6 - ATMOSPHERE),
    ('oil_temperature', {}, ('.temperature', stamped('sensor_msgs/Temperature', temperature=50.0)),
     323.15),
    ('motor_speed', {'unit': 'rad/s'},
     ('.twist.angular.z', stamped('geometry_msgs/TwistStamped', twist__angular__z=3.0)), 3.0)])
def test_a_channel_of_any_type_in_si(rig, channel, entry, sent, expected):
    path, what = sent
    topic = f'/rig/{channel}_{type(what).__name__}'
    read = rig.read(channel, {'from': topic + path, **entry})
    assert f'{topic} (nobody publishes it)' in read.found()
    wait_for(lambda: rig.send(topic, what) or rig.found)
    stamp, value = rig.found[0]
    assert value == pytest.approx(expected, rel=1e-6) and read.refused == ''
    # A message without a header counts from when it came.
    assert stamp == 7_000_000_005 if hasattr(what, 'header') else (
        abs(stamp - time.time_ns()) < 60e9)


def test_a_number_among_diagnostics(rig):
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
    rig.read('motor_torque', {'from': '/rig/said.status[rig: torque].values[shaft]',
                              'unit': 'N.m'})
    sent = DiagnosticArray(status=[DiagnosticStatus(
        name='rig: torque', values=[KeyValue(key='shaft', value='17.5')])])
    wait_for(lambda: rig.send('/rig/said', sent) or rig.found)
    assert rig.found[0][1] == 17.5


def test_a_difference_of_two_topics_while_both_come(rig):
    from std_msgs.msg import Float64
    rig.read('case_drain_flow', {'minus': [{'from': '/rig/drain.data', 'unit': 'L/min'},
                                           {'from': '/rig/flush.data', 'unit': 'm^3/s'}]}, 0.5)
    wait_for(lambda: (rig.send('/rig/drain', Float64(data=12.0)),
                      rig.send('/rig/flush', Float64(data=5e-5)), rig.found)[-1])
    assert rig.found[-1][1] == pytest.approx(1.5e-4)
    # The second one has stopped: no number is made of a stale one.
    wait_for(lambda: rig.send('/rig/drain', Float64(data=12.0)) or math.isnan(rig.found[-1][1]))


def test_what_does_not_fit_is_told_and_no_number_is_made_up(rig):
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64
    no_unit = rig.read('motor_speed', {'from': '/rig/bare.data'})
    wait_for(lambda: rig.send('/rig/bare', Float64()) or 'needs its unit' in no_unit.found())
    wrong = rig.read('motor_speed', {'from': '/rig/bare.dta', 'unit': 'rpm'})
    wait_for(lambda: rig.send('/rig/bare', Float64()) or "did you mean 'data'" in wrong.found())
    assert not rig.found
    absent = rig.read('motor_speed', {'from': '/rig/joints.velocity[drill]'})
    wait_for(lambda: rig.send('/rig/joints', JointState(name=['feed'], velocity=[1.0]))
             or rig.found)
    assert math.isnan(rig.found[-1][1]) and "'velocity[drill]'" in absent.refused
    wait_for(lambda: rig.send('/rig/joints', JointState(name=['drill'], velocity=[2.0]))
             or rig.found[-1][1] == 2.0)
    assert not absent.refused
    with pytest.raises(InputError, match='m.yaml: channels.motor_speed: .* column of a CSV file'):
        rig.read('motor_speed', 'speed[rpm]')


@pytest.mark.parametrize('offered', ['BEST_EFFORT', 'RELIABLE'])
def test_publishers_of_any_quality_are_heard(rig, offered):
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from std_msgs.msg import Float64
    rig.read('motor_speed', {'from': f'/rig/{offered.lower()}.data', 'unit': 'rpm'})
    wait_for(lambda: rig.send(f'/rig/{offered.lower()}', Float64(), QoSProfile(
        depth=10, reliability=ReliabilityPolicy[offered])) or rig.found)


MAP = """
channels:
  motor_speed: {from: /plc/encoder.data, unit: rpm, scale: 0.1}
  load_torque: {from: '/plc/joints.effort[bit]', scale: -1}
  speed_setpoint: {from: /plc/wish.data, unit: rpm}
  pump_outlet_pressure: {from: /plc/p1.data, unit: bar}
  motor_inlet_flow: {from: '/plc/flow.data[1]', unit: L/min}
  oil_temperature: {from: /plc/oil.temperature}
  pprv_command: {from: /plc/valve.vector.z, unit: V}
"""
SPEED, WISH, FLOW, PRESSURE = 10.0, 19.0, 2.3e-3, 6e6      # rad/s, rad/s, m^3/s, Pa


def test_an_own_machine_with_one_map_for_controller_estimator_recorder_and_bag(tmp_path):
    from geometry_msgs.msg import Vector3Stamped
    (tmp_path / 'map.yaml').write_text(MAP)
    given = ('-p', f'channels:={tmp_path / "map.yaml"}')
    times = ('-p', 'feedback_timeout:=1.0', '-p', 'setpoint_timeout:=1.0', '-p', 'stop_time:=0.1')
    with surroundings('plc') as machine, ExitStack() as stack:
        for name, own in (('controller', times), ('estimator', ('-p', 'timeout:=2.0')),
                          ('recorder', ('-p', f'output:={tmp_path / "bag"}'))):
            stack.enter_context(process(name, '-r', '__ns:=/plc', *given, *own))
        figures, speed = [], SPEED
        machine.node.create_subscription(
            Vector3Stamped, 'efficiency', lambda said: figures.append(said.vector.x), 10)
        now = machine.node.get_clock().now
        rpm = 60 / (2 * math.pi)
        publishers = {}

        def tick(ripple=[0.0]):
            ripple[0] += 1.0
            for topic, what in (
                    ('encoder', speed and message(
                        'std_msgs/Float64',
                        data=10 * rpm * (speed + 1e-3 * math.sin(ripple[0])))),
                    ('joints', message('sensor_msgs/JointState', name=['feed', 'bit'],
                                       effort=[1.0, -200.0])),
                    ('wish', message('std_msgs/Float64', data=rpm * WISH)),
                    ('p1', message('std_msgs/Float64', data=PRESSURE / 1e5)),
                    ('flow', message('std_msgs/Float64MultiArray', data=[0.0, FLOW * 6e4])),
                    ('oil', message('sensor_msgs/Temperature', temperature=50.0)),
                    ('valve', message('geometry_msgs/Vector3Stamped', vector__z=3.0))):
                if what is None:
                    continue
                if hasattr(what, 'header'):
                    what.header.stamp = now().to_msg()
                if topic not in publishers:
                    publishers[topic] = machine.node.create_publisher(type(what), topic, 10)
                publishers[topic].publish(what)
            machine.tick(reading=None, wish=None)

        def until(condition):
            wait_for(lambda: tick() or condition())

        until(lambda: machine.told.get('state') == 'running'
              and machine.commands[-1][1] > 2.0 and figures
              and {'motor_rate_hz', 'speed_setpoint_rate_hz'} <= set(machine.told))
        speed = None
        until(lambda: machine.told.get('fault') == 'feedback_lost')
        until(lambda: machine.told.get('at_zero') == 'true')
        assert machine.commands[-1][1] == 0.0
    assert figures[-1] == pytest.approx(default_rig().motor.displacement * SPEED / FLOW, rel=0.01)
    run = read_log(tmp_path / 'bag', load_channel_map(tmp_path / 'map.yaml'))
    for channel, value in {'motor_speed': SPEED, 'load_torque': 200.0, 'speed_setpoint': WISH,
                           'pump_outlet_pressure': PRESSURE, 'motor_inlet_flow': FLOW,
                           'oil_temperature': 323.15, 'pprv_command': 3.0}.items():
        assert np.nanmedian(run[channel]) == pytest.approx(value, rel=1e-3), channel
    assert np.nanmax(run['pump_command']) > 2.0


@pytest.mark.parametrize('node, extra, words', [
    ('controller', (), 'nowhere.yaml'),
    ('estimator', ('-p', 'partners:=[plant]'), 'leave partners empty')])
def test_a_map_that_cannot_be_used_is_one_line(node, extra, words):
    done = subprocess.run(
        [sys.executable, '-m', f'hst_drive.nodes.{node}', '--ros-args', '-p',
         'channels:=nowhere.yaml', *extra], env=environment(), timeout=PATIENCE,
        capture_output=True, text=True)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert words in done.stderr
