# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The same drive recorded otherwise gets the same answer: a small part of the benchmark."""
from bench import metamorphic
import pytest

pytestmark = pytest.mark.needs_numba
LEAK = 1    # of HIDDEN


@pytest.fixture(scope='module', autouse=True)
def short(monkeymodule):
    monkeymodule.setattr(metamorphic, 'SECONDS', 25.0)


@pytest.fixture(scope='module')
def monkeymodule():
    with pytest.MonkeyPatch.context() as patch:
        yield patch


@pytest.fixture(scope='module')
def usual(short):
    return metamorphic.answer(LEAK, 'as it is')


def test_the_usual_answer_is_the_truth(usual):
    assert usual['verdict'] == 'missing_effect' and usual['named'] == ['motor_leakage']


@pytest.mark.parametrize('change', ['25 Hz', '30 % of rows lost', 'cut in two', 'other units',
                                    'half a noise more', 'bags'])
def test_the_answer_stays(usual, change):
    row = metamorphic.answer(LEAK, change)
    assert metamorphic.agrees(usual, row), row


def test_another_answer_is_seen():
    usual = {'verdict': 'missing_effect', 'named': ['a'], 'sets': [['a', 'b']]}
    for verdict, named, sets, same in (
            ('missing_effect', ['a'], [['a']], True), ('ambiguous', ['b'], [['b', 'c']], True),
            ('none', [], [], False), ('unknown', ['a'], [['a']], False),
            ('missing_effect', ['c'], [['c']], False),
            ('missing_effect', ['a', 'd'], [['a'], ['d']], False)):
        assert metamorphic.agrees(usual, {
            'verdict': verdict, 'named': named, 'sets': sets}) is same
