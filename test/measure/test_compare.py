# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Comparison of several logs, and with the controller in the loop."""
from dataclasses import replace
from pathlib import Path

from hst_drive.bag import read_log
from hst_drive.bag.align import align, Signal
from hst_drive.control import PiController
from hst_drive.errors import InputError
from hst_drive.measure.closed_loop import command_floor
from hst_drive.measure.compare import compare, model_of
from hst_drive.measure.readings import Readings
from hst_drive.measure.run import Run
from hst_drive.model import Drive, SensorBank
from hst_drive.model.steady import operating_point
from hst_drive.rig import default_rig
import numpy as np
import pytest

from .synthetic import record

RIG = default_rig()
SAMPLE = Path(__file__).resolve().parents[3] / 'shared' / 'cases' / 'no_effect' / 'drilling.csv'


def closed_loop_record(duration, effects=None):
    """Return a recording of model and controller, which reads the speed with its noise."""
    drive, bank = Drive(RIG, effects), SensorBank(RIG, 3)
    law = PiController(RIG.controller.kp, RIG.controller.ki, 0.01, (0, 10))
    point = operating_point(drive, 9.5, pprv_command=2.0)
    state, command = point.state.copy(), point.pump_command
    law.reset(command)
    time = np.arange(int(duration * 100)) * 0.01
    setpoint = np.where(time < duration / 2, 9.5, 10.5)
    pprv = np.where(time < duration / 3, 2.0, 3.0)
    rows = []
    for k in range(len(time)):
        row = bank.read(drive.outputs(state, pump_command=command, pprv_command=pprv[k]))
        command = law.update(setpoint[k], row['motor_speed'])
        rows.append({**row, 'pump_command': command})
        state = drive.advance(state, 0.01, pump_command=command, pprv_command=pprv[k])
    channels = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return Run('loop', time, {**channels, 'pprv_command': pprv, 'speed_setpoint': setpoint},
               'loop.csv')


@pytest.mark.needs_numba
def test_closed_loop_gives_the_command_within_its_noise():
    entry = compare(Drive(RIG), [closed_loop_record(20.0)], closed_loop=True).signals
    assert entry['pump_command'].noise_ratio < 1.3
    assert entry['pump_command'].rmse < 0.002
    assert entry['motor_speed'].noise_ratio < 1.3


@pytest.mark.needs_numba
def test_closed_loop_holds_a_set_point_through_its_gaps():
    run = closed_loop_record(20.0)
    run.channels['speed_setpoint'][np.arange(len(run)) % 3 == 2] = np.nan
    assert compare(Drive(RIG), [run], closed_loop=True).signals['pump_command'].noise_ratio < 1.3


@pytest.mark.needs_numba
@pytest.mark.parametrize('kept', [
    lambda time: np.arange(len(time)) % 20 == 0, lambda time: (time < 31.0) | (time > 31.5)],
    ids=['slow rows', 'a pause'])
def test_closed_loop_steps_between_the_rows(kept):
    run = closed_loop_record(60.0)
    rows = kept(run.time)
    run = replace(run, time=run.time[rows], channels={
        name: values[rows] for name, values in run.channels.items()})
    assert compare(Drive(RIG), [run], closed_loop=True).signals['pump_command'].noise_ratio < 1.3


@pytest.mark.needs_numba
def test_closed_loop_shows_a_hidden_effect_in_the_command():
    run = closed_loop_record(20.0, {'motor_leakage': {'conductance': 3e-12}})
    signals = compare(Drive(RIG), [run], closed_loop=True).signals
    # The controller hides it in the speed.
    assert signals['pump_command'].noise_ratio > 20 > signals['motor_speed'].noise_ratio


@pytest.mark.needs_numba
@pytest.mark.skipif(not SAMPLE.is_file(), reason='the sample campaigns are not here')
def test_closed_loop_on_a_sample():
    signals = compare(Drive(RIG), [read_log(SAMPLE)], closed_loop=True).signals
    for name in ('pump_command', 'motor_speed', 'pump_outlet_pressure', 'motor_inlet_flow'):
        assert 0.9 < signals[name].noise_ratio < 1.15, name
    assert signals['pump_command'].rmse < 0.0015


@pytest.mark.parametrize('command', [-0.6, 10.6])
def test_the_floor_of_a_command_beyond_the_table_is_that_of_its_end(command):
    drive = Drive(RIG)
    floors = [command_floor(drive, Run('log', np.arange(2.0), {
        'pump_command': np.full(2, volts)}), 1e-3, 1e-2) for volts in (
            command, np.clip(command, 0.0, 10.0))]
    assert floors[0] == floors[1] > 1e-3


@pytest.mark.parametrize('missing', ['speed_setpoint', 'controller'])
def test_what_a_closed_loop_needs(missing):
    run = closed_loop_record(0.5)
    rig = RIG
    if missing == 'controller':
        from dataclasses import replace
        rig = replace(RIG, controller=None)
    else:
        run.channels.pop(missing)
    with pytest.raises(InputError, match=f"'{missing}' is missing"):
        compare(Drive(rig), [run], closed_loop=True)


def test_an_effect_of_the_rig_has_its_place_in_the_circuit():
    run = closed_loop_record(0.5)
    rig = replace(RIG, effects={'valve_lag': {'time_constant': 0.1}})
    with pytest.raises(InputError, match="'valve_lag': has no place in 'circuit: open'"):
        model_of(rig, [run])


