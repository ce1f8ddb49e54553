# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A small part of the benchmark of the diagnosis, and its arithmetic."""
from test.truth import make_campaign

from bench.campaigns import as_runs, campaign, SEEDS, Task, tasks
from bench.diagnosis import judge, told
from bench.score import matched, named, report, wilson
from hst_drive.diagnose.decide import diagnose
from hst_drive.measure.oscillation import shaking
import pytest

pytestmark = pytest.mark.needs_numba
SEED = SEEDS['dev'] + 90_000


def row(kind: str, number: int, **effects: float) -> dict:
    """Diagnose one campaign on a unit of its own."""
    options = {'on_datasheet': False, 'rate_hz': 100.0}
    return judge(Task(kind, SEED + number, effects, options))


@pytest.fixture(scope='module')
def rows() -> list[dict]:
    """Return what came of six campaigns."""
    return [row('none', 1), row('single', 2, motor_leakage=1.0),
            row('single', 3, line_loss=0.8), row('single', 4, pump_lag=1.0),
            row('pair', 5, entrained_air=1.0, torque_sensor_scale=1.0),
            row('outside', 6, pprv_stiction=1.0)]


def test_nothing_hidden_nothing_named(rows):
    assert rows[0]['verdict'] == 'none' and rows[0]['found'] == []


@pytest.mark.parametrize('number', [1, 2, 3])
def test_a_clear_effect_is_named(rows, number):
    hidden, = rows[number]['effects']
    seen = rows[number]['seen'][hidden]
    assert seen['moves'] > 3 and 0.99 * seen['moves'] >= seen['beyond'] > 1
    assert rows[number]['found'][:1] == [hidden]


def test_a_pair_is_named(rows):
    assert set(rows[4]['effects']) <= named(rows[4])


@pytest.mark.parametrize(('form', 'standing'), [
    ('flow_dependent', {'back_pressure'}), ('constant', {'back_pressure', 'bearing_friction'})])
def test_a_return_pressure_is_told_by_its_flow_and_else_left_open(form, standing):
    made = make_campaign(SEED + 9, {'back_pressure': {'size': 0.8, 'form': form}})
    found = diagnose(*as_runs(made)).effects
    assert len(found) == 1
    assert standing == {found[0].id, *found[0].indistinguishable_from} & {
        'back_pressure', 'bearing_friction'}


def test_a_model_that_stalls_where_the_machine_does_not_is_calibrated_all_the_same():
    """Two seconds near standstill once kept the load from being fitted: stribeck_friction."""
    channels = ('pump_command', 'pprv_command', 'speed_setpoint', 'oil_temperature',
                'motor_inlet_flow', 'motor_speed', 'load_torque')
    made = make_campaign(1702003, rig_seed=1702003, channels=channels)
    assert diagnose(*as_runs(made)).verdict == 'none'


def test_what_shows_in_a_few_quick_steps_only_is_no_event():
    """A rate limit, seen in 4 of 89 blocks; without them a wrong unit fits well."""
    task = next(task for task in tasks('dev') if task.seed == 11031)
    assert task.effects.keys() == {'pump_rate_limit'}
    assert [entry.id for entry in diagnose(*as_runs(campaign(task))).effects] == [
        'pump_rate_limit']


def test_stick_slip_is_named_though_its_phase_is_lost():
    made = make_campaign(SEED + 7, {'stribeck_friction': {'size': 1.5, 'form': 'gauss'}})
    rig, runs, held = as_runs(made)
    assert max(shaking(run).mean() for run in runs) > 0.1
    found = diagnose(rig, runs, held)
    assert (found.verdict, [entry.id for entry in found.effects]) == (
        'missing_effect', ['stribeck_friction'])


def test_what_is_in_no_catalogue_is_unknown(rows):
    assert (rows[5]['verdict'], rows[5]['place']) == ('unknown', 'load')


def test_the_table_counts_them(rows):
    text = report(rows)
    assert 'single: first name right                    100.0 % (43.9 to 100.0)  3 ' in text
    assert 'none: false alarm                           0.0 % (0.0 to 79.3)' in text
    assert all(told(entry).startswith('ok') for entry in rows)


@pytest.mark.parametrize('found, rivals, right', [
    (['bearing_friction', 'pump_lag'], [['back_pressure'], []], True),
    (['pump_lag', 'back_pressure'], [[], []], True),
    (['bearing_friction'], [['back_pressure', 'pump_lag']], False),
    (['pump_lag', 'bearing_friction'], [['back_pressure'], []], False)])
def test_a_look_alike_counts_in_the_place_of_one_effect(found, rivals, right):
    hidden = {'back_pressure': 1.0, 'pump_lag': 1.0}
    assert matched({'found': found, 'rivals': rivals, 'effects': hidden}) is right


def test_interval_of_a_share():
    """Example of E. B. Wilson's interval: 8 of 10 (R, binom::binom.confint)."""
    assert wilson(8, 10) == '80.0 % (49.0 to 94.3)'


def test_development_and_score_share_no_seed():
    dev, score = ({task.seed for task in tasks(part)} for part in ('dev', 'score'))
    assert len(dev) == len(score) >= 200 and not dev & score
    assert tasks('dev') == tasks('dev')
