# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The notebooks, and the lines of the README, run as they stand."""
import json
from pathlib import Path
import re
import subprocess
import sys

import hst_drive as hd
import pytest

TOP = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((TOP / 'docs' / 'notebooks').glob('*.ipynb'))


@pytest.mark.parametrize('path', NOTEBOOKS, ids=lambda path: path.stem)
def test_kept_without_output(path):
    """What a run leaves in a notebook would only get old."""
    book = json.loads(path.read_text(encoding='utf-8'))
    assert book['nbformat'] == 4
    assert not any(cell.get('outputs') or cell.get('execution_count') for cell in book['cells'])


@pytest.mark.needs_numba
@pytest.mark.parametrize('name, expected', [
    ('which_effect_is_missing', 'motor_leakage'), ('your_own_effect', 'stiff_seal')])
def test_finds_what_was_hidden(name, expected):
    """A process of its own: an effect that is registered stays until it ends."""
    done = subprocess.run(
        [sys.executable, '-m', 'test.api.run_notebook', f'docs/notebooks/{name}.ipynb'],
        cwd=TOP, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert expected in found['effects'], found


@pytest.mark.needs_numba
def test_lines_of_the_readme(tmp_path, monkeypatch, capsys):
    """From a pandas frame to an adopted rig in at most ten lines."""
    pytest.importorskip('pandas')
    block, = re.findall('```python\n(.*?)```', (TOP / 'README.md').read_text(encoding='utf-8'),
                        re.DOTALL)
    assert len(block.splitlines()) <= 10
    assert block in (TOP / 'docs' / 'python.md').read_text(encoding='utf-8')
    monkeypatch.chdir(tmp_path)
    log = hd.simulate('commissioning', effects={'motor_leakage': {'conductance': 2e-12}})
    log.between(0.0, 30.0).save('log.csv')
    names = {}
    exec(block, names)
    assert 'motor_leakage' in capsys.readouterr().out
    assert hd.load_rig('rig.yaml').effects['motor_leakage']['conductance'] == pytest.approx(
        2e-12, rel=0.15)
