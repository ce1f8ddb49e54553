# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a *none* is worth: units at their limits, and balances that the logs do not close."""
from test.diagnose.unseen import unseen
from test.truth import make_campaign
from test.truth.sensors import STANDARD

from bench.campaigns import as_runs
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.next_test import of_diagnosis
from hst_drive.diagnose.result import as_json
from hst_drive.identify.campaign import ELSEWHERE
import pytest

pytestmark = pytest.mark.needs_numba


def test_a_unit_at_its_limits_hides_no_effect_that_is_far_likelier(tmp_path):
    """A worn pump on another author's machine; three tolerances of its leakage take it up."""
    found = diagnose(*unseen(8001, tmp_path))
    assert found.verdict == 'ambiguous'
    effect, = found.effects
    assert effect.id == 'pump_leakage' and 'none' in effect.indistinguishable_from
    assert 'pump.leakage' in found.sentence.split(', or the model')[0]
    assert found.next_test.separates == ('pump_leakage', 'none')
    assert found.next_test.what.startswith('measure pump.leakage of this unit by itself')
    # A test of the drive can tell the effects apart, not the unit from them.
    assert of_diagnosis(as_json(found), 'd.json').names == (
        ('pump_leakage',), ('swash_compliance',), ('compressibility_flow',))


def test_beside_an_effect_a_unit_at_its_limits_hides_none_either():
    """A gear that takes its share; with the loading pump at its limit the valve explains all."""
    rig, runs, held = as_runs(make_campaign(
        62, {'prv_cracking': 1.0, 'gearbox_loss': 0.9}, rate_hz=50.0, duration=30.0))
    found = diagnose(rig, runs, held)
    valve, gear = found.effects
    assert (found.verdict, valve.id, gear.id) == ('ambiguous', 'prv_cracking', 'gearbox_loss')
    assert not valve.indistinguishable_from and gear.indistinguishable_from == ('none',)
    assert found.sentence.startswith('The model lacks prv_cracking ')
    assert '(loading.pump_mechanical_efficiency), or the model lacks also gearbox_loss' \
        in found.sentence
    assert found.next_test.separates == ('gearbox_loss', 'none')


def test_a_lag_beyond_its_tolerance_is_named_beside_what_hides_it():
    """
    It shows in one quick step; with the lag at its limit nothing seems to be left.

    At 0.34 of typical the evidence is not enough for that, and the limit is told.
    """
    rig, runs, held = as_runs(make_campaign(
        41500004, {'pump_speed_droop': 1.33, 'pump_lag': 0.42}, rate_hz=50.0,
        rig_seed=41500004, duration=25.0))
    found = diagnose(rig, runs, held)
    assert found.verdict in ('missing_effect', 'ambiguous')
    assert {entry.id for entry in found.effects} == {'pump_speed_droop', 'pump_lag'}


def test_none_tells_first_what_it_could_not_have_seen():
    channels = tuple(name for name in STANDARD if name != 'load_torque')
    rig, runs, held = as_runs(make_campaign(45, {}, channels=channels))
    found = diagnose(rig, runs, held)
    assert found.verdict == 'none'
    first = found.sentence.partition('The model')[0]
    assert first.startswith(
        'Nothing is missing, as far as these logs show. They show the balances of ')
    assert 'load torque' not in first and 'effects from the sizes below on' in first
    assert 'torque_sensor_scale' in found.not_observable
    # What no drive of this circuit has is not worth a word there.
    assert all((name in first) != (reason == ELSEWHERE)
               for name, reason in found.not_observable.items())
    assert found.not_observable['cross_port_leakage'] == ELSEWHERE
