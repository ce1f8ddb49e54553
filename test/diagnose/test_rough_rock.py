# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Rock that is rougher, and smoother in time, than a lag of one pole makes it."""
from test.diagnose.unseen import unseen

from bench.campaigns import as_runs
from hst_drive.diagnose.causes import one_cause
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


@pytest.mark.needs_numba
@pytest.mark.parametrize('seed', [51, 54])
def test_slow_rows_of_one_set_point_make_no_number_of_the_datasheet_wrong(monkeypatch, seed):
    """
    The load swings between the rows, so that a stronger damping looks better.

    The unit's factor of it sits at its limit, but all is below the floor.
    """
    def rock(count, random, size):
        found = random.standard_normal(count)
        for constant in (0.12, 0.036):
            pole = np.exp(-1e-3 / constant)
            found = lfilter([1.0 - pole], [1.0, -pole], found)
        return size * found / found.std()

    def work(number):
        steps = np.random.default_rng(number).uniform(2.8, 3.6, 5)
        return {'setpoint': np.full(50_000, 95.0), 'manual': np.full(50_000, 5.0),
                'pprv': np.repeat(steps, 10_000), 'closed': True}

    monkeypatch.setattr(profiles, 'roughness', rock)
    made = make_campaign(seed, roughness=1.5, rate_hz=20.0, duration=50.0,
                         logs=('drilling', 'drilling_holdout'),
                         command={'drilling': work(seed), 'drilling_holdout': work(seed + 100)})
    search = Search(Campaign(*as_runs(made)), ())
    assert search.unexplained(search.baseline) == {}
    assert one_cause(search, search.baseline, {}) is None
