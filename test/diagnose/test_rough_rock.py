# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Rock that is rougher, and smoother in time, than a lag of one pole makes it."""
from bench.campaigns import as_runs
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.search import Search
import numpy as np
import pytest
from scipy.signal import lfilter

from ..truth import make_campaign, profiles


@pytest.mark.needs_numba
@pytest.mark.parametrize('seed', [51, 52, 53])
def test_smooth_rock_is_no_missing_physics(monkeypatch, seed):
    def rock(count, random, size):
        pole = np.exp(-2.0 * np.pi * 1.0 * 1e-3)
        found = lfilter([1.0], [1.0, -2.0 * pole, pole**2], random.standard_normal(count))
        return 3.0 * found / found.std()

    monkeypatch.setattr(profiles, 'roughness', rock)
    search = Search(Campaign(*as_runs(make_campaign(seed))), ())
    assert search.unexplained(search.baseline) == {}


@pytest.mark.needs_numba
@pytest.mark.parametrize('size, least, most', [(5.0, 0.7, 1.0), (0.0, -0.1, 0.3)])
def test_a_flexible_shaft_is_lent_what_rough_rock_makes(monkeypatch, size, least, most):
    """Its replay follows the rock by the measured speed: that gain is no sign of a shaft."""
    def rock(count, random, _):
        return size * lfilter([0.25], [1.0, -0.97], random.standard_normal(count))

    monkeypatch.setattr(profiles, 'roughness', rock)
    search = Search(Campaign(*as_runs(make_campaign(51, {}, rate_hz=50.0))), ())
    lent = search._lent(search.baseline, search.single('shaft_compliance'))
    assert least < lent['motor_speed'] < most
    assert search._lent(search.baseline, search.single('pump_lag')) == {}
