# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The verb ``effects``."""
import json

from hst_drive.cli import main
from hst_drive.effects import catalogue
import pytest


def test_lists_all(capsys):
    """One line per effect, with the balance that it enters."""
    assert main(['effects']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert sorted(line.split()[0] for line in lines[2:]) == sorted(catalogue())
    assert any(line.startswith('gearbox_loss') and ' load ' in line for line in lines)


@pytest.mark.parametrize('name', catalogue())
def test_explains(name, capsys):
    """Equation, units, bounds, source and tell-tale of one."""
    assert main(['effects', name]) == 0
    said = ' '.join(capsys.readouterr().out.split())
    effect = catalogue()[name]
    for text in (effect.title, effect.equation, effect.telltale, effect.source):
        assert ' '.join(text.split()) in said
    for entry in effect.parameters:
        assert f'{entry.name} {entry.unit} ' in said and entry.meaning in said


def test_json(tmp_path, capsys):
    """The same as data, to a file or to standard output alone."""
    assert main(['effects', 'line_loss', '--json', '-']) == 0
    one = json.loads(capsys.readouterr().out)
    assert one['schema'] == 'hst_drive/effects/1'
    assert one['effects'][0]['parameters']['laminar']['unit'] == 'Pa.s/m^3'
    assert main(['effects', '--json', str(tmp_path / 'all.json')]) == 0
    data = json.loads((tmp_path / 'all.json').read_text())
    assert [entry['id'] for entry in data['effects']] == list(catalogue())


def test_unknown_id(capsys):
    """One line, with the nearest id."""
    assert main(['effects', 'motor_leakige']) == 2
    assert capsys.readouterr().err == (
        "hst-drive: unknown effect 'motor_leakige'; did you mean 'motor_leakage'?\n")
