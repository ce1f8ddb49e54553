# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Logs of a part of the drive: the right friction, the right leakage, and what cannot be told."""
import json
import math

from hst_drive import cli
from hst_drive.bag import write_csv
from hst_drive.diagnose.decide import diagnose
from hst_drive.errors import InputError
from hst_drive.identify.part import campaign_of
from hst_drive.measure.compare import compare, model_of
from hst_drive.measure.run import Run
from hst_drive.rig import default_rig, parse_rig
import numpy as np
import pytest
import yaml

from ..diagnose import benches

NAMES = {'coulomb': 'bearing_friction', 'viscous': 'viscous_drag',
         'quadratic': 'hydrodynamic_drag', 'stribeck': 'stribeck_friction'}
CONSTANT = {'bearing_friction', 'back_pressure', 'pressure_sensor_bias'}


def found(result):
    """Return all effects that a diagnosis holds possible."""
    return {name for entry in result.effects for name in (entry.id, *entry.indistinguishable_from)}


@pytest.mark.parametrize('table', [False, True], ids=['record', 'table'])
@pytest.mark.parametrize('kind', NAMES)
def test_hydromotor_bench_names_the_friction(kind, table):
    result = diagnose(benches.motor_rig(), [benches.motor_bench(kind, seed=3, table=table)])
    assert not result.probability.calibrated
    if kind == 'coulomb':
        # With one pressure a constant torque deficit may also be one of pressure; a table has no
        # reversal that would tell.
        if not table:
            assert (result.verdict, found(result)) == ('missing_effect', {'bearing_friction'})
            return
        assert 'bearing_friction' in found(result) <= CONSTANT | {'stribeck_friction'}
        assert result.verdict == 'ambiguous' and result.next_test
        return
    assert result.verdict == 'missing_effect' and [e.id for e in result.effects] == [NAMES[kind]]
    assert result.ladder[1].holdout['motor_torque'] > 2.0
    assert result.ladder[-1].holdout['motor_torque'] < 1.25
    assert result.effects[0].error_removed > 0.9
    if kind == 'viscous':
        size = next(iter(result.effects[0].parameters.values()))
        assert size.low < size.value < size.high
        assert size.value == pytest.approx(12 / 15, rel=0.05)


@pytest.mark.parametrize('rate, duration', [(25, 20), (100, 60), (500, 20)])
def test_complete_hydromotor_bench_lacks_nothing(rate, duration):
    run = benches.motor_bench(seed=5, rate=rate, duration=duration,
                              channels=('motor_inlet_flow', 'case_drain_flow'))
    result = diagnose(benches.motor_rig(), [run])
    assert result.verdict == 'none' and not result.effects
    assert set(result.ladder[0].holdout) == {'motor_torque', 'motor_inlet_flow',
                                             'case_drain_flow'}
    assert result.smallest['viscous_drag'] < 0.3
    assert 'pump_leakage' in result.not_observable
    assert {entry.quantity for entry in result.calibration} == {
        'motor.displacement', 'motor.inertia', 'motor.leakage', 'motor.mechanical_efficiency'}


def test_rig_without_tables_is_an_ideal_hydromotor():
    run = benches.motor_bench('viscous', seed=2, efficiency=np.ones_like)
    result = diagnose(benches.motor_rig(tables=False), [run])
    assert [entry.id for entry in result.effects] == ['viscous_drag']


def test_any_torque_and_pressure_channel_will_do():
    run = benches.motor_bench('viscous', seed=4)
    names = {'motor_torque': 'load_torque', 'motor_inlet_pressure': 'pump_outlet_pressure'}
    other = Run(run.name, run.time, {names.get(key, key): values
                                     for key, values in run.channels.items()}, run.source)
    result = diagnose(benches.motor_rig(), [other])
    assert result.effects[0].id == 'viscous_drag'


@pytest.mark.parametrize('kind, name', [('laminar', 'pump_leakage'),
                                        ('orifice', 'pump_orifice_leakage')])
