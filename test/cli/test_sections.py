# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The verb compare on logs that are cut into sections."""
import json

from hst_drive import cli
from hst_drive.bag import write_csv
from hst_drive.measure.run import Run
import numpy as np
import pytest

from ..measure.synthetic import record


@pytest.mark.needs_numba
def test_a_log_in_sections(tmp_path, capsys):
    """Says how it was cut, and what cannot be cut."""
    log = tmp_path / 'long.csv'
    write_csv(log, record(3, duration=130.0, rate=20))
    target = tmp_path / 'out.json'
    assert cli.main(['compare', str(log), '--sections', '1', '--json', str(target)]) == 0
    assert 'compared in 2 sections of 1 min, each replayed from 30 s before' in (
        capsys.readouterr().out)
    cut = json.loads(target.read_text())['by_log'][0]['sections']
    assert (cut['count'], cut['seconds'], cut['samples']) == (2, 60.0, 2600)
    for more, minutes, told in ((['--closed-loop'], '1', 'leave it out'),
                                ([str(log)], '1', 'give it alone'), ([], '0', 'at least 1 min')):
        assert cli.main(['compare', *more, str(log), '--sections', minutes]) == 2
        assert told in capsys.readouterr().err


@pytest.mark.needs_numba
@pytest.mark.parametrize('first, last, told', [
    (0, 70, '0.00 to 60.00 s'), (30, 130, '60.00 to 120.00 s')])
def test_a_section_without_a_command_is_left_out(tmp_path, capsys, first, last, told):
    """The controller began late, or stood for a while: it is the whole drive all the same."""
    log, target = tmp_path / 'long.csv', tmp_path / 'out.json'
    run = record(3, duration=250.0, rate=20)
    run.channels['pump_command'][20 * first:20 * last] = np.nan
    write_csv(log, run)
    assert cli.main(['compare', str(log), '--sections', '1', '--json', str(target)]) == 0
    said = json.loads(target.read_text())['by_log'][0]
    assert said['sections']['count'] == 3 and 'pump_outlet_pressure' in said['signals']
    assert f'{told} (pump_command missing)' in capsys.readouterr().out
    run.channels['pump_command'][20 * first:20 * (first + 180)] = np.nan
    write_csv(log, run)
    assert cli.main(['compare', str(log), '--sections', '1']) == 2
    assert 'pump_command is missing in 3600 of 5000 rows' in capsys.readouterr().err


@pytest.mark.needs_numba
def test_what_is_doubtful_is_told_of_sections_too(tmp_path, capsys):
    run = record(3, duration=130.0, rate=20)
    write_csv(tmp_path / 'long.csv', Run('long', run.time, {
        **run.channels, 'motor_inlet_flow': run['motor_inlet_flow'] / 60.0}))
    said = []
    for more in ([], ['--sections', '1']):
        assert cli.main(['compare', str(tmp_path / 'long.csv'), *more]) == 0
        said.append([line for line in capsys.readouterr().err.splitlines()
                     if 'L/s as L/min' in line])
    assert len(said[0]) == 1 and said[0] == said[1]
