# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A swapped sign of one channel is told as such, in one line; sound signs are not."""
from dataclasses import replace
from pathlib import Path
from test.measure.test_circuit import campaign

from hst_drive.bag import read_log
from hst_drive.errors import InputError
from hst_drive.measure.plausibility import refuse_wrong_units, unit_doubts
from hst_drive.measure.run import Run
from hst_drive.rig import parse_rig
import numpy as np
import pytest

REAL = Path(__file__).resolve().parents[3] / 'shared' / 'real'
TIME = np.arange(3000) * 0.02
MOTOR = parse_rig({'motor': {'displacement_cc_rev': 4.9}})
AXIS = parse_rig({'motor': {'inertia_total_kg_m2': 95.0}})
SIZE = 4.9e-6 / (2 * np.pi)     # m^3/rad
WRONG = 'wrong sign; add scale: -1'


def axis():
    """Return a mass that turns both ways, with friction and an offset."""
    speed = 0.12 * np.sin(2 * np.pi * 0.4 * TIME) + 0.08 * np.sin(2 * np.pi * 0.13 * TIME)
    torque = 95.0 * np.gradient(speed, TIME) + 200.0 * speed + 20.0 * np.sign(speed) - 4.0
    return Run('axis', TIME, {'motor_speed': speed, 'motor_torque': torque}, 'axis.csv')


def bench(both_ways=True, loss=0.12):
    """Return a bench of a hydromotor that drives and is driven, or drives one way only."""
    random = np.random.default_rng(3)
    speed = (0.0 if both_ways else 400.0) + 300.0 * np.sin(2 * np.pi * TIME / 9.0)
    pressure = 1e5 * ((0.0 if both_ways else 90.0) + 80.0 * np.sin(2 * np.pi * TIME / 31.0))
    ideal = pressure * SIZE
    torque = ideal - np.sign(speed) * (loss * np.abs(ideal) + 0.1)
    return Run('bench', TIME, {
        'motor_speed': speed, 'motor_inlet_pressure': pressure,
        'motor_torque': torque + 0.02 * random.standard_normal(len(TIME))}, 'bench.csv')


def pump():
    """Return a bench of a pump of fixed displacement."""
    pressure = 1e5 * (100.0 + 80.0 * np.sin(TIME / 5))
    speed = 150.0 + 20.0 * np.sin(TIME / 3)
    return Run('pump', TIME, {
        'pump_speed': speed, 'pump_outlet_pressure': pressure,
        'motor_inlet_flow': 10e-6 / (2 * np.pi) * speed - 1e-13 * pressure}, 'pump.csv')


def driven():
    """Return a bench of the same pump with the power at its shaft."""
    run = pump()
    power = 1.1 * 10e-6 / (2 * np.pi) * run['pump_outlet_pressure'] * run['pump_speed']
    return replace(run, channels={**run.channels, 'pump_power': power})


FIXED = parse_rig({'pump': {'shaft_speed_rpm': 1450, 'max_displacement_cc_rev': 10.0}})


def spoilt(run, *names):
    """Return a recording with channels turned round."""
    return replace(run, channels={**run.channels, **{name: -run[name] for name in names}})


@pytest.mark.parametrize('rig, run', [
    (AXIS, axis()), (MOTOR, bench()), (MOTOR, bench(False)), (MOTOR, bench(loss=0.0)),
    (FIXED, pump()), (FIXED, driven())])
def test_sound_signs_are_not_doubted(rig, run):
    assert unit_doubts(rig, run) == []


@pytest.mark.parametrize('rig, run, channel', [
    (MOTOR, bench(), 'motor_speed'), (MOTOR, bench(), 'motor_torque'),
    (MOTOR, bench(), 'motor_inlet_pressure'), (MOTOR, bench(False), 'motor_speed'),
    (MOTOR, bench(False), 'motor_torque')])
def test_the_channel_is_named(rig, run, channel):
    with pytest.raises(InputError, match=f'bench.csv: {channel} seems to have the {WRONG}') as it:
        refuse_wrong_units(rig, [spoilt(run, channel)])
    assert '\n' not in str(it.value)


@pytest.mark.parametrize('rig, run, channel, others', [
    (AXIS, axis(), 'motor_torque', 'motor_speed or motor_torque'),
    (FIXED, pump(), 'motor_inlet_flow', 'motor_inlet_flow or pump_speed'),
    (FIXED, driven(), 'pump_power', 'pump_power or pump_outlet_pressure')])
def test_what_the_balances_cannot_tell_apart_is_named_together(rig, run, channel, others):
    told, = unit_doubts(rig, spoilt(run, channel))
    assert told.startswith(f'{others} seems to have the {WRONG}')


def test_a_torque_or_a_pressure_that_is_off_is_no_swapped_speed():
    run = bench(False)
    for name, change in (('motor_torque', lambda values: 1.2 * values),
                         ('motor_inlet_pressure', lambda values: values - 20e5)):
        assert unit_doubts(MOTOR, replace(run, channels={
            **run.channels, name: change(run[name])})) == []


@pytest.mark.skipif(not REAL.exists(), reason='the real recordings are not there')
def test_a_real_motor():
    rig = parse_rig({'motor': {'displacement_cc_rev': 4.916}})
    run = read_log(str(REAL / 'mbari_motor' / 'vented_spring.csv'))
    assert unit_doubts(rig, run) == []
    for name in ('motor_speed', 'motor_torque'):
        told, = unit_doubts(rig, spoilt(run, name))
        assert told.startswith(f'{name} seems to have the {WRONG}')
    ports = ('motor_inlet_pressure', 'motor_outlet_pressure')
    exchanged = replace(run, channels={**run.channels, ports[0]: run[ports[1]],
                                       ports[1]: run[ports[0]]})
    told, = unit_doubts(rig, exchanged)
    assert told.startswith('motor_inlet_pressure and motor_outlet_pressure seem to be exchanged')


LINES = 'line_a_pressure and line_b_pressure'


@pytest.mark.parametrize('circuit, seed', [('closed', 9660), ('valve', 9600)])
def test_of_other_circuits_commands_and_lines_are_told_as_well(circuit, seed, tmp_path):
    rig, logs, _ = campaign(tmp_path, '--circuit', circuit, '--kind', 'none', '--seed', str(seed))
    run = next(iter(logs.values()))
    assert unit_doubts(rig, run) == []
    command = 'pump_command' if circuit == 'closed' else 'valve_command'
    assert command in run
    for name in ('motor_speed', 'motor_torque', command):
        if name in run:
            told, = unit_doubts(rig, spoilt(run, name))
            assert told.startswith(f'{name} seems to have the {WRONG}')
    one, other = LINES.split(' and ')
    told, = unit_doubts(rig, replace(run, channels={
        **run.channels, one: run[other], other: run[one]}))
    assert told.startswith(f'{LINES} seem to be exchanged')
    off = replace(run, channels={**run.channels, command: 0.7 * run[command]})
    assert not any('exchanged' in told for told in unit_doubts(rig, off))
