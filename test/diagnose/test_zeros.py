# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Zeros of gauges, on a closed circuit of the independent generator: learnt, kept, and told."""
from dataclasses import replace
from test.measure.test_circuit import campaign as closed_campaign

from hst_drive.diagnose.commission import commission
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.result import UNIT_ALONE
from hst_drive.identify.fit import fit
from hst_drive.identify.intervals import intervals
from hst_drive.identify.model import Model
from hst_drive.identify.part import campaign_of
from hst_drive.rig import parse_rig
import pytest
import yaml

from .machines import BENCH, braked

OFF = 0.3e5         # Pa, which is twice what these gauges scatter


def off(run, **pascals):
    """Return a log whose gauges read beyond the truth."""
    return replace(run, channels={**run.channels, **{
        name: run[name] + value for name, value in pascals.items()}})


@pytest.fixture(scope='module')
def healthy(tmp_path_factory):
    """Return the rig file and the logs of a healthy machine whose gauges are right."""
    folder = tmp_path_factory.mktemp('zeros')
    _, logs, truth = closed_campaign(folder, '--circuit', 'closed', '--kind', 'none',
                                     '--seed', '100')
    assert not truth['effects']
    return yaml.safe_load((folder / '0000' / 'rig.yaml').read_text()), logs


def test_zeros_are_learnt_and_kept_with_the_machine(healthy):
    made, logs = healthy
    zeros = {'line_a_pressure': -OFF, 'line_b_pressure': OFF}
    found = commission(made, 'rig.yaml', [off(logs[name], **zeros) for name in (
        'drilling', 'sweep')])
    unit = parse_rig(found.rig, 'unit.yaml')
    # The charge gauge scatters by 0.1 bar; by what it is off itself, both seem to be off.
    assert {name: unit.zeros[name] for name in zeros} == pytest.approx(zeros, abs=0.1e5)
    assert unit.zeros['line_b_pressure'] - unit.zeros['line_a_pressure'] == pytest.approx(
        2.0 * OFF, abs=0.05e5)
    assert all(unit.fingerprint.zeros[name][1] < 0.5 * OFF for name in zeros)
    # A leak goes with the zeros of both lines: known together, they are known better.
    assert unit.fingerprint.correlation['line_a_pressure', 'line_b_pressure'] != 0.0
    answer = diagnose(unit, [off(logs['reverse'], **zeros)])
    assert answer.verdict == 'none'
    assert max(abs(entry.value) for entry in answer.zeros
               if entry.channel in zeros) < 0.3 * OFF


@pytest.mark.parametrize('bar, verdict', [(0.8, 'none'), (2.0, 'ambiguous')])
def test_zeros_at_their_limits_are_told_beside_a_gauge_that_is_off(bar, verdict):
    """Four sigma of a gauge's zero can be shared out: three there, three on the torque sensor."""
    sensors = {**BENCH['sensors'],
               'motor_inlet_pressure': {'noise_std_bar': 0.05, 'zero_std_bar': 0.5}}
    bench = parse_rig({**BENCH, 'sensors': sensors}, 'bench.yaml')
    found = diagnose(bench, [off(braked(1, 50.0), motor_inlet_pressure=bar * 1e5)])
    assert found.verdict == verdict
    for entry in found.effects:
        assert entry.id == 'pressure_sensor_bias' and UNIT_ALONE in entry.indistinguishable_from
        low, high = entry.parameters['bias'][1:3]
        assert low < bar * 1e5 < high and 'the zero of motor_inlet_pressure' in found.sentence


def test_a_stated_zero_takes_the_place_of_the_noise(healthy):
    made, logs = healthy
    made['sensors']['line_a_pressure']['zero_std_bar'] = 1.2
    made['sensors']['case_drain_flow']['zero_std_L_min'] = 0.1
    zeros = campaign_of(parse_rig(made, 'rig.yaml'), [logs['drilling']]).zeros
    assert zeros['line_a_pressure'] == pytest.approx(1.2e5)
    assert zeros['case_drain_flow'] == pytest.approx(0.1e-3 / 60)
    noise = made['sensors']['line_b_pressure']['noise_std_bar']
    assert zeros['line_b_pressure'] == pytest.approx(noise * 1e5, rel=0.2)
    assert 'motor_speed' not in zeros


def test_where_an_effect_is_the_zero_it_is_all_of_it(healthy):
    made, logs = healthy
    campaign = campaign_of(parse_rig(made, 'rig.yaml'), [
        off(logs[name], line_a_pressure=5e5) for name in ('drilling', 'sweep')])
    found = fit(campaign, Model({'pressure_sensor_bias': {'bias': 2e5}},
                                {}, {'line_a_pressure': 1e5}), iterations=8, refresh=True)
    assert 'line_a_pressure' not in found.model.zeros
    low, high = intervals(campaign, found)['pressure_sensor_bias', 'bias']
    assert low < 5e5 < high and high - low < 1.2e5
