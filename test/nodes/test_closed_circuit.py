# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A closed circuit in the nodes: a drive that turns either way."""
import json

from hst_drive.bag import read_log
from hst_drive.errors import InputError
from hst_drive.load import load_scenario
from hst_drive.nodes import wiring
from hst_drive.nodes.both_ways import dead_band_of
from hst_drive.nodes.plan import make_plan, Options
from hst_drive.resources import share
from hst_drive.rig import load_rig
import numpy as np
import pytest
import yaml

from .processes import run
from .test_estimator import read

RIG = share('config', 'rig', 'closed_rig.yaml')
STROKE, PUMP = 71e-6 / (2.0 * np.pi), 1800 * np.pi / 30.0       # of the rig file
SWEPT = 3.0 * 2 * 560e-6 / (2.0 * np.pi)
LEAK = 2 * 0.008 / 6e4 / 1e5        # m^3/(s.Pa)
ARGUMENTS = ('run', 'reverse', '--rig', str(RIG))
PATIENCE = 400.0    # s: without numba


def changed(folder, **sections):
    """Write the rig with other sections; return its path."""
    content = yaml.safe_load(RIG.read_text(encoding='utf-8'))
    for name, values in sections.items():
        content[name] = {**content[name], **values}
    path = folder / 'changed.yaml'
    path.write_text(yaml.safe_dump(content), encoding='utf-8')
    return path


def test_what_runs_and_what_it_publishes(tmp_path):
    plan = make_plan(Options('reverse', str(tmp_path / 'bag'), rig=str(RIG)))
    assert list(plan.parameters) == list(wiring.NODES)
    law = plan.parameters['controller']
    assert (law['u_clamp_min'], law['u_clamp_max'], law['dead_band']) == (-10.0, 10.0, 1.0)
    assert {entry['circuit'] for entry in plan.parameters.values()} == {'closed'}
    names = wiring.recorded(plan.parameters, circuit='closed')
    assert {'line_a_pressure', 'line_b_pressure', 'charge_pressure', 'motor_torque'} <= set(names)
    assert not {'pprv_command', 'pump_outlet_pressure', 'load_torque_command'} & set(names)
    # What the estimator tells of them, and nothing for which there is no sensor.
    assert {name for name in names if name.endswith('_residual')} == {
        f'{name}_residual' for name in ('pump_flow', 'motor_torque', 'line_a_pressure',
                                        'line_b_pressure', 'charge_pressure')}
    assert {'efficiency', 'losses', 'leakage_resistance', 'verdict', '/diagnostics'} <= set(names)
    # As before on the open circuit.
    assert not any(name.startswith(('line_', 'charge')) for name in wiring.recorded(wiring.NODES))
    assert {'motor_flow_residual', 'load_torque_residual'} <= set(wiring.recorded(wiring.NODES))
    with pytest.raises(InputError, match='pump_outlet_pressure'):
        wiring.readings(['pump_outlet_pressure'], 'closed')
    with pytest.raises(InputError, match='line_a_pressure'):
        wiring.readings(['line_a_pressure'])


def test_an_open_circuit_does_not_reverse():
    with pytest.raises(InputError, match=r'reverse.yaml: speed_setpoint: is -\S+ rpm at \S+ s.*'
                       'turns one way.*--rig'):
        load_scenario('reverse')


@pytest.mark.parametrize('scenario, options, words', [
    ('commissioning', {}, 'pprv_command.*loading unit'),
    ('reverse', {'topics': ('pump_outlet_pressure',)}, 'pump_outlet_pressure'),
    ('reverse', {'effects': ('line_inertia.x=1',)}, 'line_inertia')])
def test_what_a_closed_circuit_has_not_is_told_before_a_node_starts(
        tmp_path, scenario, options, words):
    with pytest.raises(InputError, match=words):
        make_plan(Options(scenario, str(tmp_path / 'bag'), rig=str(RIG), **options))


@pytest.mark.parametrize('command, displacement, band', [
    ([-10, -1, 1, 10], [-71, 0, 0, 71], 1.0), ([-10, 10], [-71, 71], 0.0),
    ([-10, -2, 1, 10], [-71, 0, 0, 71], 1.0), ([-5, -0.5, 0.7, 5], [-71, 0, 0, 71], 0.5)])
