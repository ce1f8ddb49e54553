# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The verb ``margins``: the shipped controller keeps its margins over the rig's range."""
import json
import math

from hst_drive.cli import main
import pytest


def margins(tmp_path, *arguments):
    """Run the verb and return its JSON."""
    target = tmp_path / 'margins.json'
    assert main(['margins', *arguments, '--json', str(target)]) == 0
    return json.loads(target.read_text())


def test_shipped_gains_over_the_operating_range(tmp_path, capsys):
    """45 deg and 20 dB everywhere, and the loop gain at the resonance below -20 dB."""
    result = margins(tmp_path)
    assert len(result['points']) >= 15
    for point in result['points']:
        entry = point['margins']
        assert entry['stable']
        assert math.degrees(entry['phase_margin']) > 45.0
        assert entry['gain_margin'] > 10.0
        assert entry['resonance_gain'] < 0.1
    assert 'Well damped' in capsys.readouterr().out


def test_resonance_is_where_the_balances_put_it(tmp_path):
    """By hand: sqrt(eta K D^2 / (V J)) at the published point, 9.1 Hz, table slope included."""
    point = margins(tmp_path, '--speed', '100', '--load', '241.1')['points'][0]
    by_hand = math.sqrt(0.885 * 1.2e9 / 0.9e-3 / 0.35) * 195e-6 / (2 * math.pi)
    assert point['load_torque'] == pytest.approx(241.1, rel=1e-4)
    assert point['margins']['resonance'] == pytest.approx(by_hand, rel=0.03)


def test_wild_gains_are_called_unstable(tmp_path, capsys):
    result = margins(tmp_path, '--kp', '1', '--load', '100')
    assert not any(point['margins']['stable'] for point in result['points'])
    assert 'Unstable' in capsys.readouterr().out


def test_chosen_gains_are_well_damped(tmp_path, capsys):
    result = margins(tmp_path, '--choose', '--speed', '50', '150', '--load', '50', '250')
    assert result['chosen']['ki'] > result['ki']
    assert capsys.readouterr().out.count('Well damped') == 2


@pytest.mark.parametrize('arguments', (
    ['--kp', 'nan'], ['--ki=-1'], ['--speed', '0'], ['--load', '5000'], ['--delay=-1']))
def test_wrong_input_is_one_line(arguments, capsys):
    assert main(['margins', *arguments]) == 2
    assert capsys.readouterr().err.strip().splitlines()[-1].startswith('hst-drive: ')
