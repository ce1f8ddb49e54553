# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Logs of other circuits: balance by balance, on an independent machine with known leaks."""
from dataclasses import replace
import json

from hst_drive.bag import read_log
from hst_drive.diagnose.decide import diagnose
from hst_drive.errors import InputError
from hst_drive.identify.campaign import ELSEWHERE
from hst_drive.identify.part import campaign_of
from hst_drive.measure.circuit import replay_of
from hst_drive.measure.compare import compare, model_of
from hst_drive.rig import load_rig
import numpy as np
import pytest
from scipy.signal import lsim

make = pytest.importorskip('test.truth.closed.make')


def campaign(folder, *options):
    """Return rig, logs and truth of one campaign of the independent generator."""
    make.main(['--count', '1', '-o', str(folder), *options])
    place = folder / '0000'
    logs = {path.stem: read_log(path) for path in sorted(place.glob('*.csv'))}
    return load_rig(place / 'rig.yaml'), logs, json.loads((place / 'truth.json').read_text())


@pytest.fixture(scope='module')
def healthy(tmp_path_factory):
    """Return a healthy closed circuit, off its datasheet within tolerances."""
    return campaign(tmp_path_factory.mktemp('healthy'), '--circuit', 'closed', '--kind', 'none',
                    '--seed', '100')


def test_a_healthy_closed_circuit_is_near_its_model(healthy):
    """A machine with other equations, servo and states: torque and drain near the floor."""
    rig, logs, truth = healthy
    assert not truth['effects']
    result = compare(model_of(rig, [logs['reverse']]), [logs['reverse']])
    assert {'motor_speed', 'line_a_pressure', 'line_b_pressure'} <= set(result.signals)
    for name in ('motor_torque', 'case_drain_flow'):
        assert result.signals[name].noise_ratio < 3.0, name


@pytest.mark.parametrize('lag', [0.03, 0.06])
def test_a_filter_of_the_speed_is_undone_where_the_drive_is_fast(tmp_path, lag):
    """
    A torque that rings at some hertz is found again behind a first-order filter.

    The filter is exact for what is linear between rows. With a rate of the speed that was smoothed
    once more than what it is compared with, the best lag came out too long.
    """
    rig, logs, _ = campaign(tmp_path, '--circuit', 'closed', '--kind', 'none', '--seed', '32053')
    run = logs['reverse']
    _, late, _ = lsim((-1.0 / lag, 1.0 / lag, 1.0, 0.0), run['motor_speed'],
                      run.sample_time * np.arange(len(run)), X0=run['motor_speed'][0])
    filtered = replace(run, channels={**run.channels, 'motor_speed': late})
    model = model_of(rig, [run])
    replay = replay_of(filtered, model)
    rest = [float(np.nanstd(replay.predict(model.with_effect('speed_sensor_lag', {
        'time_constant': share * lag, 'series': 0.0}))['motor_torque']
        - replay.run['motor_torque'])) for share in (0.7, 0.85, 1.0, 1.15, 1.3)]
    assert np.argmin(rest) == 2


def test_channels_that_close_nothing_are_told(healthy):
    """One line says what each balance lacks."""
    rig, logs, _ = healthy
    run = logs['drilling']
    poor = type(run)('poor', run.time, {'motor_speed': run['motor_speed']}, 'poor.csv')
    with pytest.raises(InputError, match="poor.csv: its channels .* close no balance of 'circuit"):
        replay_of(poor, model_of(rig, [run]))


def test_what_a_circuit_has_not_is_no_gap_of_its_logs(healthy):
    rig, logs, _ = healthy
    searched = campaign_of(rig, [logs['reverse']])
    assert searched.out_of_reach('valve_lag') == searched.out_of_reach('prv_cracking') == ELSEWHERE
    assert searched.out_of_reach('motor_leakage') == ''


