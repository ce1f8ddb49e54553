# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The demo, as a newcomer sees it: one real run with real nodes, and refusals."""
import json
import os
from pathlib import Path
import re
import subprocess
import sys

from hst_drive import cli
from hst_drive.bag import read_log
from hst_drive.cli import demo
from hst_drive.load import load_scenario
from hst_drive.nodes.settings import parse_effects
from hst_drive.rig import load_rig
import numpy as np
import pytest

TREE = Path(__file__).resolve().parents[2]


@pytest.fixture(scope='module')
def shown(tmp_path_factory):
    """Return the folder of a real demo, what it printed and what it told meanwhile."""
    pytest.importorskip('rclpy')
    place = tmp_path_factory.mktemp('demo')
    path = os.pathsep.join(filter(None, [str(TREE), os.environ.get('PYTHONPATH')]))
    done = subprocess.run([sys.executable, '-m', 'hst_drive', 'demo'], cwd=place, timeout=900,
                          env={**os.environ, 'PYTHONPATH': path}, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return place / 'hst_drive_demo', done.stdout, done.stderr


@pytest.mark.slow
@pytest.mark.needs_numba
class TestTheDemo:
    """All four steps, from the nodes to the adopted effect."""

    def test_it_finds_what_it_has_hidden(self, shown):
        """The effect of the plant is named, its size lies in the interval that is stated."""
        folder, out, _ = shown
        (hidden, values), = parse_effects([demo._HIDDEN]).items()
        found, = json.loads((folder / 'diagnosis.json').read_text())['effects']
        assert found['id'] == hidden and f'lacks {hidden}' in out
        for name, value in values.items():
            assert found['parameters'][name]['low'] < value < found['parameters'][name]['high']
        assert load_rig(folder / 'rig.yaml').effects.keys() == {hidden}

    def test_it_ends_with_a_fit(self, shown):
        """The first comparison fails, the second, with the effect, is down to the noise."""
        _, out, _ = shown
        before, after = out.split('3. What is missing?')
        assert 'does not explain the measurements' in before
        assert 'explains the measurements down to the noise' in after.split(
            '4. The same comparison with it')[1]

    def test_russell_errors_are_below_those_of_the_paper(self, shown):
        """Speed below 3 %, pressure below 3.1 %, printed beside the paper's."""
        ends = re.findall(r'speed ([\d.]+) %, pressure ([\d.]+) %', shown[1])
        assert len(ends) == 2
        assert all(0 < float(speed) < 3.0 and 0 < float(pressure) < 3.1
                   for speed, pressure in ends)

    def test_the_table_of_rocks_is_what_the_bag_holds(self, shown):
        """Every rock that was drilled has a row; the speed is held at 100 rpm in each."""
        folder, out, _ = shown
        rocks = load_scenario('layered_ground').load.torque_profile.layers
        rows = re.findall(r'^(\w+) +([\d.]+) to ([\d.]+) +(\d+) +([\d.]+) +([\d.]+) +([\d.]+)',
                          out, re.MULTILINE)
        assert [row[0] for row in rows] == [layer.rock for layer in rocks][:len(rows)]
        assert len(rows) >= 4
        log = read_log(folder / 'layered_ground')
        for _, start, end, torque, pressure, command, speed in rows:
            part = (log.time >= float(start)) & (log.time < float(end))
            assert float(torque) == pytest.approx(np.mean(log['load_torque'][part]), abs=2)
            assert float(pressure) == pytest.approx(
                np.mean(log['pump_outlet_pressure'][part]) / 1e5, abs=1)
            assert float(command) == pytest.approx(np.mean(log['pump_command'][part]), abs=0.05)
            assert float(speed) == pytest.approx(100.0, abs=1.0)

    def test_it_says_where_things_are_and_how_to_go_on(self, shown):
        """The bags exist; the commands at its end work as they are printed."""
        folder, out, err = shown
        assert {path.name for path in folder.iterdir()} == {
            'layered_ground', 'commissioning', 'diagnosis.json', 'rig.yaml'}
        command = next(line for line in out.splitlines() if ' adopt ' in line).split()
        assert command == ['hst-drive', 'adopt', 'diagnosis.json', '-o', 'rig.yaml']
        assert str(folder.name) in out and 'Traceback' not in err
        target = folder.parent / 'again.yaml'
        assert cli.main(['adopt', str(folder / 'diagnosis.json'), '-o', str(target)]) == 0
        assert load_rig(target).effects == load_rig(folder / 'rig.yaml').effects


def test_it_takes_another_folder_when_there_is_one(tmp_path, monkeypatch):
    """A second demo leaves the first alone."""
    monkeypatch.chdir(tmp_path)
    assert demo._free('hst_drive_demo') == Path('hst_drive_demo')
    (tmp_path / 'hst_drive_demo').mkdir()
    (tmp_path / 'hst_drive_demo_2').touch()
    assert demo._free('hst_drive_demo') == Path('hst_drive_demo_3')


def test_a_folder_that_is_there_is_refused(tmp_path, capsys):
    """Nothing is started, nothing is overwritten."""
    assert cli.main(['demo', '-o', str(tmp_path)]) == 2
    out, err = capsys.readouterr()
    assert not out and err.count('\n') == 1 and str(tmp_path) in err
    assert not list(tmp_path.iterdir())
