# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Effects of other packages, found as the documentation says."""
import os
from pathlib import Path
import re
import subprocess
import sys

import hst_drive
from hst_drive.effects import catalogue
import pytest

ROOT = Path(hst_drive.__file__).parents[1]
DOCUMENT = ROOT / 'docs' / 'your_own_effect.md'
RUN = """
import numpy as np
from hst_drive.model import Drive
from hst_drive.rig import default_rig
n = 150
inputs = {'pump_command': np.full(n, 5.0), 'pprv_command': np.full(n, 3.0)}
pressure = [Drive(default_rig(), effects).simulate(0.02 * np.arange(n), inputs)[
    'pump_outlet_pressure'][-1] for effects in ({}, {'stiff_seal': {'torque': 5.0}})]
print(pressure[1] - pressure[0])
"""


def installed(folder, name, files, entry_points):
    """Put a package where Python and its metadata are found; return the environment for that."""
    info = folder / f'{name.replace("-", "_")}-1.0.dist-info'
    info.mkdir(parents=True)
    (info / 'METADATA').write_text(f'Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n')
    (info / 'entry_points.txt').write_text('[hst_drive.effects]\n' + entry_points)
    for path, text in files.items():
        (folder / path).write_text(text)
    return {**os.environ, 'HST_DRIVE_CACHE': str(folder / 'cache'),
            'PYTHONPATH': os.pathsep.join([str(folder), str(ROOT)])}


def python(environment, *arguments):
    """Run a fresh Python."""
    return subprocess.run([sys.executable, *arguments], env=environment, text=True,
                          capture_output=True, timeout=300, check=False)


@pytest.fixture(name='documented')
def documented_package(tmp_path):
    """Install the example of the documentation, word for word."""
    if not DOCUMENT.exists():
        pytest.skip('not run from the source tree')
    code, project = re.findall(r'```(?:python|toml)\n(.*?)```', DOCUMENT.read_text('utf-8'),
                               re.DOTALL)
    assert len(code.strip().splitlines()) <= 20
    line, = re.findall(r'^(\w+) = "(\w+:\w+)"$', project, re.MULTILINE)
    return installed(tmp_path, 'my-rig', {'seal.py': code}, ' = '.join(line) + '\n')


def test_documented_example(documented):
    """It is listed with its package, explained, and moves the drive."""
    listing = python(documented, '-m', 'hst_drive', 'effects')
    assert listing.returncode == 0 and not listing.stderr
    line, = (line for line in listing.stdout.splitlines() if line.startswith('stiff_seal'))
    assert 'torque' in line and line.endswith('(package my-rig)')
    explained = python(documented, '-m', 'hst_drive', 'effects', 'stiff_seal')
    assert 'T = torque * (1 + exp(-|w|)) * 323.15/T_oil' in explained.stdout
    # Interpreted: one compilation of the whole drive is enough for all tests.
    moved = python({**documented, 'NUMBA_DISABLE_JIT': '1'}, '-c', RUN)
    # 5 N.m over some 0.87 of 195 cc/rev.
    assert float(moved.stdout) == pytest.approx(5.0 / 0.87 / 31.04e-6, rel=0.1), moved.stderr


@pytest.mark.needs_numba
def test_documented_example_compiles(documented):
    """The compiled drive has it, too."""
    moved = python(documented, '-c', RUN)
    assert float(moved.stdout) == pytest.approx(5.0 / 0.87 / 31.04e-6, rel=0.1), moved.stderr


GOOD = """
from hst_drive.effects import Effect, Parameter
def helper(x): return x
def term(pressure, size): return size * pressure
def wrong(pressure, size): return size * helper(pressure)
def declare(name, function=term, slot='motor_flow_loss'):
    return Effect(id=name, title='t', slot=slot, function=function, equation='e',
                  parameters=(Parameter('size', '1', 0.0, 1.0, 0.5, 'm'),), telltale='t',
                  source='s', shows_in=('motor_speed',))
"""


@pytest.mark.parametrize('code, reason', [
    (None, 'No module named'),
    ('1 / 0', 'division by zero'),
    (f'{GOOD}EFFECT = term', 'expected an hst_drive.effects.Effect, found function'),
    (f'{GOOD}EFFECT = declare("pump_lag")', "there is an effect 'pump_lag' already"),
    (f'{GOOD}EFFECT = declare("mine", wrong)', "its function uses 'helper'"),
    (f'{GOOD}EFFECT = declare("mine", slot="motor")', "unknown slot 'motor'"),
    ('raise SystemExit(3)', '3'),
])
def test_broken_package_is_left_out(tmp_path, code, reason):
    """One line names the package and what is wrong; the rest goes on."""
    files = {} if code is None else {'broken_rig.py': code}
    environment = installed(tmp_path, 'broken-rig', files, 'mine = broken_rig:EFFECT\n')
    listing = python(environment, '-m', 'hst_drive', 'effects')
    assert listing.returncode == 0
    line, = listing.stderr.splitlines()
    assert line.startswith("effect 'mine' of package 'broken-rig' is left out: ")
    assert reason in line
    assert len(listing.stdout.splitlines()) == 2 + len(catalogue())
    if code is None:
        switched = python(environment, '-c', 'from hst_drive.model import Drive; from hst_drive.'
                          'rig import default_rig; Drive(default_rig(), {"mine": {}})')
        last = switched.stderr.splitlines()[-1]
        assert "unknown effect 'mine'; effect 'mine' of package 'broken-rig' is left" in last
