# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Shapes of effects: fitted where the data ask for it, else what the field's formulas have."""
from bench.campaigns import as_runs
from hst_drive.effects import catalogue
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.intervals import intervals
from hst_drive.identify.search import Search
from hst_drive.rig import default_rig
import numpy as np
import pytest

from ..measure.synthetic import record
from ..truth import make_campaign

pytestmark = pytest.mark.needs_numba


def named(campaign, effect):
    """Return the fit of an effect alone, in the end."""
    search = Search(campaign, (effect,))
    return search.refine(search.singles()[0]).fit


@pytest.mark.parametrize('form, shape, tail', [
    ('gauss', 2.0, 0.0), ('exponential', 1.0, 0.0), ('lorentz', 2.0, 1.0)])
def test_a_usual_curve_keeps_its_usual_shape(form, shape, tail):
    campaign = Campaign(*as_runs(make_campaign(
        4103, {'stribeck_friction': {'size': 1.0, 'form': form}})))
    fitted = named(campaign, 'stribeck_friction')
    assert [fitted.model.effects['stribeck_friction'][key] for key in ('shape', 'tail')] == [
        shape, tail]
    limits = intervals(campaign, fitted)
    # The usual value is the likeliest, not the only one.
    for key in ('torque', 'shape', 'tail'):
        low, high = limits['stribeck_friction', key]
        assert low <= fitted.model.effects['stribeck_friction'][key] <= high and low < high


@pytest.mark.parametrize('seed, size, form, shape, tail', [
    (620006, 0.68, 'gauss', 2.0, 0.0), (620001, 1.32, 'exponential', 1.0, 0.0),
    (620005, 1.4, 'lorentz', 2.0, 1.0)])
def test_sizes_know_of_what_shapes_leave_open(seed, size, form, shape, tail):
    """Speeds near standstill are rare: what the curve does there is a guess."""
    made = make_campaign(seed, {'stribeck_friction': {'size': size, 'form': form}})
    campaign = Campaign(*as_runs(made))
    fitted = named(campaign, 'stribeck_friction')
    limits, own = intervals(campaign, fitted), fitted.model.effects['stribeck_friction']
    true = made.truth['si_parameters']
    for key, value in {'torque': true['t_strib'], 'speed': true['w_strib'], 'shape': shape,
                       'tail': tail}.items():
        low, high = limits['stribeck_friction', key]
        assert low <= value <= high
        assert key == 'tail' or high - low < 0.8 * own[key]


def test_an_unusual_curve_is_told():
    hidden = {'torque': 25.0, 'speed': 10.0, 'shape': 3.0, 'tail': 0.0}
    campaign = Campaign(default_rig(), [record(
        seed, effects={'stribeck_friction': hidden}) for seed in (1, 2, 3)])
    fitted = named(campaign, 'stribeck_friction')
    limits = intervals(campaign, fitted)
    assert fitted.model.effects['stribeck_friction']['tail'] == hidden['tail']
    assert all(limits['stribeck_friction', key][0] < hidden[key]
               < limits['stribeck_friction', key][1] for key in ('torque', 'speed', 'shape'))
    # Over the speeds of these logs; how high the curve is at standstill they do not show.
    curve, speeds = catalogue()['stribeck_friction'].function, np.linspace(7.0, 12.0, 6)
    found, expected = ([curve(speed, **values) for speed in speeds] for values in (
        fitted.model.effects['stribeck_friction'], hidden))
    # 0.2 % of efficiency, which is the unit's own, is 0.6 N m of friction here.
    assert found == pytest.approx(expected, abs=0.6)
