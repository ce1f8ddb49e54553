# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Diagnosis of circuits beside the open one, on machines of an independent generator."""
from dataclasses import replace
import re
from test.measure.test_circuit import campaign

from hst_drive.diagnose.decide import diagnose
from hst_drive.identify.calibrate import calibrated
from hst_drive.identify.model import Model
from hst_drive.identify.part import campaign_of
import numpy as np
import pytest


def _slowly(run):
    """Return a recording with ten rows a second."""
    step = round(0.1 / run.sample_time)
    return replace(run, time=run.time[::step], channels={
        name: values[::step] for name, values in run.channels.items()})


def _diagnosed(rig, logs):
    """Diagnose a campaign, its last log held out."""
    return diagnose(rig, [run for name, run in logs.items() if name != 'holdout'],
                    [logs['holdout']])


@pytest.mark.slow
@pytest.mark.parametrize('effect, seed', [
    ('suction_starvation=1.083', 7001), ('gear_backlash=0.71', 7002),
    ('pump_speed_droop=0.571', 7011), ('cross_port_leakage=0.927', 7018)])
def test_a_closed_circuit_names_first_what_others_imitate(tmp_path, effect, seed):
    """Beside a leakage that follows viscosity, which each machine of that generator has."""
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--effect', effect,
                                '--seed', str(seed))
    found = _diagnosed(rig, logs)
    name, = truth['effects']
    first, *others = found.effects
    assert first.id == name and found.probability.effects[name] > 0.8
    assert {entry.id for entry in others} <= {'leakage_temperature'}


@pytest.mark.slow
@pytest.mark.parametrize('seed, named', [(26023, 'speed_sensor_lag'), (26028, 'constant_torque')])
def test_what_commands_did_between_slow_rows_hides_no_effect(tmp_path, seed, named):
    """The controller steps ten times as often."""
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--kind', 'single',
                                '--seed', str(seed))
    held_out, *runs = [_slowly(run) for run in (logs.pop('holdout'), *logs.values())]
    assert [*truth['effects']] == [named]
    found = diagnose(rig, runs, [held_out])
    assert [entry.id for entry in found.effects] == [named]


@pytest.mark.slow
def test_a_small_leak_is_named_beside_a_play_that_leaves_little(tmp_path):
    """The leak takes a fortieth of what the play leaves, which is below the floor."""
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--effect',
                                'pump_hysteresis=1.2,cross_port_leakage=1.2', '--seed', '30202')
    found = _diagnosed(rig, logs)
    named = [entry.id for entry in found.effects]
    assert {*truth['effects']} <= {*named} <= {*truth['effects'], 'leakage_temperature'}


@pytest.mark.slow
def test_a_slow_plate_is_named_though_the_fit_starts_from_a_slower_one(tmp_path):
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--kind', 'single',
                                '--seed', '23027')
    first = diagnose(rig, list(logs.values())).effects[0]
    assert [first.id] == [*truth['effects']] == ['pump_rate_limit']
    assert first.parameters['full_stroke_time'].value == pytest.approx(
        1.0 / truth['si_parameters']['rate_limit'], rel=0.02)


@pytest.mark.slow
def test_a_leak_is_named_whose_power_runs_to_its_end_when_all_rows_count(tmp_path):
    """A pump that leaks as gap and orifice together; without a flow meter it may be the motor."""
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--kind', 'single',
                                '--seed', '9683')
    assert [*truth['effects']] == ['pump_leakage']
    found = _diagnosed(rig, logs)
    first = found.effects[0]
    assert 'pump_leakage' in (first.id, *first.indistinguishable_from)


@pytest.mark.slow
@pytest.mark.parametrize('kind, seed, named', [
    # A worn hydromotor leaks from both lines: from one alone it looked like an opening.
    ('single', 9221, ['motor_leakage']),
    # Its volume and its precharge are known but for their product.
    ('single', 9228, ['accumulator']),
    # A lag that the unit's tolerance allows, and a leak from line to line, were named beside it.
    ('none', 9600, ['leakage_temperature']), ('single', 9601, ['elastic_leakage'])])
def test_behind_a_valve_what_is_there_is_named_alone(tmp_path, kind, seed, named):
    rig, logs, truth = campaign(tmp_path, '--circuit', 'valve', '--kind', kind,
                                '--seed', str(seed))
    assert kind == 'none' or [*truth['effects']] == named
    found = _diagnosed(rig, logs)
    assert [entry.id for entry in found.effects] == named
    for entry in found.effects:
        size = next(iter(entry.parameters.values()))
        assert 0.0 < size.low < size.value < size.high


def test_commands_that_move_between_slow_rows_make_no_valve_faster(tmp_path):
    """Rows of 20 ms of a controller of 10 ms: held from row to row they come 5 ms late."""
    rig, logs, truth = campaign(tmp_path, '--circuit', 'valve', '--kind', 'none', '--seed', '9235')
    found = calibrated(campaign_of(rig, [*logs.values()]))
    assert truth['rate_hz'] == 50.0
    assert found.model.scales['valve.lag'] == pytest.approx(
        truth['scatter']['valve.lag'], abs=0.06)