def test_pump_bench_tells_the_leakage_over_a_wide_span_only(kind, name):
    wide = diagnose(benches.pump_rig(), [benches.pump_bench(kind, 5, 200, seed=3)])
    assert wide.verdict == 'missing_effect' and [e.id for e in wide.effects] == [name]
    narrow = diagnose(benches.pump_rig(), [benches.pump_bench(kind, 97, 103, seed=3)])
    assert narrow.verdict == 'ambiguous'
    assert found(narrow) == {'pump_leakage', 'pump_orifice_leakage'}
    assert 'wider span' in narrow.next_test.what


def test_pump_bench_that_lacks_nothing():
    result = diagnose(benches.pump_rig(), [benches.pump_bench('none', seed=4)])
    assert result.verdict == 'none'


@pytest.mark.parametrize('kind', ['none', *NAMES])
def test_mass_on_a_known_torque(kind):
    result = diagnose(benches.mass_rig(), [benches.mass(kind, seed=2)])
    assert [entry.id for entry in result.effects] == ([] if kind == 'none' else [NAMES[kind]])
    assert result.verdict == ('none' if kind == 'none' else 'missing_effect')


def test_holdout_log_judges():
    logs = [benches.motor_bench('viscous', seed=seed) for seed in (1, 2)]
    result = diagnose(benches.motor_rig(), logs[:1], logs[1:])
    assert result.effects[0].id == 'viscous_drag' and len(result.logs) == 2


def test_gaps_are_left_out():
    run = benches.motor_bench('coulomb', seed=3)
    run.channels['motor_torque'][100:160] = np.nan
    run.channels['motor_inlet_pressure'][1000:1010] = np.nan
    assert diagnose(benches.motor_rig(), [run]).effects[0].id == 'bearing_friction'


def test_compare_judges_the_predicted_signals(tmp_path, capsys):
    """The verb takes a log and a rig of a part, and writes the usual JSON."""
    log, rig, out = tmp_path / 'bench.csv', tmp_path / 'motor.yaml', tmp_path / 'out.json'
    write_csv(log, benches.motor_bench('none', seed=1))
    rig.write_text(yaml.safe_dump({'motor': {
        'displacement_cc_rev': 195, 'inertia_total_kg_m2': 0.3675,
        'mechanical_efficiency': {'pressure_bar': [0, 10, 20, 40, 80, 200],
                                  'speed_rpm': [0, 200], 'table': [
                                      [value] * 2 for value in
                                      (0.5, 0.72, 0.82, 0.87, 0.89, 0.9)]}}}))
    assert cli.main(['compare', str(log), '--rig', str(rig), '--json', str(out)]) == 0
    assert 'down to the noise' in capsys.readouterr().out
    signals = json.loads(out.read_text())['signals']
    assert list(signals) == ['motor_torque'] and signals['motor_torque']['noise_ratio'] < 1.2
    assert cli.main(['compare', str(log), '--rig', str(rig), '--closed-loop']) == 2
    assert 'leave --closed-loop out' in capsys.readouterr().err


def test_whole_rig_file_serves_its_parts():
    """A bench log needs no rig file of its own: the drive's has the hydromotor's numbers."""
    run = benches.motor_bench('none', seed=1)
    result = compare(model_of(default_rig(), [run]), [run])
    assert list(result.signals) == ['motor_torque']


@pytest.mark.parametrize('keep, expected', [
    (('motor_speed',), 'lacks'),
    (('motor_inlet_pressure',), 'motor_speed'),
    ((), 'none but time'),
])
def test_log_that_closes_no_balance_says_what_would(keep, expected):
    run = benches.motor_bench()
    part = Run('bench', run.time, {name: run[name] for name in keep}, 'bench.csv')
    with pytest.raises(InputError) as caught:
        diagnose(benches.motor_rig(), [part])
    line = str(caught.value)
    assert line.startswith('bench.csv: its channels (') and expected in line
    assert 'motor_torque or load_torque' in line and '\n' not in line


