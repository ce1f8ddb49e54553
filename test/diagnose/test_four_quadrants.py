# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Shafts that turn both ways and drive or are driven, of any size: made up here, and real."""
from pathlib import Path

from hst_drive.bag import read_log
from hst_drive.diagnose.decide import diagnose
from hst_drive.measure.compare import compare, model_of
from hst_drive.measure.run import Run
from hst_drive.rig import parse_rig
import numpy as np
import pytest

REAL = Path(__file__).resolve().parents[3] / 'shared' / 'real'
TIME = np.arange(4000) * 0.005
PUBLISHED = {'coulomb': 20.3935, 'coefficient': 203.5034, 'torque': -3.1648}    # N, N.s/m, N


def sizes(found, lever):
    """Return the sizes of the axis, N and m/s, that a diagnosis found on a lever (m)."""
    assert {entry.id for entry in found.effects} == {
        'bearing_friction', 'viscous_drag', 'constant_torque'}
    values = {key: value.value for entry in found.effects
              for key, value in entry.parameters.items()}
    return {key: values[key] / lever**(2 if key == 'coefficient' else 1) for key in PUBLISHED}


def on_a_lever(time, speed, force, mass, lever):
    """Return the diagnosis of an axis as a shaft with a lever (m)."""
    rig = parse_rig({'motor': {'inertia_total_kg_m2': mass * lever**2}})
    return diagnose(rig, [Run('axis', time, {'motor_speed': speed / lever,
                                             'motor_torque': force * lever}, 'axis.csv')])


def adopted(result, mass, lever):
    """Return the rig of an axis on a lever (m), with what was found."""
    effects = {entry.id: {key: value.value for key, value in entry.parameters.items()}
               for entry in result.effects}
    rig = parse_rig({'motor': {'inertia_total_kg_m2': mass * lever**2}, 'effects': effects})
    assert rig.effects == effects
    return rig


def axis():
    """Return speed and force of an axis with Coulomb and viscous friction and an offset."""
    speed = 0.12 * np.sin(2 * np.pi * 0.4 * TIME) + 0.08 * np.sin(2 * np.pi * 0.13 * TIME)
    force = 95.0 * np.gradient(speed, TIME) + 200.0 * speed + 20.0 * np.sign(speed) - 4.0
    return speed, force + 0.5 * np.random.default_rng(1).standard_normal(len(TIME))


def test_an_axis_is_the_same_on_any_lever():
    found = []
    for lever in (0.003, 0.1, 30.0):
        result = on_a_lever(TIME, *axis(), 95.0, lever)
        found.append(sizes(result, lever))
        # What was found can be written into the rig file of such a machine.
        adopted(result, 95.0, lever)
    for entry in found:
        assert entry == pytest.approx(found[0], rel=1e-3)
        assert entry == pytest.approx(
            {'coulomb': 20.0, 'coefficient': 200.0, 'torque': -4.0}, rel=0.03)


@pytest.mark.parametrize('way', [1.0, -1.0])
@pytest.mark.parametrize('braking', [20.0, -4.0])
def test_in_one_direction_what_brakes_is_dry_friction_and_what_drives_is_not(way, braking):
    speed = 0.12 + 0.08 * np.sin(2 * np.pi * 0.13 * TIME)
    force = 95.0 * np.gradient(speed, TIME) + 200.0 * speed + braking
    force += 0.5 * np.random.default_rng(1).standard_normal(len(TIME))
    found = on_a_lever(TIME, way * speed, way * force, 95.0, 0.01)
    named = {entry.id: next(iter(entry.parameters.values())) for entry in found.effects}
    name, size = ('bearing_friction', braking) if braking > 0.0 else (
        'constant_torque', way * braking)
    assert {*named} == {'viscous_drag', name}
    assert not any(entry.indistinguishable_from for entry in found.effects)
    assert named[name].value == pytest.approx(0.01 * size, rel=0.03)


def motor(random, ports):
    """Return a bench on which a hydromotor drives and is driven; it loses 12 % and 0.3 N.m."""
    time = np.arange(6000) * 0.02
    speed = 150.0 + 300.0 * np.sin(2 * np.pi * time / 9.0)
    high, low = (1e5 * np.maximum(80.0 * np.sin(2 * np.pi * time / 31.0 + shift), 0.0) + 2e5
                 for shift in (0.0, np.pi))
    ideal = (high - low) * 4.9e-6 / (2 * np.pi)
    torque = ideal - np.sign(speed) * (0.12 * np.abs(ideal) + 0.3)
    torque += 0.05 * random.standard_normal(len(time))
    high, low = (port + 1e4 * random.standard_normal(len(time)) for port in (high, low))
    pressures = {'motor_inlet_pressure': high, 'motor_outlet_pressure': low} if ports else {
        'motor_inlet_pressure': high - low}
    return Run('bench', time, {**pressures, 'motor_speed': speed, 'motor_torque': torque},
               'bench.csv')