def test_a_sensor_that_would_tell_rivals_apart_is_named(tmp_path):
    """Without a case drain's meter it may be the pump that leaks or the hydromotor."""
    rig, logs, _ = campaign(tmp_path, '--circuit', 'closed', '--kind', 'none', '--seed', '7004')
    models = [Model({name: {'conductance': 1e-11, 'exponent': 1.0}})
              for name in ('motor_leakage', 'pump_leakage')]
    said = []
    for more in ((), ('case_drain_flow',)):
        runs = [replace(run, channels={name: run[name] for name in (
            'pump_command', 'line_a_pressure', 'line_b_pressure', 'motor_speed', *more)})
            for run in logs.values()]
        said.append(campaign_of(rig, runs).to_record(models))
    named = {*re.findall(r'\((\w+)\)', said[0])}
    assert named == {'motor_inlet_flow', 'case_drain_flow'}
    assert 'case_drain_flow' not in said[1]


@pytest.mark.slow
@pytest.mark.parametrize('seed', [28001, 28002])
def test_a_servo_valve_before_the_plate_takes_a_part_of_its_lag(tmp_path, seed):
    """A sheet tells one lag for both; a seventh of it is the valve's."""
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--effect', 'pump_lag=0.17',
                                '--seed', str(seed))
    whole = rig.pump.displacement_lag + truth['si_parameters']['extra_lag']
    rig = replace(rig, pump=replace(rig.pump, displacement_lag=whole))
    found = _diagnosed(rig, logs)
    assert {entry.id for entry in found.effects} <= {'leakage_temperature'}
    assert found.verdict != 'unknown'


@pytest.mark.slow
def test_an_actuator_that_is_slower_than_that_is_still_named(tmp_path):
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--effect', 'pump_lag=0.5',
                                '--seed', '28003')
    found = {entry.id: entry for entry in _diagnosed(rig, logs).effects}
    lag = found['pump_lag'].parameters['time_constant']
    assert lag.low < truth['si_parameters']['extra_lag'] < lag.high


@pytest.mark.slow
@pytest.mark.parametrize('effect, seed, enters', [
    ('leaking_check_valve', 32002, 'flow'), ('leaking_check_valve', 32003, 'flow'),
    ('one_way_drag', 32011, 'torque')])
def test_what_acts_one_way_only_is_not_two_effects(tmp_path, effect, seed, enters):
    """A leak from one line is an offset beside a leak of both, but for its form."""
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--effect', f'{effect}=1.5',
                                '--seed', str(seed))
    assert [*truth['enters']] == [effect]
    found = _diagnosed(rig, logs)
    assert (found.verdict, found.unknown.enters) == ('unknown', enters)


@pytest.mark.slow
def test_a_dead_time_is_no_lag(tmp_path):
    """A bus that takes 60 ms to the pump: it was told as a slow actuator, 0.9."""
    rig, logs, _ = campaign(tmp_path, '--circuit', 'closed', '--kind', 'none', '--seed', '32053')
    logs = {name: replace(run, channels={**run.channels, 'pump_command': np.interp(
        run.time + 0.06, run.time, run['pump_command'])}) for name, run in logs.items()}
    found = _diagnosed(rig, logs)
    assert (found.verdict, found.unknown.enters) == ('unknown', 'pump_actuator')
    assert 'dead time' in found.sentence


@pytest.mark.slow
@pytest.mark.parametrize('more', [
    ('--effect', 'pump_lag=1', '--seed', '32061'),
    # Three stages in a row: two pilots that are as slow as the plate were a dead time of 83 ms.
    ('--kind', 'single', '--seed', '35001')])
def test_a_lag_is_no_dead_time(tmp_path, more):
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', *more)
    assert [*truth['enters']] == ['pump_lag']
    found = _diagnosed(rig, logs)
    assert found.verdict == 'missing_effect' and found.effects[0].id == 'pump_lag'


@pytest.mark.slow
@pytest.mark.parametrize('effect, seed, alone', [
    # Its truth yields at once: oil that is compressed was named, 0.87 and 0.92.
    ('swash_compliance=1.73', 35003, False), ('swash_compliance=1.3', 36104, False),
    # Where the displacement is measured both are told.
    ('swash_compliance=1.3', 36102, True), ('compressibility_flow=1.3', 36101, True)])
def test_a_plate_that_yields_is_told_from_oil_by_its_displacement(tmp_path, effect, seed, alone):
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--effect', effect,
                                '--seed', str(seed))
    found = _diagnosed(rig, logs)
    first, *others = found.effects
    named = {first.id, *first.indistinguishable_from}
    assert found.verdict != 'unknown' and not others
    assert named == ({*truth['effects']} if alone else {
        'swash_compliance', 'compressibility_flow'})
    if not alone:
        assert 'pump_displacement' in found.next_test.what


@pytest.mark.slow
def test_an_offset_and_a_leak_are_no_leak_from_one_line(tmp_path):
    rig, logs, _ = campaign(tmp_path, '--circuit', 'closed', '--effect',
                            'pump_command_offset=1,cross_port_leakage=1', '--seed', '32024')
    found = _diagnosed(rig, logs)
    assert {'pump_command_offset', 'cross_port_leakage'} <= {entry.id for entry in found.effects}
    assert found.verdict != 'unknown'
