# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Foreign names, fields and units."""
from pathlib import Path

from hst_drive.bag import load_channel_map, read_log
from hst_drive.bag.cdr import Codec
from hst_drive.bag.channels import parse_channel_map
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.long_bag import bag_sections
from hst_drive.bag.topics import CHANNEL_FIELDS, markdown, STANDARD_UNITS, TOPICS
from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.units import si_unit
import numpy as np
import pytest

from .records import write_bag

EXAMPLE = Path(__file__).parents[2] / 'config' / 'channels_example.yaml'
JOINTS = 'sensor_msgs/msg/JointState'
PRESSURE = 'sensor_msgs/msg/FluidPressure'
FLOAT = ('std_msgs/msg/Float64', 'float64 data\n')
TIMES = [10**18 + i * 10**7 for i in range(40)]


def stamp(at):
    return {'stamp': {'sec': at // 10**9, 'nanosec': at % 10**9}}


def encoded(kind, values):
    name, text = kind if isinstance(kind, tuple) else (kind, find_definition(kind))
    codec = Codec(name, text)
    return [(at, codec.encode(values(index, at))) for index, at in enumerate(TIMES)]


@pytest.fixture
def foreign(tmp_path):
    return write_bag(tmp_path / 'foreign', {
        '/rig/joints': (JOINTS, encoded(JOINTS, lambda i, at: {
            'header': stamp(at), 'name': ['fan', 'drill'], 'velocity': [9.0, float(i)],
            'effort': [9.0, -float(i)]})),
        '/rig/p1': (PRESSURE, encoded(PRESSURE, lambda i, at: {
            'header': stamp(at), 'fluid_pressure': 101325.0 + 1e6})),
        '/rig/p2': (FLOAT, encoded(FLOAT, lambda i, at: {'data': 11.01325})),
        '/rig/cmd': (FLOAT, encoded(FLOAT, lambda i, at: {'data': 2.0})),
    })


def test_a_foreign_bag_is_read_by_a_map(foreign):
    run = read_log(foreign, parse_channel_map({'channels': {
        'motor_speed': '/rig/joints.velocity[drill]',
        'load_torque': {'from': '/rig/joints.effort[1]', 'scale': -1},
        'pump_outlet_pressure': {'from': '/rig/p1.fluid_pressure'},
        'motor_inlet_pressure': {'from': '/rig/p2.data', 'unit': 'bar', 'absolute': True},
        'pump_command': {'from': '/rig/cmd.data', 'unit': 'V', 'scale': 2, 'offset': -0.5}}}))
    np.testing.assert_array_equal(run['motor_speed'], np.arange(40.0))
    np.testing.assert_array_equal(run['load_torque'], np.arange(40.0))
    np.testing.assert_allclose(run['pump_outlet_pressure'], 1e6)
    np.testing.assert_allclose(run['motor_inlet_pressure'], 1e6)
    np.testing.assert_allclose(run['pump_command'], 3.5)
    assert any('no stamps' in note for note in run.notes)


DYNAMIC = ('control_msgs/msg/DynamicJointState', '\n'.join([
    'std_msgs/Header header', 'string[] joint_names', 'InterfaceValue[] interface_values',
    '=' * 80, 'MSG: control_msgs/InterfaceValue', 'string[] interface_names', 'float64[] values',
    '=' * 80, 'MSG: std_msgs/Header', find_definition('std_msgs/msg/Header')]))
"""As control_msgs 5 has it, for machines without that package."""


@pytest.fixture
def ros2_control(tmp_path):
    """Return a bag with what a joint_state_broadcaster says of all state interfaces."""
    return write_bag(tmp_path / 'ros2_control', {'/dynamic_joint_states': (
        DYNAMIC, encoded(DYNAMIC, lambda i, at: {
            'header': stamp(at), 'joint_names': ['feed', 'drill', 'valve'], 'interface_values': [
                {'interface_names': ['velocity'], 'values': [9.0]},
                {'interface_names': ['pressure', 'velocity'], 'values': [50.0 + i, float(i)]},
                {'interface_names': ['voltage'], 'values': [4.5]}]}))})


def test_interfaces_of_ros2_control_go_by_joint_and_interface(ros2_control):
    values = '/dynamic_joint_states.interface_values'
    run = read_log(ros2_control, parse_channel_map({'channels': {
        'motor_speed': {'from': f'{values}[drill].values[velocity]', 'unit': 'rad/s'},
        'pump_outlet_pressure': {'from': f'{values}[drill].values[pressure]', 'unit': 'bar'},
        'pump_command': {'from': f'{values}[2].values[0]', 'unit': 'V'},
        'pprv_command': {'from': f'{values}[valve].values[voltage]', 'unit': 'V'}}}))
    np.testing.assert_array_equal(run['motor_speed'], np.arange(40.0))
    np.testing.assert_allclose(run['pump_outlet_pressure'], (50.0 + np.arange(40.0)) * 1e5)
    assert set(run['pump_command']) == set(run['pprv_command']) == {4.5}
    with pytest.raises(InputError, match='length 2: elements 0 to 1 or pressure, velocity'):
        read_log(ros2_control, parse_channel_map({'channels': {'motor_speed': {
            'from': f'{values}[drill].values[speed]', 'unit': 'rad/s'}}}))
    with pytest.raises(InputError, match='length 3: elements 0 to 2 or feed, drill, valve'):
        read_log(ros2_control, parse_channel_map({'channels': {'motor_speed': {
            'from': f'{values}[dril].values[velocity]', 'unit': 'rad/s'}}}))


@pytest.mark.parametrize('entry, said', [
    ('/rig/jonts.velocity[0]', r'no topic /rig/jonts; did you mean /rig/joints\?'),
    ('/rig/joints.velocty[0]', "no field 'velocty"),
    ('/rig/joints', 'add the field'),
    ('/rig/p2.data', 'needs its unit'),
    ('/rig/p1.fluid_pressure', 'which is no motor_speed'),
    ('/rig/joints.velocity[2]', r"/rig/joints has no 'velocity\[2\]'; velocity of its messages "
     'has length 2: elements 0 to 1 or fan, drill'),
    ('/rig/joints.velocity[dril]', 'length 2: elements 0 to 1 or fan, drill'),
    ({'from': '/rig/joints.position[0]', 'unit': 'rad/s'}, 'length 0: no elements'),
])
def test_a_map_that_does_not_fit_the_bag(foreign, entry, said):
    with pytest.raises(InputError, match=said) as why:
        read_log(foreign, parse_channel_map({'channels': {'motor_speed': entry}}, 'm.yaml'))
    assert str(why.value).startswith('m.yaml: channels.motor_speed')


def test_a_foreign_csv_is_read_by_a_map(tmp_path):
    path = tmp_path / 'log.csv'
    rows = [f'{i * 10},{i},212,{200 + i}' for i in range(20)]
    path.write_text('\n'.join(['t,AI3,T_oil[degF],P', *rows]))
    (tmp_path / 'map.yaml').write_text(
        'time: {from: t, unit: ms}\nchannels:\n'
        '  pump_command: {from: AI3, unit: V, scale: 2.0, offset: -0.05}\n'
        '  oil_temperature: T_oil[degF]\n'
        '  pump_outlet_pressure: {from: P, unit: kPa, absolute: true}\n')
    run = read_log(path, tmp_path / 'map.yaml')
    np.testing.assert_allclose(run.time, np.arange(20) * 0.01)
    np.testing.assert_allclose(run['pump_command'], 2.0 * np.arange(20) - 0.05)
    np.testing.assert_allclose(run['oil_temperature'], 373.15)
    np.testing.assert_allclose(run['pump_outlet_pressure'], (200 + np.arange(20)) * 1e3 - 101325)


def test_a_channel_may_be_the_difference_of_two(foreign, tmp_path):
    """Two ports of a hydromotor, in units of their own."""
    path = tmp_path / 'log.csv'
    path.write_text('\n'.join(['time[s],A[bar],B', *(
        f'{0.01 * i:g},{100 + i},{300 * i}' for i in range(20))]))
    run = read_log(path, parse_channel_map({'channels': {'motor_inlet_pressure': {
        'minus': ['A', {'from': 'B', 'unit': 'kPa'}]}}}))
    assert list(run.channels) == ['motor_inlet_pressure']
    np.testing.assert_allclose(run['motor_inlet_pressure'], 1e7 - 2e5 * np.arange(20), atol=1e-6)
    both = {'from': '/rig/joints.velocity[drill]'}
    run = read_log(foreign, parse_channel_map({'channels': {'motor_speed': {
        'minus': [both, {**both, 'scale': 0.25}]}}}))
    np.testing.assert_allclose(run['motor_speed'], 0.75 * np.arange(40.0))


def test_a_map_that_does_not_fit_the_csv(tmp_path):
    path = tmp_path / 'log.csv'
    path.write_text('\n'.join(['time[s],AI3', *(f'{i},{i}' for i in range(20))]))
    for entry, said in (('AI4', "no column 'AI4'; did you mean 'AI3'"),
                        ('AI3', "'AI3' has no unit")):
        with pytest.raises(InputError, match=said):
            read_log(path, parse_channel_map({'channels': {'pump_command': entry}}, 'm.yaml'))


@pytest.mark.parametrize('data, said', [
    (None, 'expected a mapping'),
    ({'chanels': {}}, "unknown key 'chanels'; did you mean 'channels'"),
    ({None: {}}, 'unknown key None'),
    ({'channels': []}, None),
    ({'channels': [1]}, 'must map our names'),
    ({'channels': {'motor_sped': 'x'}}, "no such channel; did you mean 'motor_speed'"),
    ({'channels': {'motor_speed': 3}}, 'expected {from'),
    ({'channels': {'motor_speed': {'unit': 'rpm'}}}, 'expected {from'),
    ({'channels': {'motor_speed': {'minus': ['x']}}}, 'expected {minus'),
    ({'channels': {'motor_speed': {'minus': ['x', 'y'], 'scale': 2}}}, 'nothing beside'),
    ({'channels': {'motor_speed': {'minus': ['x', 3]}}}, 'minus: expected {from'),
    ({'channels': {'motor_speed': {'minus': ['x', {'minus': ['y', 'z']}]}}}, 'in another'),
    ({'channels': {'motor_speed': {'from': 'x', 'unt': 'rpm'}}}, "'unt'; did you mean 'unit'"),
    ({'channels': {'motor_speed': {'from': 'x', 'unit': 'bar'}}}, 'another quantity'),
    ({'channels': {'motor_speed': {'from': 'x', 'unit': 'rmp'}}}, 'unknown unit'),
    ({'channels': {'motor_speed': {'from': 'x', 'scale': 'two'}}}, 'scale: expected a number'),
    ({'channels': {'motor_speed': {'from': 'x', 'scale': 0}}}, 'wipe'),
    ({'channels': {'motor_speed': {'from': 'x', 'scale': float('nan')}}}, 'expected a number'),
    ({'channels': {'motor_speed': {'from': 'x', 'offset': 10**400}}}, 'expected a number'),
    ({'channels': {'motor_speed': {'from': 'x', 'absolute': True}}}, 'only for pressures'),
    ({'namespace': 'a'}, 'begins with /'),
])
def test_maps_are_strict(data, said):
    if said is None:
        assert not parse_channel_map(data).entries
        return
    with pytest.raises(InputError, match=said):
        parse_channel_map(data)


def test_unreadable_maps(tmp_path):
    with pytest.raises(InputError, match='cannot be read'):
        load_channel_map(tmp_path / 'none.yaml')
    (tmp_path / 'bad.yaml').write_text('a: [')
    with pytest.raises(InputError, match='bad.yaml: line 1: .*; mend the YAML') as why:
        load_channel_map(tmp_path / 'bad.yaml')
    assert '\n' not in str(why.value)
    (tmp_path / 'twice.yaml').write_text('channels:\n  pump_command: A[V]\n  pump_command: B[V]\n')
    with pytest.raises(InputError, match="line 3: key 'pump_command' is written twice; keep one"):
        load_channel_map(tmp_path / 'twice.yaml')


def test_the_example_is_a_good_map():
    assert len(load_channel_map(EXAMPLE).entries) == 9     # of two the difference


def test_the_table_of_topics_is_consistent():
    assert set(CHANNEL_FIELDS) == set(CHANNELS)
    for topic in TOPICS.values():
        codec = Codec(topic.type, find_definition(topic.type))
        for field in topic.fields:
            if topic.name != '/clock':
                codec.check_path(field.path)
            if field.channel:
                assert si_unit(field.unit) == CHANNELS[field.channel].unit
            known = STANDARD_UNITS.get((topic.type, field.path.partition('[')[0]))
            assert known in (None, (field.unit, field.absolute))


def test_the_documented_table_is_the_table():
    """Every topic is in it, also those that carry words."""
    assert all(f'`{topic.full_name()}`' in markdown() for topic in TOPICS.values())
    page = Path(__file__).resolve().parents[2] / 'docs' / 'topics.md'
    assert markdown() in page.read_text(encoding='utf-8')


@pytest.mark.parametrize('silent', [False, True])
def test_a_difference_without_its_second_half_is_left_out(tmp_path, silent):
    """A topic without messages, or of two publishers: the first half alone is another thing."""
    codec = Codec(PRESSURE, find_definition(PRESSURE))

    def sent(values):
        return PRESSURE, [(at, codec.encode({'header': stamp(at), 'fluid_pressure': value}))
                          for at, value in zip(TIMES, values)]
    write_bag(tmp_path / 'b', {
        '/a': sent([3e7] * 40), '/b': sent([] if silent else [9e6, 2e7] * 20),
        '/c': sent([3e5] * 40)})
    mapped = parse_channel_map({'channels': {
        'motor_inlet_pressure': {'minus': ['/a.fluid_pressure', '/b.fluid_pressure']},
        'motor_outlet_pressure': '/c.fluid_pressure'}})
    for run in (read_log(tmp_path / 'b', mapped),
                next(bag_sections(tmp_path / 'b', mapped, 60.0, 5.0, 2.0)).run):
        assert [*run.channels] == ['motor_outlet_pressure']
        assert 'motor_inlet_pressure: what the map takes off it is missing; left out' in run.notes