def test_several_logs_are_pooled_by_their_samples():
    runs = [record(1, duration=2.0), record(
        2, duration=4.0, settled=True, leave_out=('motor_inlet_flow',))]
    result = compare(Drive(RIG), runs)
    single = [compare(Drive(RIG), [run]).signals for run in runs]
    assert [log.run.name for log in result.logs] == ['synthetic 1', 'synthetic 2']
    assert result.signals['motor_inlet_flow'].rmse == single[0]['motor_inlet_flow'].rmse
    for key in ('rmse', 'floor', 'noise_std', 'bias'):
        power = 1 if key == 'bias' else 2
        one, two = (getattr(signals['motor_speed'], key)**power for signals in single)
        found = getattr(result.signals['motor_speed'], key)**power
        assert found == pytest.approx((one + 2 * two) / 3)
    assert result.signals['motor_speed'].samples == 600
    assert result.signals['motor_speed'].max_abs == max(
        signals['motor_speed'].max_abs for signals in single)


@pytest.mark.needs_numba
@pytest.mark.parametrize('signal, late', [
    ('pump_outlet_pressure', 0.01), ('pump_outlet_pressure', 0.06), ('load_torque', 0.04),
    ('pump_outlet_pressure', 0.12), ('motor_inlet_flow', -0.03), ('motor_inlet_flow', 0.06)])
def test_by_how_much_one_sensor_is_late_is_told(signal, late):
    run = record(5, duration=30.0, roughness=0.3)
    moved = {**run.channels, signal: np.interp(run.time - late, run.time, run[signal])}
    delays = compare(Drive(RIG), [Run('late', run.time, moved, 'late.csv')]).logs[0].delays
    assert delays.pop(signal) == pytest.approx(late, abs=0.002)
    assert all(abs(other) < 0.005 for other in delays.values())


@pytest.mark.needs_numba
@pytest.mark.parametrize('late', [0, 3])
def test_commands_stamped_by_another_clock_are_moved(late):
    run = record(5, duration=20.0, roughness=0.3)
    readings = {name: values if name.endswith('_command')
                else np.concatenate([np.repeat(values[:1], late), values[:len(run) - late]])
                for name, values in run.channels.items()}
    found = compare(Drive(RIG), [Run('late', run.time, readings, 'late.csv')])
    assert found.logs[0].shift == pytest.approx(0.01 * late, abs=0.004)
    # A sensor that tells nothing where the drive is judged changes nothing of that.
    readings['case_drain_flow'] = np.where(run.time < 0.1, 0.0, np.nan)
    found = compare(Drive(RIG), [Run('late', run.time, readings, 'late.csv')])
    assert found.logs[0].shift == pytest.approx(0.01 * late, abs=0.004)


@pytest.mark.needs_numba
def test_missing_physics_is_not_taken_for_another_clock():
    run = record(6, duration=20.0, effects={'pump_lag': {'time_constant': 0.06}})
    assert compare(Drive(RIG), [run]).logs[0].shift == 0.0


def test_a_command_that_is_stamped_between_the_rows_is_not_taken_for_physics():
    """The load's command 3 ms after the readings, as in a bag of nodes: the errors stay."""
    run = record(5)
    stamps = 10**18 + np.round(run.time * 1e9).astype(np.int64)
    found = []
    for late in (0, 3_300_000):
        read = align([Signal(name, stamps + late * (name == 'pprv_command'), values)
                      for name, values in run.channels.items()], 'bag', 'bag')
        found.append(compare(Drive(RIG), [read]).signals)
    for name, entry in found[0].items():
        assert found[1][name].noise_ratio == pytest.approx(entry.noise_ratio, rel=0.03), name


def test_a_record_with_a_pause_has_a_floor_like_the_rest():
    """Ten seconds of rows are lost: what is left is judged as if nothing had been."""
    whole = record(3, duration=40.0)
    keep = (whole.time < 15.0) | (whole.time >= 25.0)
    paused = replace(whole, time=whole.time[keep], channels={
        name: values[keep] for name, values in whole.channels.items()})
    drive = Drive(RIG)
    expected, found = (compare(drive, [run]).signals for run in (whole, paused))
    for name, entry in found.items():
        assert 0.5 < entry.floor / expected[name].floor < 2.0


@pytest.mark.parametrize('channel, step', [
    ('pump_outlet_pressure', 1e5), ('motor_inlet_flow', 1.0 / 60e3), ('motor_speed', np.pi / 30.0),
    ('load_torque', 5.0)])
def test_a_coarse_reading_is_no_missing_physics(channel, step):
    """Steps of 1 bar, 1 L/min, 1 rpm, 5 N.m: ten to fifty values, some times the noise."""
    run = record(3)
    run = replace(run, channels={**run.channels, channel: step * np.round(run[channel] / step)})
    for name, signal in compare(Drive(RIG), [run]).signals.items():
        assert signal.noise_ratio < 1.25, name


def test_steps_are_seen_where_two_coarse_ports_were_subtracted():
    """Their difference is off by rounding; 0.1 bar is 0.1 bar over the root of 12 of noise."""
    random = np.random.default_rng(5)
    time = np.arange(3000) * 0.01
    ports = [np.round(level + 3.0 * np.sin(time / 5.0) + 0.02 * random.standard_normal(3000), 1)
             * 1e5 for level in (80.0, 20.1)]
    run = Run('a', time, {'pump_outlet_pressure': ports[0] - ports[1] + 1e-9 * time})
    assert Readings(run, {}).step('pump_outlet_pressure') == pytest.approx(1e4 / 12**0.5)
