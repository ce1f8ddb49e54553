# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings begin at any angle of the shaft."""
from bench.campaigns import as_runs
from hst_drive.diagnose.campaign import Campaign
from hst_drive.diagnose.search import Search
from hst_drive.diagnose.strangers import beside
from hst_drive.measure.compare import compare
from hst_drive.model import Drive
from hst_drive.model.drive import turned
from hst_drive.rig import default_rig
import numpy as np
import pytest

from ..measure.synthetic import record
from ..truth import make_campaign


def begun_later(runs, first=1):
    """Return recordings without their first rows, so that each begins at another angle."""
    return [run.between(run.time[0] + 0.17 * place, run.time[-1])
            for place, run in enumerate(runs, first)]


def searched(hidden, *names):
    """Return a search on logs that each begin at another angle."""
    rig, runs, held_out = as_runs(make_campaign(44, hidden))
    return Search(Campaign(rig, begun_later(runs), begun_later(held_out, 5)), names)


def test_the_angle_is_the_integral_of_the_speed():
    time = np.array([0.0, 0.1, 0.15, 0.4])
    assert turned(time, 2.0 + 6.0 * time) == pytest.approx(2.0 * time + 3.0 * time**2)


@pytest.mark.needs_numba
def test_ripple_is_found_in_logs_that_begin_at_other_angles():
    search = searched({'piston_ripple': {'size': 1.0, 'form': 'sine'}}, 'piston_ripple')
    found = search.refine(search.single('piston_ripple'))
    assert max(search.campaign.ratios(search.base.errors, True).values()) > 2.0
    assert not search.unexplained(found)


@pytest.mark.needs_numba
def test_load_of_each_turn_is_found_in_logs_that_begin_at_other_angles():
    search = searched({'bit_eccentricity': 0.6})
    assert 'angle of the shaft' in beside(search, search.baseline).told


@pytest.mark.needs_numba
def test_a_rig_with_ripple_fits_a_log_that_begins_at_any_angle():
    effects = {'piston_ripple': {'cosine': 0.01, 'sine': 0.005, 'cosine_2': 0.003}}
    run, = begun_later([record(3, effects=effects)])
    for name, entry in compare(Drive(default_rig(), effects), [run]).signals.items():
        assert entry.noise_ratio < 1.4, name    # the first state is not measured whole
