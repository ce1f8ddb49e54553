# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the workbench computes: the numbers of the verbs, for every switch."""
import json
from pathlib import Path
import shlex

from hst_drive import cli
from hst_drive.bag import read_log, write_csv
from hst_drive.cli.output import write_yaml
from hst_drive.effects import catalogue
from hst_drive.errors import InputError
from hst_drive.measure.compare import compare
from hst_drive.model import Drive
from hst_drive.rig import default_rig, default_rig_file, load_rig
from hst_drive.rig.schema import UNTOLD
from hst_drive.rig.yaml_file import read_yaml
from hst_drive.workbench.answers import Answers, Setting
from hst_drive.workbench.bench import parameters, Workbench
from hst_drive.workbench.sample import HIDDEN, sample_logs
from hst_drive.workbench.state import Base, PageModel, read_model
import numpy as np
import pytest

from ..measure.synthetic import record

pytestmark = pytest.mark.needs_numba
LEAK = {'motor_leakage': {'conductance': 1.2e-12, 'exponent': 1.0, 'oil_power': 0.0,
                          'oil_viscosity_ratio': 1.0}}


@pytest.fixture(scope='module')
def files(tmp_path_factory):
    """Return two logs of a drive that leaks, as files."""
    place = tmp_path_factory.mktemp('bench')
    for seed in (3, 4):
        write_csv(place / f'{seed}.csv', record(seed, duration=12.0, effects=LEAK))
    return [place / '3.csv', place / '4.csv']


def bench_of(files, held=1, rig=None):
    """Return a workbench with the last logs held out."""
    runs = [read_log(path) for path in files]
    file = str(rig or default_rig_file())
    first = len(runs) - held
    return Workbench(Base(read_yaml(file), file), runs[:first], runs[first:])


@pytest.fixture(scope='module')
def bench(files):
    """Return a workbench."""
    return bench_of(files)


@pytest.fixture
def answers(bench, files, tmp_path):
    """Return the answers of a workbench that saves into a folder of the test."""
    return Answers(bench, Setting((str(files[0]),), (str(files[1]),), None, None, tmp_path,
                                  write_yaml))


@pytest.mark.parametrize('effects', [{}, LEAK, {'bearing_friction': {
    'coulomb': 8.0, 'load_share': 0.01}, 'pump_lag': {'time_constant': 0.03}}])
def test_errors_are_those_of_compare(bench, effects):
    expected = compare(Drive(default_rig(), effects), bench.runs).signals
    found = bench.errors(PageModel(effects))
    assert set(found) == set(expected)
    for name, entry in expected.items():
        assert np.isclose(found[name]['ratio'], entry.noise_ratio, rtol=1e-12)


def test_the_quick_answer_is_near_and_judges_alike(bench):
    for effects in ({}, LEAK):
        exact = bench.errors(PageModel(effects))
        log, quick = bench.quick(PageModel(effects), 0)
        for name in exact:
            assert quick[name]['held'] == exact[name]['held']
            assert quick[name]['training'] == exact[name]['training']
            assert np.isclose(quick[name]['ratio'], exact[name]['ratio'], rtol=0.05)
        curves = bench.compared(PageModel(effects), [0])[0].model
        for name, values in log.model.items():
            spread = np.ptp(curves[name])
            assert np.max(np.abs(values - curves[name])) < 0.03 * spread


def test_logs_that_begin_at_other_angles_are_turned_into_step(tmp_path):
    ripple = {'piston_ripple': {'cosine': 0.008, 'sine': 0.004}}
    for place, seed in enumerate((3, 4), 1):
        run = record(seed, duration=12.0, effects=ripple)
        write_csv(tmp_path / f'{seed}.csv', run.between(0.17 * place, run.time[-1]))
    bench = bench_of([tmp_path / '3.csv', tmp_path / '4.csv'])
    log, quick = bench.quick(PageModel(ripple), 0)
    exact = bench.errors(PageModel(ripple))
    for name, entry in exact.items():
        assert entry['ratio'] < 1.5 and quick[name]['ratio'] < 1.5


