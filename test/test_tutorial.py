# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The tutorial's commands, run as they stand; the JSON of which the documentation tells."""
import json
from pathlib import Path
import re
import shlex

import hst_drive as hd
from hst_drive import cli
from hst_drive.diagnose.result import (
    as_json, Calibrated, Diagnosis, Found, NextTest, Ranked, Step, Unknown, Value, Zero)
from hst_drive.identify.conditions import Outside
from hst_drive.identify.evidence import Probability
import pytest

DOCS = Path(__file__).resolve().parents[1] / 'docs'
HIDDEN = 0.0078 * 1e-3 / 60.0 / 1e5     # m^3/(s.Pa): 0.0078 L/min/bar, as the tutorial hides it
# Keys under which channels, effects or parameters stand by their names.
BY_NAME = {'signals', 'parameters', 'delays', 'smallest_visible', 'before', 'after', 'training',
           'not_observable_because', 'rivals'}


def commands(text):
    """Return the calls of verbs in a text, each as its words."""
    return [shlex.split(line, comments=True)[1:] for line in text.replace('\\\n', '').splitlines()
            if line.startswith('    ./dev ')]


@pytest.mark.needs_numba
def test_from_a_bag_to_the_name_of_the_effect(tmp_path, monkeypatch, capsys):
    """All steps but the further test of step 4, whose two minutes take too long here."""
    for needed in ('rclpy', 'matplotlib'):
        pytest.importorskip(needed)
    monkeypatch.chdir(tmp_path)
    text = (DOCS / 'tutorial.md').read_text(encoding='utf-8')
    first, _, rest = text.partition('\n## 4. ')
    calls = commands(first) + commands(rest.partition('\n## 5. ')[2])
    assert [call[0] for call in calls] == ['run', 'compare', 'diagnose', 'adopt', 'compare']
    printed = []
    for call in calls:
        assert cli.main(call + ['--duration', '20'] * (call[0] == 'run')) == 0, call
        printed.append(capsys.readouterr().out)
    assert 'does not explain the measurements' in printed[1]
    assert 'explains the measurements down to the noise' in printed[4]
    found, = json.loads(Path('found.json').read_text())['effects']
    assert 'motor_leakage' in {found['id'], *found['indistinguishable_from']}
    assert all(Path(name).stat().st_size for name in ('before.png', 'after.png'))
    if found['id'] == 'motor_leakage':
        size = found['parameters']['conductance']
        assert size['low'] < HIDDEN < size['high']


@pytest.mark.needs_numba
def test_the_second_example_of_the_readme(tmp_path, monkeypatch, capsys):
    """A closed circuit reverses with a leak, which is named."""
    pytest.importorskip('rclpy')
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'config').symlink_to(DOCS.parent / 'config')
    text = (DOCS.parent / 'README.md').read_text(encoding='utf-8')
    calls = commands(text.partition('## A closed circuit')[2].partition('\n## ')[0])
    assert [call[0] for call in calls] == ['run', 'diagnose']
    for call in calls:
        assert cli.main(call + ['--json', 'found.json'] * (call[0] == 'diagnose')) == 0, call
    found, = json.loads(Path('found.json').read_text())['effects']
    size = found['parameters']['conductance']
    assert found['id'] == 'motor_leakage'
    assert size['low'] < 0.06 * 1e-3 / 60.0 / 1e5 < size['high']


def keys(document, named=False):
    """Return all keys of a document but those that are names of channels and their kind."""
    if isinstance(document, dict):
        own = set() if named else set(document)
        return own.union(*(keys(value, name in BY_NAME) for name, value in document.items()))
    if isinstance(document, (list, tuple)):
        return set().union(*map(keys, document))
    return set()


@pytest.mark.needs_numba
def test_the_page_of_the_json_has_all_keys():
    page = (DOCS / 'json.md').read_text(encoding='utf-8')
    compared = hd.compare(hd.simulate('paper_step').between(0.0, 20.0)).to_json()
    diagnosed = as_json(Diagnosis(
        verdict='unknown', sentence='Something.',
        effects=(Found('motor_leakage', {'conductance': Value(1, 0, 2, '1')}, 1.0, ()),),
        ranking=(Ranked('motor_leakage', 1.0, 1.0),), ladder=(Step('datasheet', {}, {}),),
        not_observable={}, smallest={'motor_leakage': 1.0},
        calibration=(Calibrated('motor.leakage', 1.0, 0.0, False),),
        unknown=Unknown('flow', 'motor_speed', (), '', (), 0.0), next_test=NextTest((), ''),
        outside=(Outside('motor_speed', 0.0, 1.0, 0.0, 1.0),),
        probability=Probability(0.0, 0.5, (((), 0.5),)),
        zeros=(Zero('line_a_pressure', 0.0, 'Pa', 0.0),)))
    assert diagnosed['schema'] in page and compared['schema'] in page
    missing = {key for key in keys(compared) | keys(diagnosed) if f'`{key}`' not in page}
    assert not missing


def test_the_page_of_the_json_names_all_documents():
    page = (DOCS / 'json.md').read_text(encoding='utf-8')
    said = {schema for path in (DOCS.parent / 'hst_drive').rglob('*.py')
            for schema in re.findall(r"'(hst_drive/\w+/\d+)'", path.read_text(encoding='utf-8'))}
    assert len(said) > 5 and said <= set(re.findall(r'hst_drive/\w+/\d+', page))
