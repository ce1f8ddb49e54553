# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How numbers of a diagnosis are told."""
from hst_drive.diagnose.sentence import limits, nearly, odds, stated, times
from hst_drive.identify.evidence import Probability
import pytest


@pytest.mark.parametrize('verdict, quantities, told', [
    ('none', [], ''),
    ('none', ['pump.leakage'],
     'But pump.leakage sits at the limit of its tolerance: an effect that acts like it may be '
     'missing; these logs cannot tell.'),
    ('ambiguous', ['pump.leakage', 'motor.leakage', 'motor.inertia'],
     'But pump.leakage, motor.leakage and motor.inertia sit at the limits of their tolerances: '
     'an effect that acts like them may be missing as well.'),
    ('unknown', ['pump.leakage'],
     'Of this unit, pump.leakage sits at the limit of its tolerance.'),
])
def test_limits_are_told_in_one_sentence(verdict, quantities, told):
    assert limits(verdict, quantities) == told


def test_a_displacement_that_has_changed_may_be_another_machines():
    said = limits('missing_effect', ['motor.displacement'], commissioned=True)
    assert 'are these logs of the machine that was commissioned?' in said
    assert 'of the machine' not in limits('missing_effect', ['motor.displacement'])


def test_a_fall_near_the_noise_is_not_rounded_away():
    assert (times(1.04), times(1.0), times(15.82)) == ('1.04', '1.00', '15.8')


def test_probabilities_are_told_the_highest_first_and_crumbs_left_out():
    found = Probability(0.004, 0.3, ((('leak',), 0.6), (('drag', 'leak'), 0.096)))
    assert odds(found) == 'leak 0.60, unknown 0.30, drag + leak 0.10'
    assert odds(Probability(0.999, 0.001, ())) == 'none above 0.99'
    crumbs = tuple(((name,), 0.008) for name in 'abcde')
    assert odds(Probability(0.9, 0.06, crumbs)) == 'none 0.90, unknown 0.06, all others 0.04'
    assert stated(found._replace(calibrated=True)) == f'probability: {odds(found)}'
    assert stated(found) == f'probability, not calibrated for such logs: {odds(found)}'


@pytest.mark.parametrize('named, none, unknown, sets, told', [
    (['leak'], 0.05, 0.05, {'leak': 0.9}, ''),
    (['leak'], 0.0, 0.45, {'leak': 0.55}, 'something that is not listed is'),
    (['leak'], 0.0, 0.1, {'leak': 0.5, 'drag leak': 0.4},
     'drag and leak together are'),
    (['leak'], 0.3, 0.7, {}, ''),
    (['leak', 'drag'], 0.0, 0.1, {'leak': 0.5, 'drag': 0.4}, ''),
    (['leak', ''], 0.4, 0.1, {'leak': 0.5}, ''),
    ([], 0.1, 0.5, {'leak': 0.4}, 'leak alone is'),
    ([''], 0.5, 0.4, {'leak': 0.1}, 'something that is not listed is'),
    ([], 0.4, 0.6, {}, 'that nothing is missing is')])
def test_what_is_nearly_as_probable_is_told_but_for_what_is_named(
        named, none, unknown, sets, told):
    """Rivals, and the unit alone among them, are told already."""
    said = nearly(Probability(none, unknown, tuple(
        (tuple(names.split()), share) for names, share in sets.items())),
        {tuple(names.split()) for names in named})
    assert said == (f'But {told} nearly as probable.' if told else '')
