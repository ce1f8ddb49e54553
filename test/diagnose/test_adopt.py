# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Adoption: from the JSON of a diagnosis to a rig that the drive runs with, and refusals."""
import copy
import json

from hst_drive.diagnose.adopt import adopt
from hst_drive.errors import InputError
from hst_drive.model import Drive
from hst_drive.model.parameters import INDEX
from hst_drive.resources import share
from hst_drive.rig import default_rig, load_rig, parse_rig
from hst_drive.rig.identity import digest
from hst_drive.rig.load import read_yaml
import pytest
import yaml

from ..cli.verbs import calls_of

run, refused = calls_of('adopt')
RIG = share('config', 'rig', 'test_rig.yaml')
FOUND = {'bearing_friction': {'coulomb': (13.0, 11.5, 14.5, 'N.m'),
                              'load_share': (0.02, 0.01, 0.03, '1')},
         'pump_lag': {'time_constant': (0.081, 0.078, 0.084, 's')}}


def diagnosis(rig=RIG):
    """Return a diagnosis of a rig as 'diagnose --json' writes it."""
    return {
        'schema': 'hst_drive/diagnosis/1', 'verdict': 'missing_effect', 'sentence': '...',
        'rig': 'drill drive test rig', 'rig_digest': load_rig(rig).digest, 'logs': ['a.csv'],
        'effects': [{'id': name, 'error_removed': 0.5, 'indistinguishable_from': ['viscous_drag'],
                     'parameters': {key: dict(zip(('value', 'low', 'high', 'unit'), numbers))
                                    for key, numbers in parameters.items()}}
                    for name, parameters in FOUND.items()],
        'holdout': {'before': {'motor_speed': 8.3}, 'after': {'motor_speed': 1.1}},
        'calibration': [{'quantity': 'motor.leakage', 'factor': 1.05, 'sigmas': 0.6,
                         'at_limit': False}],
    }


@pytest.fixture
def written(tmp_path):
    """Return the file of a diagnosis of the shipped rig."""
    path = tmp_path / 'diagnosis.json'
    path.write_text(json.dumps(diagnosis()))
    return path


def test_the_adopted_rig_runs_with_the_effects(written, tmp_path, capsys):
    """File to file: the drive has the effects, the unit's calibration, and nothing else new."""
    target = tmp_path / 'rig.yaml'
    code, out, err = run(capsys, written, '-o', target)
    assert code == 0 and not err
    assert 'bearing_friction: coulomb = 13 N.m, load_share = 0.02\n' in out
    adopted = load_rig(target)
    drive, plain = Drive(adopted), Drive(default_rig())
    assert drive.effects == {'bearing_friction': {'coulomb': 13.0, 'load_share': 0.02},
                             'pump_lag': {'time_constant': 0.081, 'series': 0.0}}
    for name, place in INDEX.items():
        factor = 1.05 if name == 'motor_leakage_scale' else 1.0
        assert drive.parameters[place] == pytest.approx(factor * plain.parameters[place]), name
    past, = adopted.provenance['adopted']
    assert past['diagnosis'] == str(written) and past['logs'] == ['a.csv']
    assert past['intervals_95_percent']['bearing_friction']['coulomb'] == [11.5, 14.5, 'N.m']
    assert past['indistinguishable_from']['pump_lag'] == ['viscous_drag']


@pytest.mark.parametrize('found, expected', [
    ({'motor_speed': 0.004, 'load_torque': 0.001}, {'motor_speed': 0.004, 'load_torque': 0.001}),
    # No sensor reads early: then commands were recorded late, all by the same.
    ({'motor_speed': -0.003, 'load_torque': -0.005}, {'motor_speed': 0.002})])
def test_how_late_sensors_read_is_adopted(found, expected):
    delays = [{'channel': name, 'value': value, 'unit': 's', 'sigmas': 1.0}
              for name, value in found.items()]
    adopted = adopt(read_yaml(RIG), {**diagnosis(), 'sensor_delays': delays}, 'd.json', str(RIG))
    rig = parse_rig(adopted, 'rig.yaml')
    assert rig.delays == pytest.approx(expected)
    assert rig.sensors['motor_speed'].noise_std == default_rig().sensors['motor_speed'].noise_std
    with pytest.raises(InputError, match="d.json: key 'sensor_delays' is no list with 'channel'"):
        adopt(read_yaml(RIG), {**diagnosis(), 'sensor_delays': [3]}, 'd.json', str(RIG))


