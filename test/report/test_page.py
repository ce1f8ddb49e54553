# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The static page: whole, self-contained, with the numbers of compare, and nothing gets out."""
import base64
from html.parser import HTMLParser
import json
import re

from hst_drive import cli
from hst_drive.bag import write_csv
from hst_drive.measure.compare import compare, model_of
from hst_drive.report.found_sections import found_section, unit_section
from hst_drive.report.variants import variants_of
from hst_drive.rig import default_rig
import numpy as np
import pytest

from ..measure.synthetic import record

SIGNALS = ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque')


def made_up_diagnosis(logs=()):
    """Return a diagnosis as 'diagnose --json' writes it."""
    def rung(added, value):
        return {'added': added, 'training': dict.fromkeys(SIGNALS, value),
                'holdout': dict.fromkeys(SIGNALS, value + 0.1)}

    return {
        'schema': 'hst_drive/diagnosis/1', 'verdict': 'ambiguous',
        'sentence': 'The model lacks motor_leakage.', 'rig': 'rig.yaml',
        'rig_digest': default_rig().digest, 'logs': list(logs),
        'effects': [{'id': 'motor_leakage', 'error_removed': 0.97,
                     'indistinguishable_from': ['elastic_leakage'],
                     'parameters': {'conductance': {
                         'value': 1e-12, 'low': 0.9e-12, 'high': 1.1e-12,
                         'unit': 'm^3/(s.Pa)'}}}],
        'ladder': [rung('datasheet', 8.0), rung('calibrated unit', 5.0),
                   rung('motor_leakage', 1.0)],
        'ranking': [{'id': 'motor_leakage', 'holdout_noise_ratio': 1.1, 'evidence': 300.0}],
        'calibration': [{'quantity': 'motor.leakage', 'factor': 1.02, 'sigmas': 0.3,
                         'at_limit': False}],
        'rivals': {'pump_leakage': 'leaves hydromotor inlet flow at 2.0 times the noise'},
        'probability': {'none': 0.001, 'unknown': 0.069, 'effects': {}, 'calibrated': True,
                        'sets': [{'effects': ['motor_leakage'], 'probability': 0.93}]},
        'not_observable': ['case'], 'not_observable_because': {'case': 'needs a channel'},
        'smallest_visible': {'line_loss': {'value': 1e7, 'unit': 'Pa.s/m^3'}},
        'unknown': None,
        'next_test': {'separates': ['motor_leakage', 'elastic_leakage'], 'what': 'hold 90 bar'}}


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a short log of a drive that leaks."""
    place = tmp_path_factory.mktemp('report')
    write_csv(place / 'run.csv', record(3, duration=5.0, settled=True, effects={
        'motor_leakage': {'conductance': 1e-12}}))
    (place / 'd.json').write_text(json.dumps(made_up_diagnosis([str(place / 'run.csv')])))
    return place


@pytest.fixture(scope='module')
def made(folder):
    """Return page and JSON with the made-up diagnosis."""
    assert cli.main(['report', str(folder / 'run.csv'), '--diagnosis', str(folder / 'd.json'),
                     '-o', str(folder / 'p.html'), '--json', str(folder / 'r.json')]) == 0
    return (folder / 'p.html').read_text(encoding='utf-8'), json.loads(
        (folder / 'r.json').read_text())


class Reader(HTMLParser):
    """Collects elements, their text and whatever a browser would fetch."""

    def __init__(self, text):
        super().__init__()
        self.fetched, self.tags, self.ids, self.words, self.open = [], [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        """Remember an element."""
        self.tags.append(tag)
        for name, value in attrs:
            if name == 'id':
                self.ids.append(value)
            if name in ('src', 'href', 'action', 'srcset', 'poster', 'data', 'style'):
                self.fetched.append(value)
            assert not name.startswith('on'), f'{tag} has {name}'
        if tag not in ('meta', 'link', 'br', 'img', 'input'):
            self.open.append(tag)

    def handle_endtag(self, tag):
        """Check that elements nest."""
        assert self.open.pop() == tag

    def handle_data(self, data):
        """Remember what a person reads."""
        if not self.open or self.open[-1] not in ('script', 'style'):
            self.words.append(data)


def test_nothing_is_fetched(made):
    reader = Reader(made[0])
    assert reader.open == [] and len(reader.ids) == len(set(reader.ids))
    assert {'link', 'img', 'iframe', 'object'}.isdisjoint(reader.tags)
    for value in reader.fetched:
        assert value.startswith('#') and value[1:] in reader.ids
    # The only address in it names the kind of a picture's elements.
    assert set(re.findall(r'https?://[^\s\'"]+', made[0])) == {'http://www.w3.org/2000/svg'}
    assert "default-src 'none'" in made[0] and '@import' not in made[0]


def test_it_says_what_was_found(made):
    words = ' '.join(Reader(made[0]).words)
    for expected in ('The model lacks motor_leakage.', 'ambiguous', 'elastic_leakage',
                     'W. E. Wilson', '0.005400 to 0.006600', 'L/min/bar', 'pump_leakage',
                     'hold 90 bar', 'motor.leakage', '1.0200', default_rig().digest,
                     'It removes 97 %', 'line_loss', 'needs a channel',
                     'Probability: motor_leakage 0.93, unknown 0.07.'):
        assert expected in words, expected


def test_a_diagnosis_written_before_does_not_say_that_its_probabilities_held():
    content = made_up_diagnosis()
    del content['probability']['calibrated']
    assert 'not calibrated for such logs: motor_leakage 0.93' in str(found_section(content))


def test_a_unit_is_laid_beside_what_it_is_calibrated_from():
    content = made_up_diagnosis()
    assert 'This unit against the datasheet' in str(unit_section(content))
    told = str(unit_section({**content, 'since': ['first.csv']}))
    assert 'This unit against the commissioned unit' in told and 'datasheet' not in told


def test_the_numbers_are_those_of_compare(made, folder):
    assert cli.main(['compare', str(folder / 'run.csv'), '--json', str(folder / 'c.json')]) == 0
    assert made[1]['comparison'] == json.loads((folder / 'c.json').read_text())
    assert cli.main(['adopt', str(folder / 'd.json'), '-o', str(folder / 'rig.yaml')]) == 0
    assert cli.main(['compare', str(folder / 'run.csv'), '--rig', str(folder / 'rig.yaml'),
                     '--json', str(folder / 'a.json')]) == 0
    adopted, = made[1]['with_found']
    # Rig files hold eight digits of a calibration.
    for name, entry in json.loads((folder / 'a.json').read_text())['signals'].items():
        found = adopted['comparison']['signals'][name]
        assert np.isclose(found['noise_ratio'], entry['noise_ratio'], rtol=1e-6)
    text = f'{made[1]["comparison"]["signals"]["motor_speed"]["noise_ratio"]:.3g}'
    assert text in made[0]


def test_the_curves_are_those_of_the_log(made, folder):
    raw = re.search(r'<script type="application/json" id="data">(.*?)</script>', made[0])[1]
    data = json.loads(raw)
    log, = data['logs']
    shown = np.frombuffer(base64.b64decode(log['measured']['motor_speed']), '<f4')
    recorded = np.loadtxt(folder / 'run.csv', delimiter=',', skiprows=1)
    header = (folder / 'run.csv').read_text().splitlines()[0].split(',')
    assert np.allclose(shown, recorded[:, header.index('motor_speed[rpm]')], rtol=1e-6)
    model, error = (np.frombuffer(base64.b64decode(
        data['variants'][0]['logs'][0][key]['motor_speed']), '<f4') for key in ('model', 'error'))
    assert np.allclose(model - shown, error, atol=1e-3)
    errors = made[1]['comparison']['signals']['motor_speed']
    assert np.isclose(np.sqrt(np.mean(error.astype(float)**2)) * np.pi / 30, errors['rmse'],
                      rtol=1e-5)


def test_hostile_names_stay_text(tmp_path, folder):
    name = '<img src=x onerror=alert(1)>&amp; "quoted".csv'
    (tmp_path / name).write_text((folder / 'run.csv').read_text())
    assert cli.main(['report', str(tmp_path / name), '--no-diagnosis', '-o',
                     str(tmp_path / 'p.html')]) == 0
    text = (tmp_path / 'p.html').read_text(encoding='utf-8')
    reader = Reader(text)
    assert 'img' not in reader.tags and reader.open == []
    assert name.removesuffix('.csv') in ''.join(reader.words)
    # Not even inside the data, where </script> would end it.
    assert '<img' not in text


def test_long_logs_are_not_diagnosed_unasked(tmp_path, capsys):
    run = record(5, duration=4.0, rate=10)
    slow = type(run)(run.name, run.time * 200, run.channels, 'slow.csv')
    from hst_drive.cli.report import _diagnosis

    class Asked:
        diagnosis, no_diagnosis, diagnose, logs = None, False, False, ['slow.csv']

    found, remark = _diagnosis(Asked, default_rig(), [slow])
    assert found is None and '13 min' in remark and '--diagnose' in remark


@pytest.mark.parametrize('arguments, words', [
    (['--diagnosis', 'none.json'], 'none.json: cannot be read'),
    (['--diagnosis', 'run.csv'], 'is not JSON'),
    (['--diagnosis', 'other.json'], "schema 'hst_drive/diagnosis/1'"),
    (['--no-diagnosis', '--diagnose'], 'not allowed with argument'),
    (['-o', 'none/p.html'], 'cannot be written'),
    (['--no-diagnosis', '--effect', 'motor_leak.conductance=1'], "did you mean 'motor_leakage'"),
    (['--no-diagnosis', '--factor', 'motor.leakage'], 'expected QUANTITY=FACTOR'),
    (['--no-diagnosis', '--factor', 'motor.leak=1.1'], 'motor.leak'),
])
def test_wrong_input_is_told_in_one_line(folder, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(folder)
    (folder / 'other.json').write_text('{"schema": "hst_drive/comparison/1"}')
    assert cli.main(['report', 'run.csv', *arguments]) == 2
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith('hst-drive: ') and words in line


def test_where_it_fails_now_is_not_where_the_older_logs_were():
    """A leak since then: all of the error lies in the new log, whatever is unlike between both."""
    rig = default_rig()
    runs = [record(4, duration=20.0, effects={'motor_leakage': {'conductance': 4e-12}}),
            record(5, duration=20.0)]
    both, new = (compare(model_of(rig, runs), given) for given in (runs, runs[:1]))
    assert both.where != new.where
    shown, = variants_of({}, rig, runs, both, None, '', before=1)
    assert shown.comparison.where == new.where and shown.comparison.signals == both.signals
