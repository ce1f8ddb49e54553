# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""JSON files and tables of the verbs."""
from dataclasses import dataclass
import json
import os
from pathlib import Path
import stat

from hst_drive.bag import write_csv
from hst_drive.cli import main
from hst_drive.cli.output import table, write_json
from hst_drive.errors import InputError
from hst_drive.rig import default_rig_file
import numpy as np
import pytest

from ..measure.synthetic import record


@dataclass
class Pair:
    """For the test."""

    low: float
    high: float


def read(path):
    """Return what a strict JSON reader sees."""
    def refuse(word):
        raise AssertionError(word)
    return json.loads(path.read_text(encoding='utf-8'), parse_constant=refuse)


def test_numbers_are_finite_or_null(tmp_path):
    """Values that are not finite become null wherever they are; NumPy values become plain."""
    target = tmp_path / 'out.json'
    write_json({'a': float('nan'), 'b': [np.inf, np.float64(1.5)], 'c': np.array([1.0, np.nan]),
                'd': Pair(0.0, -np.inf), 'e': (np.int64(3), True, None, 'µ'), 4: Path('x'),
                'f': np.bool_(True), 'g': np.float32('nan'), 'h': {'b', 'a'}}, target)
    assert read(target) == {
        'a': None, 'b': [None, 1.5], 'c': [1.0, None], 'd': {'low': 0.0, 'high': None},
        'e': [3, True, None, 'µ'], '4': 'x', 'f': True, 'g': None, 'h': ['a', 'b']}


def test_whole_or_not_at_all(tmp_path):
    """What cannot be written leaves the old file and no scratch file."""
    target = tmp_path / 'out.json'
    write_json({'old': 1}, target)
    with pytest.raises(TypeError, match='object'):
        write_json({'new': object()}, target)
    assert read(target) == {'old': 1}
    assert os.listdir(tmp_path) == ['out.json']


def test_rights_are_the_usual(tmp_path):
    """The file may be read like any other that the user makes."""
    write_json(1, tmp_path / 'ours')
    (tmp_path / 'usual').touch()
    modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ('ours', 'usual')}
    assert len(modes) == 1


def test_standard_output(capsys):
    """A dash means standard output."""
    write_json({'a': 1}, '-')
    assert json.loads(capsys.readouterr().out) == {'a': 1}


@pytest.mark.parametrize('place', ['missing/out.json', '.'])
def test_unwritable(tmp_path, place):
    """One line names the file."""
    with pytest.raises(InputError, match='cannot be written'):
        write_json({}, tmp_path / place)


def test_table():
    """Numbers stand right with three significant digits, text left, missing as a dash."""
    assert table(['signal', 'rmse', 'n'], [
        ['speed', 0.012345, 3], ['pressure', 123456.0, 20], ['flow', None, 1],
        ['torque', float('nan'), 1], ['tiny', 1.234e-9, 0],
    ]).splitlines() == [
        'signal        rmse   n',
        '--------  --------  --',
        'speed       0.0123   3',
        'pressure    123456  20',
        'flow             -   1',
        'torque           -   1',
        'tiny      1.23e-09   0']


def test_table_refuses_a_ragged_row():
    """A row has one cell per column."""
    with pytest.raises(ValueError, match='row of 1 in a table of 2'):
        table(['a', 'b'], [[1]])


@pytest.mark.parametrize('arguments', (
    ('compare', 'log.csv', '--json', 'log.csv'), ('report', 'log.csv', '-o', './log.csv'),
    ('compare', 'other.csv', 'log.csv', '--plot', 'log.csv'),
    ('diagnose', 'other.csv', '--holdout', 'log.csv', '--json', 'log.csv')))
def test_no_verb_writes_over_what_it_reads(arguments, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ('log.csv', 'other.csv'):
        write_csv(tmp_path / name, record(3, duration=6.0))
    before = (tmp_path / 'log.csv').read_bytes()
    assert main(list(arguments)) == 2
    assert 'would be read and written over' in capsys.readouterr().err
    assert (tmp_path / 'log.csv').read_bytes() == before


@pytest.mark.parametrize('option', ('-o', '--json'))
@pytest.mark.parametrize('name', ('rig.yaml', 'm/2026-01-01/log.csv'))
def test_a_fleet_writes_over_none_of_its_files(option, name, tmp_path, capsys):
    target = tmp_path / 'fleet' / name
    (tmp_path / 'fleet/m/2026-01-01').mkdir(parents=True)
    write_csv(tmp_path / 'fleet/m/2026-01-01/log.csv', record(3, duration=6.0))
    (tmp_path / 'fleet/rig.yaml').write_bytes(Path(default_rig_file()).read_bytes())
    before = target.read_bytes()
    assert main(['fleet', str(tmp_path / 'fleet'), '--results', str(tmp_path / 'kept'),
                 option, str(target)]) == 2
    assert f'{target}: would be read and written over' in capsys.readouterr().err
    assert target.read_bytes() == before


def test_two_outputs_are_two_files(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_csv(tmp_path / 'log.csv', record(3, duration=6.0))
    assert main(['compare', 'log.csv', '--plot', 'a.png', '--json', './a.png']) == 2
    assert 'a.png: is the name of two outputs' in capsys.readouterr().err
    assert not (tmp_path / 'a.png').exists()