def test_adopting_twice_is_refused(written, tmp_path, capsys):
    """The second time the effect is there already; the file of the first stays as it is."""
    target = tmp_path / 'rig.yaml'
    run(capsys, written, '-o', target)
    before = target.read_bytes()
    said = refused(capsys, written, '--rig', target, '-o', tmp_path / 'twice.yaml')
    assert "'bearing_friction' is adopted already" in said and str(target) in said
    assert target.read_bytes() == before and not (tmp_path / 'twice.yaml').exists()


def test_what_changed_since_older_logs_needs_a_file_of_the_machine(written, tmp_path, capsys):
    content = json.loads(written.read_text()) | {'since': ['old.csv'], 'rig_digest': 'other'}
    since = tmp_path / 'since.json'
    since.write_text(json.dumps(content))
    said = refused(capsys, since, '-o', tmp_path / 'rig.yaml')
    assert str(since) in said and 'hst-drive commission OLD... -o unit.yaml' in said
    # Or the machine has a file: that must be given.
    since.write_text(json.dumps(content | {'rig': 'unit.yaml'}))
    said = refused(capsys, since, '-o', tmp_path / 'rig.yaml')
    assert "on unit.yaml: give the machine's file with --rig" in said


@pytest.mark.parametrize('change', [
    ('displacement_cc_rev: 195', 'displacement_cc_rev: 196'),
    ('area_m2: 1.6e-05', 'area_m2: 1.7e-05'),
    ('tolerances_1_sigma_relative: {motor.displacement: 0.004',
     'tolerances_1_sigma_relative: {motor.displacement: 0.005')])
def test_another_rig_is_refused(written, tmp_path, capsys, change):
    """A number that differs makes another rig."""
    other = tmp_path / 'other.yaml'
    text = RIG.read_text()
    assert change[0] in text
    other.write_text(text.replace(*change))
    said = refused(capsys, written, '--rig', other, '-o', tmp_path / 'rig.yaml')
    assert str(other) in said and 'is not the rig that was diagnosed' in said
    assert not (tmp_path / 'rig.yaml').exists()


def test_the_same_rig_under_another_name_is_accepted(written, tmp_path, capsys):
    """Names, comments, order and the way in which a number is written do not count."""
    content = read_yaml(RIG)
    content['name'] = 'ours'
    content['motor']['displacement_cc_rev'] = 195.0
    same = tmp_path / 'same.yaml'
    same.write_text('# ours\n' + yaml.safe_dump(content, sort_keys=True))
    assert load_rig(same).digest == default_rig().digest
    assert run(capsys, written, '--rig', same, '-o', tmp_path / 'rig.yaml')[0] == 0


def test_a_second_diagnosis_is_added_to_the_first(tmp_path):
    """Effects, calibration and provenance of both are in the rig."""
    first = adopt(read_yaml(RIG), diagnosis(), 'first.json', 'rig.yaml')
    second = diagnosis()
    second['rig_digest'] = digest(first)
    second['effects'] = [{'id': 'back_pressure', 'error_removed': 0.9, 'parameters': {
        'outlet_pressure': {'value': 3e5, 'low': 2e5, 'high': 4e5, 'unit': 'Pa'}}}]
    second['calibration'] = [{'quantity': 'motor.leakage', 'factor': 1.1},
                             {'quantity': 'motor.inertia', 'factor': 0.9}]
    both = adopt(first, second, 'second.json', 'first.yaml')
    assert list(both['effects']) == ['bearing_friction', 'pump_lag', 'back_pressure']
    assert both['calibration'] == {'motor.leakage': pytest.approx(1.05 * 1.1),
                                   'motor.inertia': pytest.approx(0.9)}
    assert [entry['diagnosis'] for entry in both['provenance']['adopted']] == [
        'first.json', 'second.json']
    assert 'back_pressure' not in first['effects']


def test_the_diagnosed_rig_is_not_overwritten(tmp_path, capsys):
    """Both files are wanted: one to compare with the other."""
    own, found = tmp_path / 'own.yaml', tmp_path / 'diagnosis.json'
    own.write_text(RIG.read_text())
    found.write_text(json.dumps(diagnosis(own)))
    assert 'choose another name' in refused(capsys, found, '--rig', own, '-o', own)
    assert own.read_text() == RIG.read_text()


def test_a_file_that_exists_is_replaced_only_with_force(written, tmp_path, capsys):
    """Somebody's rig stays as it is; with --force it does not, the inputs still do."""
    target = tmp_path / 'rig.yaml'
    target.write_text('somebody: else\n')
    said = refused(capsys, written, '-o', target)
    assert str(target) in said and 'exists already' in said and '--force' in said
    assert target.read_text() == 'somebody: else\n'
    assert run(capsys, written, '-o', target, '--force')[0] == 0
    assert load_rig(target).effects.keys() == FOUND.keys()
    before = written.read_bytes()
    assert 'would be read and written over' in refused(capsys, written, '-o', written, '--force')
    assert written.read_bytes() == before
    link = tmp_path / 'link.yaml'
    link.symlink_to(RIG)
    assert 'is the rig that was diagnosed' in refused(capsys, written, '-o', link, '--force')


