# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The verb diagnose on a measurement that another program made: its JSON, adoption, the fall."""
from datetime import date
import json
import math

from hst_drive import cli
from hst_drive.effects import catalogue
from hst_drive.rig import load_rig
import pytest

pytestmark = pytest.mark.needs_numba
VERDICTS = ('none', 'missing_effect', 'ambiguous', 'unknown')
HIDDEN = 'line_loss'


@pytest.fixture(scope='module')
def campaign(tmp_path_factory):
    """Return the folder of a short campaign of a drive with a narrow hose."""
    from ..truth import make_campaign, write_campaign

    made = make_campaign(3, {HIDDEN: 1.5}, on_datasheet=True, duration=24.0,
                         logs=('speed_sweep', 'open_loop'), keep_exact=False)
    return write_campaign(made, tmp_path_factory.mktemp('campaign'))


@pytest.fixture(scope='module')
def diagnosed(campaign):
    """Return what the verb printed and the file that it wrote; diagnosed once for all tests."""
    from contextlib import redirect_stderr, redirect_stdout
    from io import StringIO

    out, err, target = StringIO(), StringIO(), campaign / 'diagnosis.json'
    with redirect_stdout(out), redirect_stderr(err):
        code = cli.main(['diagnose', str(campaign / 'open_loop.csv'), '--holdout',
                         str(campaign / 'speed_sweep.csv'), '--rig', str(campaign / 'rig.yaml'),
                         '--json', str(target)])
    assert code == 0, err.getvalue()
    return out.getvalue(), err.getvalue(), target


@pytest.fixture
def content(diagnosed):
    """Return the JSON."""
    return json.loads(diagnosed[2].read_text())


def noise_ratios(entry):
    """Check a mapping of signal to noise ratio."""
    assert entry
    for value in entry.values():
        assert isinstance(value, float) and value > 0


def test_json_is_that_of_the_contract(content):
    """Every key of the contract is there, with its type."""
    assert content['schema'] == 'hst_drive/diagnosis/1'
    assert content['verdict'] in VERDICTS
    first, second = content['logs']
    assert first.endswith('open_loop.csv') and content['held_out'] == [second]
    ids = set(catalogue())
    for effect in content['effects']:
        assert effect['id'] in ids
        assert set(effect['indistinguishable_from']) <= ids - {effect['id']}
        assert 0.0 < effect['error_removed'] <= 1.0
        declared = {entry.name: entry for entry in catalogue()[effect['id']].parameters}
        assert effect['parameters'].keys() == declared.keys()
        for name, value in effect['parameters'].items():
            assert value['unit'] == declared[name].unit
            assert declared[name].low <= value['low'] <= value['value'] <= value['high']
            assert value['high'] <= declared[name].high
    assert content['ranking']
    for entry in content['ranking']:
        assert entry['id'] in ids
        assert entry['holdout_noise_ratio'] > 0 and math.isfinite(entry['evidence'])
    for part in ('errors', 'holdout'):
        assert content[part].keys() == {'before', 'after'}
        noise_ratios(content[part]['before'])
        noise_ratios(content[part]['after'])
        assert content[part]['before'].keys() == content[part]['after'].keys()
    assert set(content['not_observable']) <= ids
    given = content['probability']
    shares = [given['none'], given['unknown'], *(each['probability'] for each in given['sets'])]
    assert all(0.0 <= share <= 1.0 for share in shares)
    assert sum(shares) == pytest.approx(1.0, abs=1e-9)
    assert given['effects'].keys() <= ids
    for name, share in given['effects'].items():
        assert share == pytest.approx(sum(each['probability'] for each in given['sets']
                                          if name in each['effects']))


def test_the_probability_goes_with_the_verdict(content, diagnosed):
    """The effect that was hidden is the most probable explanation, and the text tells it."""
    assert max(content['probability']['effects'].items(), key=lambda item: item[1])[0] == HIDDEN
    assert content['probability']['effects'][HIDDEN] > 0.5
    assert content['probability']['calibrated'] is True, 'a whole drive, open circuit'
    assert f'probability: {HIDDEN} ' in diagnosed[0]
    assert content['unknown'] is None or {'enters', 'signal', 'depends_on', 'expression'} <= set(
        content['unknown'])
    assert content['next_test'] is None or {'separates', 'what'} <= set(content['next_test'])