def test_the_dead_band_is_that_of_the_pumps_table(tmp_path, command, displacement, band):
    rig = load_rig(changed(tmp_path, pump={'displacement_vs_command': {
        'command_V': command, 'displacement_cc_rev': displacement}}))
    assert dead_band_of(rig) == pytest.approx(band, abs=0.02)


def test_zero_stroke_has_to_be_at_zero_volt(tmp_path):
    rig = load_rig(changed(tmp_path, pump={'displacement_vs_command': {
        'command_V': [0, 4.5, 5.5, 10], 'displacement_cc_rev': [-71, 0, 0, 71]}}))
    with pytest.raises(InputError, match='pump.displacement_vs_command: is not 0 at 0 V'):
        dead_band_of(rig)


@pytest.fixture(scope='module')
def reversed_run(tmp_path_factory):
    pytest.importorskip('rclpy')
    bag = tmp_path_factory.mktemp('closed') / 'bag'
    code, out, err = run(*ARGUMENTS, '-o', str(bag), patience=PATIENCE)
    assert code == 0, err
    return read_log(bag)


def at(record, first, last):
    """Return channel means between two times, s."""
    time = record.time - record.time[0]
    rows = (time > first) & (time < last)
    return {name: float(np.mean(record[name][rows])) for name in record.channels}


def test_it_drills_stops_reverses_and_drills_on(reversed_run):
    rpm = np.pi / 30.0
    for first, last, speed in ((13.0, 18.0, 25.0), (36.0, 40.0, -12.0), (44.0, 48.0, -12.0),
                               (70.0, 79.5, 25.0)):
        assert at(reversed_run, first, last)['motor_speed'] == pytest.approx(speed * rpm, rel=0.12)
    for first, last in ((28.0, 30.0), (58.0, 60.0)):
        assert abs(at(reversed_run, first, last)['motor_speed']) < 0.2
        assert abs(at(reversed_run, first, last)['pump_command']) < 1.6


def test_flow_and_torque_balance_either_way(reversed_run):
    """The pump's stroke carries the speed, the line under pressure the torque: by hand."""
    for first, last, way in ((13.0, 18.0, 1.0), (36.0, 40.0, -1.0)):
        found = at(reversed_run, first, last)
        stroke = STROKE * (abs(found['pump_command']) - 1.0) / 9.0
        # Leakage: 0.012 + 2 * 0.008 L/min per bar of some 50 to 80 bar.
        assert 0.9 < way * found['motor_speed'] / (stroke * PUMP / SWEPT) < 1.03
        difference = found['line_a_pressure'] - found['line_b_pressure']
        assert way * difference > 2e6
        assert 0.75 < found['motor_torque'] / (SWEPT * difference) < 0.97
        low = found['line_b_pressure'] if way > 0.0 else found['line_a_pressure']
        assert low == pytest.approx(25e5, rel=0.05) and found['charge_pressure'] > low


@pytest.mark.needs_numba
def test_the_recording_is_one_that_the_model_describes(reversed_run, tmp_path):
    """What the nodes simulated replays; lines that change sides between two rows are not asked."""
    assert np.array_equal(reversed_run['load_torque'], reversed_run['motor_torque'])
    code, out, err = run('compare', reversed_run.source, '--rig', str(RIG), '--json',
                         str(tmp_path / 'found.json'))
    assert code == 0, err
    signals = json.loads((tmp_path / 'found.json').read_text(encoding='utf-8'))['signals']
    assert {'line_a_pressure', 'line_b_pressure'} <= set(signals)
    for name in ('motor_speed', 'motor_torque', 'charge_pressure'):
        assert signals[name]['noise_ratio'] < 1.5, name


def watched(words):
    """Return time and status of what the watch said."""
    return [(time, status) for time, status in words if status.name.endswith('watch')]


