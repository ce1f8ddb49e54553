# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings begin at any angle of the shaft."""
from dataclasses import replace

from bench.campaigns import as_runs
from hst_drive.diagnose.unlisted import unlisted_addition
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.model import Model
from hst_drive.identify.part import campaign_of
from hst_drive.identify.phases import in_step
from hst_drive.identify.search import Search
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
    left = search.unexplained(search.baseline)
    assert 'angle of the shaft' in unlisted_addition(search, search.baseline, left)[1].told


@pytest.mark.needs_numba
def test_a_rig_with_ripple_fits_a_log_that_begins_at_any_angle():
    effects = {'piston_ripple': {'cosine': 0.01, 'sine': 0.005, 'cosine_2': 0.003}}
    run, = begun_later([record(3, effects=effects)])
    for name, entry in compare(Drive(default_rig(), effects), [run]).signals.items():
        assert entry.noise_ratio < 1.4, name    # the first state is not measured whole


@pytest.mark.needs_numba
def test_a_bench_log_of_a_rig_with_ripple_fits_wherever_it_begins():
    effects = {'piston_ripple': {'cosine': 0.01, 'sine': 0.005, 'cosine_2': 0.003}}
    rig = replace(default_rig(), effects=effects)
    left_out = ('motor_inlet_flow', 'pump_command', 'pprv_command')
    for first in (0, 1, 2):
        run, = begun_later([record(3, effects=effects, roughness=0.0)], first)
        torque = {'motor_torque': run['load_torque']}
        run = replace(run, channels={**{name: values for name, values in run.channels.items()
                                        if name not in (*left_out, 'load_torque')}, **torque})
        campaign = campaign_of(rig, [run])
        ratio = campaign.ratios(campaign.errors(Model()), True)['motor_torque']
        assert ratio < 1.3, first


@pytest.mark.needs_numba
def test_what_is_turned_for_one_model_stays_as_it_was_for_another():
    """A page asks for several models at once."""
    rig, runs, held_out = as_runs(make_campaign(44, {}))
    campaign = Campaign(rig, begun_later(runs), begun_later(held_out, 5))
    before = [replay.inputs['motor_angle'].copy() for replay in campaign.replays]
    ripple = Model({'piston_ripple': {'cosine': 0.0, 'sine': 0.02, 'cosine_2': 0.0, 'sine_2': 0.0,
                                      'count': 9.0}})
    turned_for_it = in_step(campaign, ripple)
    assert all((replay.inputs['motor_angle'] == angle).all()
               for replay, angle in zip(campaign.replays, before))
    assert any((replay.inputs['motor_angle'] != angle).any()
               for replay, angle in zip(turned_for_it.replays, before))


@pytest.mark.needs_numba
def test_an_adopted_load_of_each_turn_fits_a_log_that_begins_at_any_angle():
    effects = {'formula_load': {'coefficient_1': 15.0, 'torque_1': 1.0, 'cosine_1': 1.0},
               'piston_ripple': {'cosine': 0.01, 'sine': 0.0}}
    for place in (1, 2):
        run, = begun_later([record(3, effects=effects, roughness=0.0)], place)
        for name, entry in compare(Drive(default_rig(), effects), [run]).signals.items():
            assert entry.noise_ratio < 1.4, (name, place)