def test_all_parameters_are_written(tmp_path):
    """What a diagnosis from before did not know of is written as it was then: not there."""
    older = diagnosis()
    del older['effects'][0]['parameters']['load_share']
    adopted = adopt(read_yaml(RIG), older, 'd.json', 'rig.yaml')
    assert adopted['effects']['bearing_friction'] == {'coulomb': 13.0, 'load_share': 0.0}


def test_of_the_oil_nothing_is_written_that_was_not_told(tmp_path):
    """A leak's power of the viscosity is a commissioned machine's; others have none."""
    leak = diagnosis()
    leak['effects'] = [{'id': 'motor_leakage', 'parameters': {
        'conductance': {'value': 1e-12}, 'exponent': {'value': 1.0}}}]
    assert adopt(read_yaml(RIG), leak, 'd.json', 'rig.yaml')['effects'] == {
        'motor_leakage': {'conductance': 1e-12, 'exponent': 1.0}}
    leak['effects'][0]['parameters'] |= {'oil_power': {'value': 0.5},
                                         'oil_viscosity_ratio': {'value': 1.3}}
    assert adopt(read_yaml(RIG), leak, 'd.json', 'rig.yaml')['effects']['motor_leakage'] == {
        'conductance': 1e-12, 'exponent': 1.0, 'oil_power': 0.5, 'oil_viscosity_ratio': 1.3}


def without_effects(content):
    content.update(effects=[], verdict='none')


def foreign_effect(content):
    content['effects'][0]['id'] = 'moon_phase'


def no_value(content):
    content['effects'][0]['parameters']['coulomb'] = {'value': None}


def no_size(content):
    del content['effects'][0]['parameters']['coulomb']


def foreign_parameter(content):
    content['effects'][0]['parameters']['weight'] = {'value': 1.0}


def foreign_quantity(content):
    content['calibration'][0]['quantity'] = 'motor.colour'


def no_factor(content):
    del content['calibration'][0]['factor']


BAD = {
    'another schema': (lambda content: content.update(schema='hst_drive/comparison/1'),
                       "key 'schema' is 'hst_drive/comparison/1'"),
    'no effects': (lambda content: content.pop('effects'), "key 'effects'"),
    'nothing found': (without_effects, "is 'none' and names no effect"),
    'an effect that is not known': (foreign_effect, "effect 'moon_phase' is not in the catalogue"),
    'a value that is missing': (no_value, "effect 'bearing_friction' has no readable"),
    'a size that is missing': (no_size, "effect 'bearing_friction' lacks its size 'coulomb'"),
    'a parameter that is not known': (foreign_parameter, "has no parameter 'weight'"),
    'a quantity that is not known': (foreign_quantity, 'motor.colour'),
    'no factor': (no_factor, "key 'calibration'"),
    'calibration as a text': (lambda content: content.update(calibration='x'),
                              "key 'calibration'"),
}


@pytest.mark.parametrize('case', BAD)
def test_bad_diagnoses(tmp_path, capsys, case):
    """One line that names the file, and nothing is written."""
    change, expected = BAD[case]
    content = copy.deepcopy(diagnosis())
    change(content)
    path = tmp_path / 'bad.json'
    path.write_text(json.dumps(content))
    assert expected in refused(capsys, path, '-o', tmp_path / 'rig.yaml')
    assert not (tmp_path / 'rig.yaml').exists()


def with_formula(factors):
    """Return a diagnosis with a formula for what is unknown, found with these factors."""
    size = {'value': 0.1, 'low': 0.0, 'high': 0.2, 'unit': '1'}
    content = {**diagnosis(), 'effects': [], 'verdict': 'unknown'}
    return {**content, 'unknown': {'formula': {
        'id': 'formula_load', 'parameters': {'coefficient_1': size}, 'beside': {},
        'factors': factors}}}


@pytest.mark.parametrize('factors, written', [({'motor.leakage': 2}, 2.0), ({}, None)])
def test_factors_may_be_whole_numbers_or_none(factors, written):
    rig = adopt(read_yaml(RIG), with_formula(factors), 'd.json', 'rig.yaml', formula=True)
    assert rig['calibration'].get('motor.leakage') == written


