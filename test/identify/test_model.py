# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Factors of a unit: leakages add up, all other quantities multiply."""
from hst_drive.identify.model import factor_of, Model, share_of
from hypothesis import given, strategies as st
import pytest

SHARES = st.floats(-3.0, 1.5)
KEYS = st.sampled_from(['pump.leakage', 'motor.leakage', 'motor.displacement'])


@given(KEYS, SHARES)
def test_a_factor_is_above_nothing_and_has_one_share(key, share):
    assert factor_of(key, share) > 0.0
    assert share_of(key, factor_of(key, share)) == pytest.approx(share, abs=1e-9)


@given(KEYS, SHARES)
def test_a_small_share_more_is_as_much_of_the_factor_at_the_datasheet(key, share):
    assert factor_of(key, 1e-6) == pytest.approx(1.0 + 1e-6, abs=1e-11)
    assert factor_of(key, share + 1e-3) > factor_of(key, share)


@pytest.mark.parametrize('along', [0.1, 0.45])
def test_what_is_known_of_a_sum_or_a_product_stays_along_the_other_way(along):
    """Of a pump's and a hydromotor's leak without a case drain, of displacement and efficiency."""
    leaks = Model({}, {'pump.leakage': -along, 'motor.leakage': along}).scales
    assert sum(leaks.values()) == pytest.approx(2.0, abs=1e-12)
    torque = Model({}, {'motor.displacement': -along, 'motor.mechanical_efficiency': along}).scales
    assert torque['motor.displacement'] * torque['motor.mechanical_efficiency'] == pytest.approx(
        1.0, abs=1e-12)
