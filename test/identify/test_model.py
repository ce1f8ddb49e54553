# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Factors of a unit: of a commissioned machine leakages add up, all other quantities multiply."""
from hst_drive.identify.model import Model
from hypothesis import given, strategies as st
import pytest

SHARES = st.floats(-3.0, 1.5)


def scale(key, share, added):
    """Return the factor on a quantity."""
    return Model({}, {key: share}, added=added).scales[key]


@given(st.sampled_from(['pump.leakage', 'motor.displacement']), SHARES, st.booleans())
def test_a_factor_is_above_nothing_and_rises(key, share, added):
    assert 0.0 < scale(key, share, added) < scale(key, share + 1e-3, added)
    assert scale(key, 1e-6, added) == pytest.approx(1.0 + 1e-6, abs=1e-11)


@pytest.mark.parametrize('along', [0.1, 0.45])
def test_what_is_known_of_a_sum_or_a_product_stays_along_the_other_way(along):
    """Of a pump's and a hydromotor's leak without a case drain, of displacement and efficiency."""
    leaks = Model({}, {'pump.leakage': -along, 'motor.leakage': along}, added=True).scales
    assert sum(leaks.values()) == pytest.approx(2.0, abs=1e-12)
    torque = Model({}, {'motor.displacement': -along, 'motor.mechanical_efficiency': along},
                   added=True).scales
    assert torque['motor.displacement'] * torque['motor.mechanical_efficiency'] == pytest.approx(
        1.0, abs=1e-12)