def test_the_estimator_tells_efficiency_and_losses_both_ways(reversed_run):
    """Beside the rig file, by hand: leakage per pressure, friction of each hydromotor, gear."""
    rows, *_ = read(reversed_run.source)
    for first, last in ((8.0, 18.0), (36.0, 40.0), (70.0, 79.0)):
        told = {name: rows[name][(rows[name][:, 0] > first) & (rows[name][:, 0] < last), 1:]
                for name in ('efficiency', 'losses', 'efficiency_uncertainty')}
        times = rows['efficiency'][(rows['efficiency'][:, 0] > first)
                                   & (rows['efficiency'][:, 0] < last), 0]
        assert len(times) > 30
        speed = np.abs(np.interp(times, rows['motor'][:, 0], rows['motor'][:, 1]))
        lines = np.array([np.interp(times, *rows[f'line_{line}_pressure'].T) for line in 'ab'])
        difference, high = np.abs(lines[0] - lines[1]), lines.max(axis=0)
        turned = SWEPT * speed
        friction = 3.0 * 2 * (20.0 + 0.6 * 3.0 * speed)
        made = 0.97 * (0.96 * SWEPT * difference - friction)
        volumetric = turned / (turned + LEAK * high)
        assert np.median(told['efficiency'][:, 0]) == pytest.approx(
            np.median(volumetric), abs=2e-3)
        assert np.median(told['efficiency'][:, 1]) == pytest.approx(
            np.median(made / (SWEPT * difference)), abs=6e-3)
        assert np.median(told['losses'][:, 0]) == pytest.approx(
            100.0 * (1.0 - np.median(volumetric)), abs=0.2)
        assert np.median(told['losses'][:, 2]) == pytest.approx(
            np.median(SWEPT * difference - made), rel=0.05)
        # How well the pump's sheet tells the flow is most of it: 0.6 % of its displacement.
        assert np.all((told['efficiency_uncertainty'][:, 0] > 0.004)
                      & (told['efficiency_uncertainty'][:, 0] < 0.012))
    # Where it creeps (below 0.09 rad/s), or no line carries pressure, there is no figure.
    assert not np.any((rows['efficiency'][:, 0] > 27.6) & (rows['efficiency'][:, 0] < 31.0))


def test_a_sound_drive_that_reverses_is_watched_without_alarm(reversed_run):
    rows, words, verdicts = read(reversed_run.source)
    said = watched(words)
    assert not [status.message for _, status in said if status.level == 1]
    assert sum(status.level == 0 for _, status in said) > 55
    assert verdicts and not any(names for _, names, *_ in verdicts)
    for name in ('pump_flow', 'motor_torque', 'line_b_pressure', 'charge_pressure'):
        assert rows[f'{name}_residual'][:, 3].max() < 0.5
    # Backwards line A is the low one.
    backwards = rows['line_a_pressure_residual'][:, 0]
    assert len(backwards) > 5 and np.all((backwards > 31.0) & (backwards < 58.0))
    values = {value.key for _, status in said for value in status.values}
    assert {'evidence high line', 'evidence shaft', 'evidence charge line'} <= values


@pytest.mark.parametrize('hidden, balance, names, size', [
    (('motor_leakage.conductance=5e-12', '--topic', 'case_drain_flow'), 'case drain',
     ('motor_leakage',), 5e-12),
    (('charge_pressure_loss.drop=3e5',), 'charge line', ('charge_pressure_loss',), None)])
def test_what_comes_while_it_reverses_is_named(tmp_path, hidden, balance, names, size):
    pytest.importorskip('rclpy')
    code, out, err = run(*ARGUMENTS, '-o', str(tmp_path / 'bag'), '--duration', '42',
                         '--effects-from', '20', '--effect', *hidden, patience=PATIENCE)
    assert code == 0, err
    _, words, verdicts = read(tmp_path / 'bag')
    alarms = [(time, status) for time, status in watched(words) if status.level == 1]
    assert alarms and alarms[0][0] > 20.0
    values = {value.key: value.value for value in alarms[-1][1].values}
    assert balance in values['balances'].split(', ')
    _, told, sizes, *_ = verdicts[-1]
    assert set(names) <= set(told)
    if size:
        assert sizes[told.index(names[0])] == pytest.approx(size, rel=0.1)
