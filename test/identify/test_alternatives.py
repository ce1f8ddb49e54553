# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What explains the recordings alike is told beside what was found, whichever came first."""
from bench.campaigns import as_runs
from hst_drive.identify.alternatives import alternatives
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.search import Search
import pytest

from ..truth import make_campaign


@pytest.mark.needs_numba
@pytest.mark.parametrize('form, alike', [('orifice', True), ('laminar', False)])
def test_a_formula_that_another_can_take_is_told_where_it_takes_it(form, alike):
    """A leakage with a power of 0.5 is an orifice; one of 1 is none."""
    made = make_campaign(75, {'pump_leakage': {'size': 1.2, 'form': form}})
    search = Search(Campaign(*as_runs(made)), ('motor_leakage', 'pump_leakage'))
    best = search.refine(search.single('pump_leakage'))
    assert ('pump_orifice_leakage' in alternatives(search, best, 'pump_leakage')) == alike
