# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What explains the recordings alike is told beside what was found, whichever came first."""
from bench.campaigns import as_runs, STANDARD
from hst_drive.diagnose.unlisted import unlisted_replacement
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import fit, PATIENT
from hst_drive.identify.model import Model
from hst_drive.identify.search import Search
from hst_drive.identify.standing import alternatives
from hst_drive.rig import default_rig
import pytest

from ..measure.synthetic import record
from ..truth import make_campaign


@pytest.mark.needs_numba
@pytest.mark.parametrize('form, low, high', [('orifice', 0.4, 0.7), ('laminar', 0.85, 1.15)])
def test_another_form_of_an_effect_is_no_other_effect(form, low, high):
    """A pump that leaks as through an orifice leaks; its exponent tells the form."""
    made = make_campaign(75, {'pump_leakage': {'size': 1.2, 'form': form}})
    search = Search(Campaign(*as_runs(made)), ('motor_leakage', 'pump_leakage'))
    best = search.refine(search.single('pump_leakage'))
    assert low < best.fit.model.effects['pump_leakage']['exponent'] < high
    assert 'pump_orifice_leakage' not in search.campaign.candidates()
    assert alternatives(search, best, 'pump_leakage') == ()


@pytest.mark.needs_numba
def test_without_a_flow_meter_both_leaks_are_told_whatever_the_form():
    """Neither may win because its formula alone can bend."""
    made = make_campaign(771004, {'motor_leakage': {'size': 0.9, 'form': 'mixed'}}, channels=tuple(
        name for name in STANDARD if name != 'motor_inlet_flow'))
    search = Search(Campaign(*as_runs(made)), ('motor_leakage', 'pump_leakage'))
    for first, second in (('motor_leakage', 'pump_leakage'), ('pump_leakage', 'motor_leakage')):
        best = search.refine(search.single(first))
        assert second in alternatives(search, best, first)


@pytest.mark.needs_numba
def test_beside_others_another_form_of_an_effect_may_be_right():
    """Oil that a pump compresses; alone, a curve that is off seemed the hydromotor's."""
    hidden = {'compressibility_flow': {'volume_ratio': 6.0, 'dead_share': 0.5, 'in_motor': 0.0},
              'pump_command_offset': {'offset': 0.15}}
    runs = [record(seed, effects=hidden, leave_out=('motor_inlet_flow',), duration=60.0)
            for seed in (81, 82, 83)]
    search = Search(Campaign(default_rig(), runs), (*hidden,))
    start = Model({**hidden, 'compressibility_flow': {
        'volume_ratio': 6.0, 'dead_share': 0.2, 'in_motor': 1.0}})
    stuck = search.candidate((*hidden,), fit(
        search.campaign, start, iterations=PATIENT, refresh=True))
    assert {*unlisted_replacement(search, stuck, {})} == {'compressibility_flow'}
    found = search.anew(stuck, ['compressibility_flow'])
    compressed = found.fit.model.effects['compressibility_flow']
    assert compressed['in_motor'] == 0.0
    assert compressed['volume_ratio'] == pytest.approx(6.0, rel=0.1)
    assert unlisted_replacement(search, found, {}) == {}
