# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The advised test: within the rig's limits, and worth what it says."""
from dataclasses import replace
import json
from test.diagnose.ambiguous import advised_log, first_log, named

from hst_drive.cli import main
from hst_drive.design import designer, rivals
from hst_drive.design.design import CLEAR, Design, design
from hst_drive.design.designer import Designer, Verified, worth
from hst_drive.design.families import FAMILIES
from hst_drive.design.rehearse import rehearse
from hst_drive.design.rivals import by_name, matched, told_apart
from hst_drive.design.separation import Difference, driver, Pair
from hst_drive.design.trials import (
    limits, plain_drilling, scenario, Segment, SPIN_UP, Trial)
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.next_test import of_diagnosis
from hst_drive.errors import InputError
from hst_drive.identify.model import Model
from hst_drive.load import load_scenario
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.load.scenario import parse_scenario
from hst_drive.report.design import sentence
from hst_drive.rig import default_rig, default_rig_file
import numpy as np
import pytest

RIG = default_rig()
CHANNELS = ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque')


@pytest.fixture
def quick(monkeypatch):
    """Search among the plain families only."""
    monkeypatch.setattr(designer, '_MIXED', 0)
    monkeypatch.setattr(designer, '_ROUNDS', 0)


@pytest.mark.needs_numba
@pytest.mark.parametrize('closed_loop', [False, True])
@pytest.mark.parametrize('family', list(FAMILIES))
def test_a_trial_stays_within_the_limits(family, closed_loop):
    """Commands, speed and pressure; whatever the seed."""
    bounds = limits(RIG)
    for seed in range(2):
        trial = Trial((Segment(family, seed, 27.0),), warming=bool(seed))
        play = parse_scenario(scenario(trial, RIG, closed_loop), LoadingUnit.of(RIG.loading))
        assert play.duration == pytest.approx(30.0)
        run = rehearse(driver(RIG, Model()), play, seed)
        low, high = RIG.controller.output_limits
        assert low <= run['pump_command'].min() and run['pump_command'].max() <= high
        assert run['pprv_command'].max() <= bounds.heavy + 1e-3
        assert np.percentile(run['motor_speed'], 99) < 1.2 * bounds.fast
        pressure = run['pump_outlet_pressure'][run.time > SPIN_UP]
        assert pressure.max() < RIG.relief_valve.set_pressure
        if family not in ('unloaded', 'standstill'):
            assert pressure.min() > 3e5     # the line stays filled


def test_the_same_seed_gives_the_same_trial():
    """A test can be repeated."""
    trial = Trial((Segment('load_steps', 7, 20.0), Segment('reversals', 8, 20.0)))
    assert scenario(trial, RIG, False) == scenario(trial, RIG, False)


@pytest.mark.needs_numba
def test_a_plain_log_separates_less_than_another_test():
    """Drags look alike at the one speed of drilling, not when the speed varies."""
    models = matched(RIG, by_name(('viscous_drag', 'hydrodynamic_drag'), CHANNELS))
    work = Designer(RIG, models, CHANNELS)
    best = work.rate(work.pure(40.0))[0]
    plain = work.rate([plain_drilling(40.0)])[0]
    assert best.worth > 1.2 * plain.worth


@pytest.mark.needs_numba
def test_the_advised_test_ends_an_ambiguity(quick):
    """The independent truth is named once its advised test is recorded as well."""
    truth, seed = 'hydrodynamic_drag', 505
    first = first_log(truth, seed)
    asked = by_name(('hydrodynamic_drag', 'viscous_drag', 'line_loss'), CHANNELS)
    result = design(RIG, matched(RIG, asked), CHANNELS)
    assert result.advice != 'neither' and result.significance >= CLEAR
    assert result.trial.duration <= 120.0
    # Where a sensor alone is advised any test with it will do.
    plain = [scenario(plain_drilling(60.0), RIG, False)] if result.advice == 'sensor' else []
    for content in (result.content, *plain):
        second = advised_log(truth, seed, content, RIG, result.sensors)
        after = diagnose(RIG, [first, second])
        assert (after.verdict, named(after)) == ('missing_effect', (truth,))


