# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What imitates a listed effect is told from it, and the effect in another form is not."""
import re

from bench.campaigns import as_runs
from hst_drive.diagnose.campaign import Campaign
from hst_drive.diagnose.search import Search
from hst_drive.diagnose.strangers import beside, strangers
import pytest

from ..truth import make_campaign

# Hidden in the independent plant, its form, the effect that comes nearest, and whether a
# stranger beats that.
CASES = [
    ('command_leakage', 'square', 'pump_speed_droop', True),
    ('command_leakage', 'ramp', 'compressibility_flow', True),
    ('pump_speed_droop', 'induction', 'pump_speed_droop', False),
    ('compressibility_flow', 'pump_dead_volume', 'compressibility_flow', False),
    ('pump_dead_time', 'pure', 'pump_lag', True),
    ('pump_lag', 'second_order', 'pump_lag', False),
]


@pytest.mark.needs_numba
@pytest.mark.parametrize('hidden, form, named, beaten', CASES)
def test_imitation_is_told_from_another_form(hidden, form, named, beaten):
    made = make_campaign(41, {hidden: {'size': 1.0, 'form': form}})
    search = Search(Campaign(*as_runs(made)), (named,))
    found = strangers(search, search.refine(search.single(named)))
    assert bool(found) is beaten
    assert set(found) <= {named}


@pytest.mark.needs_numba
def test_dead_time_is_told_with_its_size():
    made = make_campaign(42, {'pump_dead_time': 0.8})
    search = Search(Campaign(*as_runs(made)), ('pump_lag',))
    found = strangers(search, search.single('pump_lag'))['pump_lag'].unknown
    assert (found.enters, found.depends_on) == ('pump_actuator', ('pump_command',))
    told = float(re.search(r'([0-9.]+) s later', found.expression)[1])
    assert told == pytest.approx(made.truth['si_parameters']['dead_time'], abs=0.01)


@pytest.mark.needs_numba
@pytest.mark.parametrize('hidden, told', [({'bit_eccentricity': 0.6}, True), ({}, False),
                                          ({'piston_ripple': 1.0}, False)])
def test_load_of_each_turn_is_told_from_a_rough_one(hidden, told):
    """Rough rock is no angle's, and a piston passes seven times a turn."""
    made = make_campaign(43, hidden)
    search = Search(Campaign(*as_runs(made)), ())
    assert bool(beside(search, search.baseline)) is told