def test_without_a_torque_sensor_the_flows_are_judged(healthy):
    """A load that is not measured leaves the balances of flow."""
    rig, logs, _ = healthy
    run = logs['reverse']
    kept = {name: values for name, values in run.channels.items() if name != 'motor_torque'}
    replay = replay_of(type(run)('bare', run.time, kept, 'bare.csv'), model_of(rig, [run]))
    assert 'motor_torque' not in replay.signals and 'motor_speed' in replay.signals
    both = replay.predict(model_of(rig, [run]))['motor_speed']
    forth, back = run['motor_speed'] > 5.0, run['motor_speed'] < -5.0
    for way in (forth, back):
        assert np.nanmedian(np.abs(both[way] / run['motor_speed'][way] - 1.0)) < 0.02


def test_the_shuttle_of_a_flushing_valve_may_stand_in_the_middle(healthy):
    """Between equal lines it lets nothing through: all of its oil goes over the charge relief."""
    rig, logs, _ = healthy
    run, model = logs['reverse'], model_of(rig, [logs['reverse']])
    equal = np.abs(run['line_a_pressure'] - run['line_b_pressure']) < 3e5
    assert np.mean(equal) > 0.1
    raised = run['charge_pressure'] + equal * rig.charge.relief_override * rig.charge.flushing
    shut = type(run)('shut', run.time, {**run.channels, 'charge_pressure': raised}, 'shut.csv')
    left = [compare(model, [log]).signals['charge_pressure'].noise_ratio for log in (run, shut)]
    assert left[1] == pytest.approx(left[0], rel=0.01)


@pytest.mark.parametrize('name, every', [('oil_temperature', 200), ('motor_torque', 5),
                                         ('pump_torque', 5), ('case_drain_flow', 5)])
def test_a_slow_sensor_takes_no_rows_of_the_others_away(healthy, name, every):
    """A logger leaves the cells empty where a channel has no sample; lines join the others."""
    rig, logs, _ = healthy
    run = logs['reverse']
    seldom = np.where(np.arange(len(run)) % every, np.nan, run[name])
    slow = type(run)('slow', run.time, {**run.channels, name: seldom}, 'slow.csv')
    whole, found = (compare(model_of(rig, [log]), [log]).signals for log in (run, slow))
    assert found.keys() == whole.keys()
    for signal in whole.keys() - {name}:
        assert found[signal].noise_ratio == pytest.approx(whole[signal].noise_ratio, rel=0.05)


def test_a_hole_in_a_reading_is_no_sample_of_a_slower_sensor(healthy):
    """What follows the pressure is not judged where nobody read it for a second."""
    rig, logs, _ = healthy
    run = logs['reverse']
    hole = (run.time > 20.0) & (run.time < 21.0)
    gap = np.where(hole, np.nan, run['line_a_pressure'])
    log = type(run)('gap', run.time, {**run.channels, 'line_a_pressure': gap}, 'gap.csv')
    replay = replay_of(log, model_of(rig, [run]))
    whole = replay_of(run, model_of(rig, [run]))
    for name in ('motor_torque', 'motor_speed'):
        assert not np.isfinite(replay.run[name][hole]).any()
        far = np.abs(run.time - 20.5) > 3.0
        assert np.mean(np.isfinite(replay.run[name][far])) == pytest.approx(
            np.mean(np.isfinite(whole.run[name][far])), abs=0.02)


@pytest.mark.parametrize('name', ['line_a_pressure', 'line_b_pressure'])
def test_a_gauge_that_is_off_does_not_take_its_own_balance_away(healthy, name):
    """The low line then seems to stand above the charge pressure that fills it."""
    rig, logs, _ = healthy
    run, model = logs['reverse'], model_of(rig, [logs['reverse']])
    off = type(run)('off', run.time, {**run.channels, name: run[name] + 10e5}, 'off.csv')
    right, wrong = (compare(model, [log]).signals[name].noise_ratio for log in (run, off))
    assert wrong > 5.0 * right


@pytest.mark.slow
@pytest.mark.parametrize('effect', ['motor_leakage', 'charge_pressure_loss', 'speed_sensor_lag'])
def test_a_closed_circuit_names_what_is_missing(tmp_path, effect):
    """From forward and backward drilling of an independent machine."""
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--kind', 'single', '--effect',
                                effect, '--seed', '300')
    held_out = logs.pop('holdout')
    found = diagnose(rig, list(logs.values()), [held_out])
    assert [entry.id for entry in found.effects][:1] == [effect], truth