@pytest.mark.parametrize('factors, key', [
    (None, 'is NoneType'), ([1.1], 'is list'), ({'motor.leakage': '2'}, "motor.leakage' is '2'"),
    ({'motor.leakage': True}, "motor.leakage' is True")])
def test_factors_that_are_none_are_refused(factors, key):
    with pytest.raises(InputError, match=r"^d\.json: key 'unknown\.formula\.factors") as problem:
        adopt(read_yaml(RIG), with_formula(factors), 'd.json', 'rig.yaml', formula=True)
    assert key in str(problem.value) and 'write the diagnosis again' in str(problem.value)


def test_what_is_told_alone_is_no_reason_to_refuse(tmp_path):
    content = diagnosis()
    content['logs'] = content['effects'][0]['indistinguishable_from'] = None
    past, = adopt(read_yaml(RIG), content, 'd.json', 'rig.yaml')['provenance']['adopted']
    assert past['logs'] == past['indistinguishable_from']['bearing_friction'] == []


@pytest.mark.parametrize('text, expected', [
    ('', 'is not JSON'), ('{"schema":', 'is not JSON'), ('[1]', "key 'schema'"),
    ('\xff\xfe', 'is not JSON')])
def test_what_is_no_diagnosis(tmp_path, capsys, text, expected):
    """An empty file, a cut one, a list, no text at all."""
    path = tmp_path / 'bad.json'
    path.write_bytes(text.encode('latin-1'))
    said = refused(capsys, path, '-o', tmp_path / 'rig.yaml')
    assert expected in said and str(path) in said


def test_without_a_file(tmp_path, capsys):
    """Not there; a rig that is not there."""
    assert 'cannot be read' in refused(capsys, tmp_path / 'no.json', '-o', tmp_path / 'rig.yaml')
    assert '-o' in refused(capsys, tmp_path / 'no.json')


def test_an_error_of_the_rig_file_names_the_rig_file():
    """Refusals at the level of the library are of the kind that the command line prints."""
    with pytest.raises(InputError, match='ours.yaml: is not the rig'):
        adopt({'motor': {}}, diagnosis(), 'd.json', 'ours.yaml')


def test_the_rig_alone_on_standard_output(written, capsys):
    """With -o - the YAML can be piped; what was added is told on standard error."""
    code, out, err = run(capsys, written, '-o', '-')
    assert code == 0 and 'bearing_friction' in err
    assert parse_rig(yaml.safe_load(out)).effects.keys() == FOUND.keys()


def test_a_name_that_is_too_long_is_refused_in_one_line(written, tmp_path, capsys):
    target = tmp_path / f'{"x" * 300}.yaml'
    assert 'File name too long' in refused(capsys, written, '-o', target)


def test_the_calibration_alone_where_nothing_is_missing(written, tmp_path, capsys):
    """A healthy unit off its datasheet: the rig then has its factors, and no effect."""
    none, target = tmp_path / 'none.json', tmp_path / 'unit.yaml'
    none.write_text(json.dumps({**diagnosis(), 'verdict': 'none', 'effects': []}))
    assert 'add --calibration' in refused(capsys, none, '-o', target)
    code, out, _ = run(capsys, none, '-o', target, '--calibration')
    assert code == 0 and "the unit's calibration (number of quantities: 1)" in out
    drive, plain = Drive(load_rig(target)), Drive(default_rig())
    leakage = INDEX['motor_leakage_scale']
    assert not drive.effects
    assert drive.parameters[leakage] == pytest.approx(1.05 * plain.parameters[leakage])
    assert 'leave --calibration out' in refused(
        capsys, written, '-o', tmp_path / 'no.yaml', '--calibration')


def test_what_fits_as_well_is_told_when_it_is_adopted(written, tmp_path, capsys):
    _, out, _ = run(capsys, written, '-o', tmp_path / 'rig.yaml')
    assert 'bearing_friction is one of several that fit these logs; so may viscous_drag' in out


@pytest.mark.parametrize('rivals, unit, test', [
    (['viscous_drag'], False, True), (['none'], True, False),
    (['viscous_drag', 'none'], True, True)])
def test_the_unit_alone_is_no_effect_that_a_test_could_tell(tmp_path, capsys, rivals, unit, test):
    content = diagnosis()
    content['effects'][0]['indistinguishable_from'] = rivals
    content['effects'][1:] = [{**entry, 'indistinguishable_from': []}
                              for entry in content['effects'][1:]]
    path = tmp_path / 'd.json'
    path.write_text(json.dumps(content))
    _, out, _ = run(capsys, path, '-o', tmp_path / 'rig.yaml')
    assert ('the unit alone at the limits of its tolerances' in out) == unit
    assert ("'hst-drive design' writes a test that tells" in out) == test
