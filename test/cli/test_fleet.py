# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The verb fleet with a real diagnosis, and with logs that are none."""
import json

from hst_drive import cli
from hst_drive.bag import write_csv
import pytest

from ..measure.synthetic import record


@pytest.mark.needs_numba
def test_a_small_fleet(tmp_path, capsys):
    """One machine leaks, one log is broken: two rows, one with an answer; then nothing again."""
    folder = tmp_path / 'fleet' / 'rig_1' / '2026-02-03'
    folder.mkdir(parents=True)
    for number, name in enumerate(('one', 'two', 'holdout')):
        write_csv(folder / f'{name}.csv', record(40 + number, duration=20.0, effects={
            'motor_leakage': {'conductance': 4e-12}}))
    broken = tmp_path / 'fleet' / 'rig_2'
    broken.mkdir()
    (broken / 'log.csv').write_text('time[s],motor_speed[rpm]\n0,fast\n')
    target, page = tmp_path / 'fleet.json', tmp_path / 'fleet.html'
    call = ['fleet', str(tmp_path / 'fleet'), '--results', str(tmp_path / 'kept'),
            '--json', str(target), '-o', str(page), '--workers', '1']
    assert cli.main(call) == 0
    told = capsys.readouterr()
    assert told.out.startswith('2 machines: 1 fault, 1 not judged. 1 campaign could not')
    result = json.loads(target.read_text())
    good, bad = result['rows']
    assert good['diagnosis']['effects'][0]['id'] == 'motor_leakage'
    assert good['diagnosis']['effects'][0]['parameters']['conductance']['value'] == (
        pytest.approx(4e-12, rel=0.2))
    assert bad['status'] == 'failed' and "'motor_speed" in bad['reason']
    assert 'motor_leakage' in page.read_text()
    # Again: nothing is read anew, and the answer is the same.
    before = result['rows']
    assert cli.main(call) == 0
    assert '2 of 2 campaigns are done already' in capsys.readouterr().err
    assert json.loads(target.read_text())['rows'] == before


def test_nothing_to_do(tmp_path, capsys):
    assert cli.main(['fleet', str(tmp_path), '--results', str(tmp_path / 'kept')]) == 2
    assert 'no logs' in capsys.readouterr().err
    assert not (tmp_path / 'kept').exists()