def test_too_few_operating_points():
    run = benches.pump_bench()
    part = Run('pump', run.time[:8], {key: values[:8] for key, values in run.channels.items()},
               'pump.csv')
    with pytest.raises(InputError, match='8 rows, expected at least 12'):
        diagnose(benches.pump_rig(), [part])


def test_part_of_a_rig_is_still_read_strictly():
    with pytest.raises(InputError, match="unknown key 'motor.inertia'"):
        parse_rig({'motor': {'inertia': 3}}, 'rig.yaml')
    with pytest.raises(InputError, match="key 'relief_valve.set_pressure_bar' is missing"):
        parse_rig({'relief_valve': {'area_m2': 1e-5}}, 'rig.yaml')
    rig = parse_rig({'motor': {'displacement_cc_rev': 100}}, 'rig.yaml')
    assert not rig.whole and rig.motor.leakage(1e7, 5.0) == 0
    assert rig.motor.mechanical_efficiency(1e7, 5.0) == 1


@pytest.mark.parametrize('off, waves', [(0.004, 0.8), (-0.004, 1.2), (0.004, 1.5)])
def test_a_displacement_curve_that_is_off_a_little_is_no_effect(off, waves):
    """No sheet tells a pump's curve to half a percent all along."""
    runs = [benches.drive(off, seed, waves) for seed in (1, 11)]
    assert diagnose(benches.drive_rig(), runs).verdict == 'none'


@pytest.mark.parametrize('rate', [200, 10])
def test_motion_is_no_noise_of_slow_rows(rate):
    """Of oil that turns the shaft the noise of both meters is left, whatever the shaft does."""
    time = np.arange(0.0, 120.0, 1.0 / rate)
    speed = 12.0 + 4.0 * np.sin(2 * math.pi * time / 0.9)
    run = benches.noisy('restless', time, {
        'motor_speed': speed, 'motor_inlet_flow': benches.DISPLACEMENT * speed,
        'motor_inlet_pressure': np.full(len(time), 50e5)}, np.random.default_rng(2))
    floors, = campaign_of(benches.motor_rig(), [run]).floors
    assert floors['motor_inlet_flow'] == pytest.approx(math.hypot(
        benches.NOISE['motor_inlet_flow'],
        benches.DISPLACEMENT * benches.NOISE['motor_speed']), rel=0.25)


def test_a_hydromotor_may_lose_more_than_its_sheet_says_by_so_much_as_the_file_tells():
    """A seventh more of all that coefficients say: no factor on the efficiency does that."""
    content = {'motor': {'displacement_cc_rev': 100, 'mechanical_efficiency': {
        'coulomb_N_m': 4.0, 'viscous_N_m_s_per_rad': 0.05, 'pressure_share': 0.03}},
        'tolerances_1_sigma_relative': {'motor.mechanical_efficiency': 0.005}}
    time, random = np.arange(0.0, 60.0, 0.02), np.random.default_rng(3)
    speed, pressure = 80 + 50 * np.sin(0.31 * time), (110 + 80 * np.sin(0.73 * time)) * 1e5
    ideal = 1e-4 / (2 * np.pi) * pressure
    torque = ideal - 1.15 * (4.0 + 0.05 * speed + 0.03 * ideal)
    noise = random.standard_normal((3, len(time)))
    run = Run('bench', time, {
        'motor_speed': speed + 0.05 * noise[0], 'motor_torque': torque + 0.1 * noise[1],
        'motor_inlet_pressure': pressure + 0.05e5 * noise[2]})
    named = diagnose(parse_rig(content, 'sheet'), [run])
    assert named.effects
    content['tolerances_1_sigma_relative']['motor.torque_loss'] = 0.1
    found = diagnose(parse_rig(content, 'sheet'), [run])
    assert found.verdict == 'none'
    factors = {entry.quantity: entry.factor for entry in found.calibration}
    assert factors['motor.torque_loss'] == pytest.approx(1.15, rel=0.03)