@pytest.mark.needs_numba
def test_a_sensor_is_advised_where_no_test_helps(quick):
    """Without a flow meter nobody can tell which machine leaks."""
    channels = ('pump_outlet_pressure', 'motor_speed', 'load_torque')
    models = [Model({'pump_leakage': {'conductance': 2e-12}}),
              Model({'motor_leakage': {'conductance': 2e-12}})]
    result = design(RIG, models, channels)
    assert result.advice in ('sensor', 'both')
    assert set(result.sensors) & {'motor_inlet_flow', 'case_drain_flow'}
    assert result.significance > result.without_sensor


@pytest.mark.needs_numba
def test_a_line_that_runs_empty_makes_a_test_useless():
    """Without load the pressure falls to the tank's for a part of the time."""
    models = matched(RIG, by_name(('viscous_drag', 'hydrodynamic_drag'), CHANNELS))
    work = Designer(RIG, models, CHANNELS)
    steps, unloaded = (Trial((Segment(family, 1, 37.0),)) for family in ('load_steps', 'unloaded'))
    assert work.rehearsal(steps).empty == 0.0
    assert work.rehearsal(unloaded).empty > 0.1
    assert {entry.trial: entry.worth for entry in work.rate([steps, unloaded])}[unloaded] \
        < 0.5 * work.rate([steps])[0].worth


@pytest.mark.needs_numba
def test_what_does_not_stand_in_is_no_twin():
    """A leak cannot do what a drag does; another drag can."""
    models = [Model({'viscous_drag': {'coefficient': 0.8}})]
    place = rivals._Place(RIG, models[0], CHANNELS)
    assert place.taken(('motor_leakage',)) is None
    assert place.taken(('hydrodynamic_drag',)).effects['hydrodynamic_drag']['coefficient'] > 0.02
    found = [tuple(model.effects) for model in rivals.widened(RIG, models, CHANNELS)]
    assert found[0] == ('viscous_drag',) and ('motor_leakage',) not in found


def test_the_best_explanation_weighs_as_much_as_all_others():
    """In how many cases the truth will come out, and what more than enough is worth."""
    trial = Trial(())
    assert Verified(trial, '', (9.0, 0.0, 9.0)).clear == pytest.approx(0.75)
    assert Verified(trial, '', (0.0, 9.0, 9.0)).clear == pytest.approx(0.5)
    assert Verified(trial, '', (9.0,)).clear == 1.0
    assert worth((1.0, 2.0, 4.0)) == pytest.approx(2.0)
    assert worth((50.0, 50.0)) == worth((60.0, 90.0))


def test_the_advice_names_gauge_and_resolution():
    """What stays unclear, what measures it directly, and what an added sensor must resolve."""
    names = (('bearing_friction',), ('back_pressure',), ('pressure_sensor_bias',))
    trial = Trial((Segment('load_steps', 0, 57.0),))
    said = sentence(Design(names, 'neither', trial, {}, 0.4, 0.4, unclear=names[:2]))
    assert 'No test' in said and 'gauge in the return line' in said
    pairs = tuple(Pair(0, rival, 5.0, {'motor_inlet_pressure': Difference(rms, floors, rms)})
                  for rival, rms, floors in ((1, 2e3, 0.1), (2, 4e5, 20.0)))
    said = sentence(Design(names, 'both', trial, {}, 4.0, 0.4, ('motor_inlet_pressure',),
                           pairs=pairs))
    assert 'motor_inlet_pressure (the rivals differ there by 4 bar)' in said
    assert 'return line' not in said


def _diagnosis(**changes):
    value = {'value': 0.8, 'low': 0.7, 'high': 0.9, 'unit': 'N.m.s'}
    return {'schema': 'hst_drive/diagnosis/1', 'verdict': 'ambiguous',
            'errors': {'before': dict.fromkeys(CHANNELS, 2.0)},
            'calibration': [{'quantity': 'motor.leakage', 'factor': 1.1}],
            'effects': [{'id': 'viscous_drag', 'parameters': {'coefficient': value},
                         'indistinguishable_from': ['line_loss']}], **changes}