def test_the_verdict_fits_the_rest(content):
    """Rivals make it ambiguous; the unknown comes with its verdict alone."""
    rivals = any(effect['indistinguishable_from'] for effect in content['effects'])
    assert (content['verdict'] == 'ambiguous') == (rivals and content['verdict'] != 'unknown')
    assert (content['verdict'] == 'none') == (not content['effects']
                                              and content['verdict'] != 'unknown')
    assert (content['unknown'] is None) == (content['verdict'] != 'unknown')


def test_the_hidden_effect_is_in_the_answer(content):
    """It is named, or among those that these logs cannot tell from what is named."""
    first = content['effects'][0]
    assert HIDDEN in (first['id'], *first['indistinguishable_from'])
    before, after = (content['holdout'][key]['pump_outlet_pressure']
                     for key in ('before', 'after'))
    assert before > 3.0 and after < 1.3


def test_the_sentence_comes_first(diagnosed, content):
    """The first line is the answer, the details follow; progress is on standard error."""
    out, err, _ = diagnosed
    assert out.splitlines()[0] == content['sentence'].strip()
    assert content['effects'][0]['id'] in out.splitlines()[0]
    assert 'error over the noise floor' in out and 'calibrating the unit' in err
    assert 'calibrating' not in out


def test_sizes_are_printed_in_units_of_the_field(diagnosed, content):
    """Pressure per flow in bar and L/min; the JSON is in SI."""
    first = content['effects'][0]
    for name, value in first['parameters'].items():
        unit = {'Pa.s/m^3': 'bar/(L/min)', 'Pa.s^2/m^6': 'bar/(L/min)^2', '1': '1'}[value['unit']]
        factor = {'bar/(L/min)': 6e9, 'bar/(L/min)^2': 3.6e14, '1': 1.0}[unit]
        row = next(line for line in diagnosed[0].splitlines() if f' {name} ' in line)
        assert f' {value["value"] / factor:.4g} ' in row and f' {unit} ' in f'{row} '


def test_adopting_it_makes_the_error_fall(diagnosed, content, campaign, capsys):
    """Diagnosis, adoption, comparison: the same log, with what was found and without."""
    rig, target, log = campaign / 'rig.yaml', campaign / 'adopted.yaml', campaign / 'open_loop.csv'
    assert cli.main(['adopt', str(diagnosed[2]), '--rig', str(rig), '-o', str(target)]) == 0
    ratios = []
    for file in (rig, target):
        capsys.readouterr()
        assert cli.main(['compare', str(log), '--rig', str(file), '--json', '-']) == 0
        signals = json.loads(capsys.readouterr().out)['signals']
        ratios.append(signals['pump_outlet_pressure']['noise_ratio'])
    assert ratios[0] > 3.0 and ratios[1] < 1.3
    assert date.fromisoformat(load_rig(target).provenance['adopted'][-1]['adopted'])
    again = cli.main(['adopt', str(diagnosed[2]), '--rig', str(target), '-o',
                      str(campaign / 'twice.yaml')])
    assert again == 2 and 'is adopted already' in capsys.readouterr().err


def test_whose_logs_they_are_taken_for_is_said(tmp_path, capsys):
    """A bench's log without a rig file is of the shipped rig; a whole drive says so by itself."""
    log, told = tmp_path / 'axis.csv', "no --rig: taken for logs of the shipped 'drill drive test"
    log.write_text('time[s],motor_speed[rpm],motor_torque[N.m]\n' + ''.join(
        f'{k / 50},{30 + 20 * math.sin(k / 20)},{100 * math.cos(k / 20)}\n' for k in range(600)))
    cli.main(['diagnose', str(log)])
    assert told in capsys.readouterr().err
    rig = tmp_path / 'rig.yaml'
    rig.write_text('name: axis\nmotor: {inertia_total_kg_m2: 20}\n')
    cli.main(['diagnose', str(log), '--rig', str(rig)])
    assert told not in capsys.readouterr().err


def test_wrong_input_is_one_line(campaign, capsys):
    """A log that is not there, as LOG and as --holdout; a log that closes no balance."""
    log, empty = str(campaign / 'open_loop.csv'), campaign / 'thin.csv'
    empty.write_text('time[s],oil_temperature[degC]\n' + ''.join(
        f'{k / 10},50\n' for k in range(30)))
    for arguments in (['none.csv'], [log, '--holdout', 'none.csv'], [str(empty)]):
        code = cli.main(['diagnose', *arguments])
        out, err = capsys.readouterr()
        assert code == 2 and not out, arguments
        assert err.splitlines()[-1].startswith('hst-drive: ') and 'Traceback' not in err