def test_a_fit_finds_the_size(bench):
    start = PageModel({'motor_leakage': {'conductance': 4e-13}})
    told = []
    found = bench.fit(start, [], False, told.append)
    assert np.isclose(found.effects['motor_leakage']['conductance'], 1.2e-12, rtol=0.05)
    assert found.factors == {} and told
    errors = bench.errors(found)
    assert all(entry['held'] < 1.3 for entry in errors.values())


def test_what_is_locked_stays(bench):
    start = PageModel({'motor_leakage': {'conductance': 4e-13}, 'bearing_friction': {
        'coulomb': 3.0, 'load_share': 0.0}})
    found = bench.fit(start, [('motor_leakage', 'conductance'),
                              ('bearing_friction', 'load_share')], False, lambda text: None)
    assert found.effects['motor_leakage'] == start.effects['motor_leakage']
    assert found.effects['bearing_friction']['load_share'] == 0.0
    assert found.effects['bearing_friction']['coulomb'] < 1.0


def test_a_calibration_stays_unless_asked_for(bench):
    start = PageModel(LEAK, {'motor.inertia': 1.05})
    assert bench.fit(start, [], False, lambda text: None).factors == pytest.approx(start.factors)
    free = bench.fit(start, [], True, lambda text: None).factors
    assert set(free) >= {'motor.inertia', 'motor.leakage'}
    assert all(abs(np.log(value)) <= 3.01 * {**UNTOLD, **default_rig().tolerances}[key]
               for key, value in free.items())


def test_diagnose_offers_what_it_found(bench):
    told = []
    found = bench.diagnose(PageModel(), told.append)
    assert found['diagnosis']['effects'][0]['id'] == 'motor_leakage' and len(told) > 3
    offer = read_model(found['offers'][0]['model'])
    value = offer.effects['motor_leakage']['conductance']
    assert np.isclose(value, 1.2e-12, rtol=0.1)
    assert bench.errors(offer)['motor_speed']['held'] < 1.3


def test_a_saved_rig_gives_the_same_numbers(answers, files, tmp_path):
    model = {'effects': LEAK, 'factors': {'pump.leakage': 1.07}}
    saved = answers.answer('save', {'model': model, 'name': 'mine.yaml'})
    assert load_rig(saved['path']).effects == LEAK
    words = shlex.split(saved['command'])
    assert words[:2] == ['hst-drive', 'compare']
    assert cli.main([*words[1:], '--json', str(tmp_path / 'c.json')]) == 0
    printed = json.loads((tmp_path / 'c.json').read_text())['signals']
    for name, entry in answers.answer('errors', {'model': model})['signals'].items():
        assert np.isclose(printed[name]['noise_ratio'], entry['ratio'], rtol=1e-9)


