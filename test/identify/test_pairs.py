# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A friction that falls with speed and a drag that rises, in the place of a constant one."""
from bench.campaigns import as_runs
from hst_drive.diagnose.choose import likeliest
from hst_drive.identify.alternatives import alternatives
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.pairs import pair_instead
from hst_drive.identify.search import Search
import pytest

from ..truth import make_campaign

CANDIDATES = ('back_pressure', 'bearing_friction', 'stribeck_friction', 'viscous_drag')
UNIT = {'rate_hz': 50.0}


@pytest.mark.needs_numba
@pytest.mark.parametrize('seed, options, hidden, found', [
    (3702040, UNIT, {'stribeck_friction': {'size': 1.29, 'form': 'exponential'},
                     'viscous_drag': {'size': 1.6, 'form': 'power'}},
     ('stribeck_friction', 'viscous_drag')),
    (3702040, UNIT, {'back_pressure': {'size': 1.3, 'form': 'flow_dependent'}},
     ('back_pressure',)),
    (12703013, {'on_datasheet': True, 'temperature': 'warm'},
     {'back_pressure': {'size': 1.41, 'form': 'flow_dependent'}}, ('back_pressure',)),
    (3702040, UNIT, {'bearing_friction': {'size': 1.5, 'form': 'load_dependent'}},
     ('bearing_friction',)),
])
def test_two_stand_for_one_only_where_they_are_there(seed, options, hidden, found):
    """What one effect of another form leaves is not enough for two."""
    made = make_campaign(seed, hidden, rig_seed=seed, **options)
    # A return pressure that rises with the flow is constant and rising torque in one.
    search = Search(Campaign(*as_runs(made)), tuple(
        name for name in CANDIDATES if name != 'back_pressure' or name in hidden))
    alone = search.refine(search.singles()[0])
    assert pair_instead(search, alone).names == found


@pytest.mark.needs_numba
@pytest.mark.parametrize('hidden, form, first', [
    ('bearing_friction', 'tanh', 'bearing_friction'),
    ('back_pressure', 'flow_dependent', 'back_pressure')])
def test_of_effects_that_look_alike_the_likelier_comes_first(hidden, form, first):
    """A return pressure, with more parameters, fits friction as well; but not the reverse."""
    made = make_campaign(3702040, {hidden: {'size': 1.3, 'form': form}}, **UNIT)
    search = Search(Campaign(*as_runs(made)), CANDIDATES)
    best = search.refine(search.single('back_pressure'))
    assert not search.unexplained(best)
    rivals = {'back_pressure': alternatives(search, best, 'back_pressure')}
    assert likeliest(search, best, rivals).names == (first,)


@pytest.mark.needs_numba
def test_two_that_take_a_place_are_both_needed():
    """What was found is wrong; one effect in its place explains all, and any beside it nothing."""
    made = make_campaign(3702041, {'hydrodynamic_drag': {'size': 1.4, 'form': 'square'}}, **UNIT)
    search = Search(Campaign(*as_runs(made)), (
        'compressibility_flow', 'hydrodynamic_drag', 'viscous_drag'))
    wrong = search.refine(search.single('viscous_drag'))
    assert pair_instead(search, wrong).names == ('hydrodynamic_drag',)
