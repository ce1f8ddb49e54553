# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Linearised errors beside SciPy's bounded least squares on the whole, stacked problem."""
from hst_drive.identify.linearised import Linearised, squared_slopes
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest
from scipy.optimize import lsq_linear

FACTORS = 2     # of the unknowns, with priors


@given(seed=st.integers(0, 10_000), free=st.integers(0, 3), wide=st.floats(0.05, 5.0))
@settings(max_examples=60, deadline=None)
def test_a_step_is_bounded_least_squares_with_priors(seed, free, wide):
    random, count = np.random.default_rng(seed), FACTORS + free
    jacobian, vector = random.standard_normal((40, count)), random.standard_normal(count)
    residual = 3.0 * random.standard_normal(40)
    low, high = np.full(count, -wide), np.full(count, wide)
    prior = np.eye(count)[:FACTORS]
    exact = lsq_linear(np.vstack([jacobian, prior]),
                       -np.append(residual, vector[:FACTORS]), (low, high), tol=1e-12).x
    linear = Linearised(residual, jacobian, vector, FACTORS)
    assert linear.step(low, high) == pytest.approx(exact, abs=1e-5)
    left, rest = residual + jacobian @ exact, (vector + exact)[:FACTORS]
    assert linear.after(exact) == pytest.approx(left @ left + rest @ rest)
    assert linear.least() <= linear.after(exact) + 1e-6


def test_an_unknown_beside_others_is_one_of_them():
    random = np.random.default_rng(4)
    jacobian, residual = random.standard_normal((30, 3)), random.standard_normal(30)
    both = Linearised(residual, jacobian[:, :2], np.zeros(2), 2).beside(jacobian[:, 2])
    whole = Linearised(residual, jacobian, np.zeros(3), 2)
    assert both.normal == pytest.approx(whole.normal)
    assert both.gradient == pytest.approx(whole.gradient)
    assert both.least() == pytest.approx(whole.least())


def test_slopes_are_summed_within_clusters_and_squared_between_them():
    random = np.random.default_rng(4)
    jacobian, residual = random.standard_normal((30, 3)), random.standard_normal(30)
    cluster = random.integers(0, 5, 30)     # in any order
    exact = np.zeros((3, 3))
    for number in range(5):
        slope = sum(jacobian[k] * residual[k] for k in range(30) if cluster[k] == number)
        exact += np.outer(slope, slope)
    assert squared_slopes(jacobian, residual, cluster) == pytest.approx(exact)