def test_the_command_line_gives_the_same_numbers(answers, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    model = {'effects': LEAK, 'factors': {'pump.leakage': 1.07}}
    words = shlex.split(answers.answer('command', {'model': model})['command'])
    assert cli.main([*words[1:], '--json', 'r.json']) == 0
    printed = json.loads(Path('r.json').read_text())['comparison']['signals']
    for name, entry in answers.answer('errors', {'model': model})['signals'].items():
        assert np.isclose(printed[name]['noise_ratio'], entry['ratio'], rtol=1e-9)


def test_a_rig_with_effects_starts_with_them_on(files, tmp_path):
    content = read_yaml(str(default_rig_file()))
    write_yaml({**content, 'effects': LEAK, 'calibration': {'pump.leakage': 1.1}},
               tmp_path / 'rig.yaml')
    bench = bench_of(files, rig=tmp_path / 'rig.yaml')
    assert bench.base.start == PageModel(LEAK)
    expected = compare(Drive(load_rig(tmp_path / 'rig.yaml')), bench.runs).signals
    for name, entry in bench.errors(bench.base.start).items():
        assert np.isclose(entry['ratio'], expected[name].noise_ratio, rtol=1e-12)
    write_yaml({**content, 'calibration': {'pump.leakage': 1.1}}, tmp_path / 'bare.yaml')
    off = compare(Drive(load_rig(tmp_path / 'bare.yaml')), bench.runs).signals
    for name, entry in bench.errors(PageModel()).items():
        assert np.isclose(entry['ratio'], off[name].noise_ratio, rtol=1e-12)
    assert off['motor_speed'].noise_ratio > 1.2 * expected['motor_speed'].noise_ratio


@pytest.mark.parametrize('question, content, words', [
    ('errors', {'model': {'effects': {'motor_leakage': {'conductance': 1.0}}}}, 'outside the'),
    ('errors', {'model': {'effects': {'motor_leak': {}}}}, "did you mean 'motor_leakage'"),
    ('errors', {'model': {'effects': {'motor_leakage': {'conductance': 'much'}}}}, 'conductance'),
    ('errors', {'model': {'factors': {'motor.leakage': 99}}}, '0.2 to 5'),
    ('errors', {'model': {'factors': {'a': 1}}}, "unknown factor 'a'"),
    ('errors', {'model': []}, 'expected a mapping'),
    ('errors', {}, 'expected a mapping'),
    ('log', {'model': {}, 'log': 7}, 'expected 0 to 1'),
    ('fit', {'model': {}}, 'no effect is on'),
    ('fit', {'model': {}, 'locked': [1]}, 'expected pairs'),
    ('save', {'model': {}, 'name': '../rig.yaml'}, 'without a folder'),
    ('save', {'model': {}, 'name': '/etc/rig.yaml'}, 'without a folder'),
    ('save', {'model': {}, 'name': 'rig.py'}, 'ending in .yaml'),
])
def test_wrong_input_is_told_in_one_line(answers, question, content, words):
    with pytest.raises(InputError, match='.') as said:
        answers.answer(question, content)
    assert words in str(said.value) and '\n' not in str(said.value)


def test_no_file_is_replaced(answers, tmp_path):
    (tmp_path / 'mine.yaml').write_text('precious')
    with pytest.raises(InputError, match='exists already'):
        answers.answer('save', {'model': {}, 'name': 'mine.yaml'})
    assert (tmp_path / 'mine.yaml').read_text() == 'precious'


def test_what_nobody_waits_for_is_left(answers):
    older, newer = ({'model': {'effects': {'motor_leakage': {'conductance': size}}},
                     'page': 'a', 'log': 0, 'serial': serial}
                    for serial, size in ((1, 0.7e-12), (2, 0.8e-12)))
    answers.answer('quick', newer)
    with pytest.raises(InputError, match='newer'):
        answers.answer('errors', older)
    assert answers.answer('errors', newer)['signals']
    # Another page has a count of its own.
    assert answers.answer('errors', {**older, 'page': 'b'})['signals']


def test_a_job_can_be_stopped(answers):
    assert answers.answer('diagnose', {'model': {}})['state'] == 'running'
    with pytest.raises(InputError, match='still at work'):
        answers.answer('fit', {'model': {'effects': LEAK}})
    answers.answer('stop', {})
    answers.job.wait(60)
    assert answers.answer('job', {})['state'] == 'stopped'


def test_the_catalogue_is_whole():
    shown = {entry['id']: entry for entry in parameters(default_rig())}
    of_others = {'charge_pressure_loss', 'cross_port_leakage', 'cross_port_relief_cracking',
                 'valve_dead_band', 'valve_lag'}
    assert of_others < set(catalogue())
    assert set(shown) <= set(catalogue()) - of_others
    assert {'back_pressure', 'prv_cracking', 'shaft_compliance'} < set(shown)
    leak, *_ = shown['motor_leakage']['parameters']
    assert leak['unit'] == 'L/min/bar' and np.isclose(leak['high'] * leak['per'], 0.18)


def test_the_sample_is_the_same_everywhere_and_hides_its_effect():
    first, held = sample_logs(default_rig())
    again, _ = sample_logs(default_rig())
    assert all(np.array_equal(first[name], again[name]) for name in first.channels)
    assert len(first) == 6000 and not np.array_equal(first['pprv_command'][:4000],
                                                     held['pprv_command'])
    wrong = compare(Drive(default_rig()), [first]).signals
    right = compare(Drive(default_rig(), HIDDEN), [first]).signals
    assert wrong['motor_speed'].noise_ratio > 5
    assert all(entry.noise_ratio < 1.3 for entry in right.values())