@pytest.mark.parametrize('ports', [True, False])
def test_a_motor_that_brakes_loses_what_it_loses_when_it_drives(ports):
    rig = parse_rig({'motor': {'displacement_cc_rev': 4.9}})
    found = diagnose(rig, [motor(np.random.default_rng(2), ports)])
    named, = found.effects
    assert (found.verdict, named.id) == ('missing_effect', 'bearing_friction')
    for key, true in {'coulomb': 0.3, 'load_share': 0.12}.items():
        size = named.parameters[key]
        assert size.low < true < size.high and size.value == pytest.approx(true, rel=0.05)


def test_operating_points_apart_are_no_noise():
    speed = np.where(np.arange(40) % 2, 100.0, 200.0)
    pressure = 1e5 * (20.0 + np.arange(40))
    run = Run('table', np.arange(40) * 4000.0, {
        'motor_inlet_pressure': pressure, 'motor_speed': speed,
        'motor_torque': pressure * 4.9e-6 / (2 * np.pi) - 0.004 * speed}, 'table.csv')
    found = diagnose(parse_rig({'motor': {'displacement_cc_rev': 4.9}}), [run])
    assert 'viscous_drag' in {name for entry in found.effects
                              for name in (entry.id, *entry.indistinguishable_from)}


@pytest.mark.skipif(not REAL.exists(), reason='the real recordings are not there')
@pytest.mark.parametrize('lever', [0.003, 3.0])
def test_a_real_axis(lever):
    table = np.genfromtxt(REAL / 'emps_axis' / 'emps_axis.csv', delimiter=',', skip_header=1)
    time, speed, force = table[::4, [0, 2, 4]].T
    result = on_a_lever(time, speed, force, 95.1089, lever)
    assert sizes(result, lever) == pytest.approx(PUBLISHED, rel=0.1)
    rig = adopted(result, 95.1089, lever)
    run = Run('axis', time, {'motor_speed': speed / lever, 'motor_torque': force * lever})
    left = compare(model_of(rig, [run]), [run])
    assert left.signals['motor_torque'].rmse / lever < 2.6      # N; least squares leave 2.41


@pytest.mark.skipif(not REAL.exists(), reason='the real recordings are not there')
@pytest.mark.parametrize('part, of', [(0, 2), (1, 2), (0, 3), (1, 3), (2, 3)])
def test_any_section_of_a_real_axis_has_the_same_friction(part, of):
    """Half of them is too short to tell the offset as well."""
    table = np.genfromtxt(REAL / 'emps_axis' / 'emps_axis.csv', delimiter=',', skip_header=1)
    rows = slice(part * len(table) // of, (part + 1) * len(table) // of, 2)
    found = on_a_lever(*table[rows, :][:, [0, 2, 4]].T, 95.1089, 0.1)
    values = {key: value.value / 0.1**(2 if key == 'coefficient' else 1)
              for entry in found.effects for key, value in entry.parameters.items()}
    assert found.verdict in ('missing_effect', 'ambiguous')
    assert {'bearing_friction', 'viscous_drag'} <= {entry.id for entry in found.effects}
    for key in ('coulomb', 'coefficient'):
        assert values[key] == pytest.approx(PUBLISHED[key], rel=0.1)


@pytest.mark.skipif(not REAL.exists(), reason='the real recordings are not there')
@pytest.mark.parametrize('least', [-1e9, 3e5])
def test_a_real_motor_with_both_ports(least):
    run = read_log(str(REAL / 'mbari_motor' / 'vented_spring.csv'))
    keep = np.maximum(run['motor_inlet_pressure'], run['motor_outlet_pressure']) > least
    rows = Run(run.name, run.time[keep],
               {name: values[keep] for name, values in run.channels.items()}, run.source)
    named, = diagnose(parse_rig({'motor': {'displacement_cc_rev': 4.916}}), [rows]).effects
    assert named.id == 'bearing_friction'
    assert named.parameters['load_share'].value == pytest.approx(0.2, abs=0.05)
