# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Rock that is rougher, and smoother in time, than a lag of one pole makes it."""
from test.diagnose.unseen import unseen

from bench.campaigns import as_runs
from hst_drive.identify import weigh
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.evidence import CREDIBLE
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
def test_rough_rock_makes_no_flexible_shaft_likelier(tmp_path, monkeypatch):
    """Its replay follows the rock by the measured speed; this machine is healthy."""
    search = Search(Campaign(*unseen(8230, tmp_path)), ('shaft_compliance', 'speed_sensor_lag'))
    lag = search.refine(search.single('speed_sensor_lag'))
    both = search.refine(search.extend(lag)[0])
    assert not search.unexplained(lag) and not search.asked(lag, both)
    assert weigh.log_odds(search, [lag, both])[1] < CREDIBLE
    monkeypatch.setattr(weigh, '_over_own', lambda _, fit: fit.errors)
    assert weigh.log_odds(search, [lag, both])[1] > CREDIBLE, 'over the common floors'