@pytest.mark.slow
def test_a_pump_that_leaks_as_through_an_orifice_is_a_pump_that_leaks(tmp_path):
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--seed', '9278')
    assert truth['forms'] == {'pump_leakage': 'orifice'}
    held_out = logs.pop('holdout')
    found = diagnose(rig, list(logs.values()), [held_out])
    named, = found.effects
    assert 'pump_leakage' in {named.id, *named.indistinguishable_from}
    assert 'pump_orifice_leakage' not in {entry.id for entry in found.ranking}


def test_a_play_shows_where_the_torque_changes_its_sign(tmp_path):
    """The shaft stands while oil turns the hydromotor; these moments are judged, too."""
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--effect',
                                'gear_backlash=0.71', '--seed', '7002')
    run = logs['sweep']
    without = model_of(rig, [run])
    replay = replay_of(run, without)
    play = without.changed({'gear_backlash': {
        'angle': truth['si_parameters']['play'], 'band': 100.0}}, {})
    late = run.time > 1.0
    rms = [np.sqrt(np.nanmean((replay.predict(model)['motor_speed']
                               - replay.run['motor_speed'])[late]**2)) for model in (
        without, play)]
    assert rms[1] < 0.6 * rms[0]


@pytest.fixture(scope='module')
def aerated(tmp_path_factory):
    """Return a closed circuit with air in its oil, read at 100 Hz with quick commands."""
    return campaign(tmp_path_factory.mktemp('aerated'), '--circuit', 'closed', '--effect',
                    'entrained_air=1.327', '--seed', '5031')


def test_where_the_equations_jump_nothing_is_judged(aerated):
    """A charge pump that falls short for a moment, by a noisy speed, empties no line."""
    rig, logs, _ = aerated
    run = logs['sweep']
    replay = replay_of(run, model_of(rig, [run]))
    predicted = replay.predict(model_of(rig, [run]))
    for name in ('charge_pressure', 'line_a_pressure', 'line_b_pressure'):
        worst = np.nanmax(np.abs(predicted[name] - replay.run[name]))
        assert worst < 4e5, name


@pytest.mark.slow
def test_air_shows_where_a_line_comes_under_pressure(aerated):
    """At low pressure alone is the oil soft: just after the lines have changed their parts."""
    rig, logs, truth = aerated
    runs = dict(logs)
    found = diagnose(rig, [run for name, run in runs.items() if name != 'holdout'],
                     [runs['holdout']])
    air, = found.effects
    assert air.id == 'entrained_air'
    assert air.parameters['fraction'].value == pytest.approx(
        truth['si_parameters']['air'], rel=0.2)


@pytest.mark.slow
def test_a_worn_edge_of_a_valve_is_named_alone(tmp_path):
    """Its overlap is wider on one side, and full opening is where it was: both are usual."""
    rig, logs, truth = campaign(tmp_path, '--circuit', 'valve', '--effect',
                                'valve_dead_band=0.815', '--seed', '5007')
    assert truth['forms'] == {'valve_dead_band': 'one_sided'}
    held_out = logs.pop('holdout')
    found = diagnose(rig, list(logs.values()), [held_out])
    assert found.verdict == 'missing_effect'
    assert {entry.id for entry in found.effects} <= {'valve_dead_band', 'leakage_temperature'}
    size = found.effects[0].parameters['width']
    # What the catalogue has is the mean of both ways, the generator says it of one.
    assert size.value == pytest.approx(0.8 * truth['si_parameters']['u_dead'], rel=0.12)


def test_a_line_that_empties_holds_its_pressure_over_the_returning_edge(tmp_path):
    """Just after a valve has changed its way a line gives oil back, not the hydromotor alone."""
    rig, logs, _ = campaign(tmp_path, '--circuit', 'valve', '--kind', 'none', '--seed', '3',
                            '--on-datasheet')
    result = compare(model_of(rig, [logs['reverse']]), [logs['reverse']])
    for name in ('line_a_pressure', 'line_b_pressure'):
        assert result.signals[name].noise_ratio < 1.0, name