def test_rivals_come_from_the_diagnosis():
    """Names, sizes, channels and the unit's calibration."""
    left = of_diagnosis(_diagnosis(), 'd.json')
    assert left.names == (('viscous_drag',), ('line_loss',))
    assert left.channels == CHANNELS
    assert left.models[0].effects == {'viscous_drag': {'coefficient': 0.8}}
    assert left.models[0].factors['motor.leakage'] == pytest.approx(np.log(1.1))
    assert left.models[1] is None
    told = of_diagnosis(_diagnosis(next_test={'models': [
        {'viscous_drag': {'coefficient': 0.8}},
        {'line_loss': {'laminar': 1e8, 'turbulent': 0.0}}]}), 'd.json')
    assert told.models[1].effects['line_loss']['laminar'] == 1e8
    assert told_apart([Model({'a': {}, 'b': {}}), Model({'a': {}, 'c': {}})]) == ('b', 'c')


def test_nothing_ambiguous(tmp_path, capsys):
    """Says so, and is no error."""
    effects = _diagnosis()['effects']
    effects[0]['indistinguishable_from'] = []
    path = tmp_path / 'd.json'
    path.write_text(json.dumps(_diagnosis(effects=effects, verdict='missing_effect')))
    assert main(['design', str(path), '-o', str(tmp_path / 's.yaml')]) == 0
    assert 'nothing to separate' in capsys.readouterr().out
    assert not (tmp_path / 's.yaml').exists()


@pytest.mark.parametrize('arguments, words', [
    ([], 'expected at least one of the two'),
    (['--effects', 'bearing_frictoin,back_pressure'], "did you mean 'bearing_friction'"),
    (['--effects', 'back_pressure'], 'at least two'),
    (['--effects', 'back_pressure,line_loss', '--duration', '300'], '20 to 120'),
    (['no_such.json'], 'cannot be read'),
    (['no_such.json', '-o', 'no/such/test.yaml'], 'no/such/test.yaml: cannot be written'),
])
def test_wrong_input_is_one_line(arguments, words, capsys):
    """Exit code 2 and what to do."""
    assert main(['design', *arguments]) == 2
    message = capsys.readouterr().err.strip()
    assert words in message.splitlines()[-1]


def test_a_file_that_exists_is_kept_without_force(tmp_path, capsys):
    """It refuses before the work; with --force it goes on to what else is wrong."""
    path = tmp_path / 's.yaml'
    path.write_text('mine')
    arguments = ['design', 'no_such.json', '-o', str(path)]
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert str(path) in said and 'exists already' in said and '--force' in said
    assert main([*arguments, '--force']) == 2
    assert 'no_such.json: cannot be read' in capsys.readouterr().err
    assert path.read_text() == 'mine'


@pytest.mark.parametrize('content, words', [
    ({'schema': 'x'}, "expected 'hst_drive/diagnosis/1'"), ([], 'schema'),
    (_diagnosis(effects=[{'id': 'viscous_drag'}]), 'write the diagnosis again'),
    (_diagnosis(effects=[{'id': 'magic', 'parameters': {}}]), "'magic' is not in the catalogue"),
])
def test_what_is_no_diagnosis_is_refused(content, words):
    """Names the file."""
    with pytest.raises(InputError, match='^d.json: .*') as problem:
        of_diagnosis(content, 'd.json')
    assert words in str(problem.value)


def test_a_rig_without_a_controller_is_refused():
    """There is nothing to play a test with."""
    with pytest.raises(InputError, match='controller'):
        limits(replace(RIG, controller=None))
    with pytest.raises(InputError, match='describes a part of a drive'):
        limits(replace(RIG, pump=None))


@pytest.mark.needs_numba
def test_the_verb_writes_a_scenario_that_plays(quick, tmp_path, capsys):
    """File, text and JSON."""
    path, data = tmp_path / 's.yaml', tmp_path / 'd.json'
    rig = str(default_rig_file())
    assert main(['design', '--effects', 'viscous_drag,line_loss', '-o', str(path), '--json',
                 str(data), '--duration', '50', '--closed-loop', '--rig', rig]) == 0
    said = capsys.readouterr().out
    assert f"'hst-drive run {path} --rig {rig}" in said
    result = json.loads(data.read_text())
    assert result['schema'] == 'hst_drive/design/2' and result['sentence'] in said
    play = load_scenario(path, RIG)
    assert play.mode == 'closed_loop' and play.duration <= 50.0
