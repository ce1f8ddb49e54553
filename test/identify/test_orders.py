# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A machine with another number of pistons than the rig's file, or the usual one, has."""
import math

from bench.campaigns import as_runs
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.phases import strongest_orders
from hst_drive.identify.search import Search
import pytest

from ..truth import make_campaign


def search_for(pistons, form='sine', size=1.0, **options):
    """Return a search on logs of a machine with a ripple of that many pistons."""
    made = make_campaign(44, {'piston_ripple': {
        'size': size, 'form': form, 'parameters': {'pistons': float(pistons)}}}, **options)
    return Search(Campaign(*as_runs(made)), ('piston_ripple',)), made


@pytest.mark.needs_numba
@pytest.mark.parametrize('pistons, rate', [(5, 50.0), (9, 50.0), (7, 100.0), (11, 100.0),
                                           (13, 200.0)])
def test_the_order_is_read_off(pistons, rate):
    search, _ = search_for(pistons, rate_hz=rate)
    assert strongest_orders(search.campaign, search.base.errors)[0] == pistons


@pytest.mark.needs_numba
@pytest.mark.parametrize('pistons', [5, 9])
def test_the_ripple_is_found_with_its_pistons_and_size(pistons):
    search, made = search_for(pistons)
    found = search.refine(search.single('piston_ripple')).fit.model.effects['piston_ripple']
    assert found['count'] == pistons
    assert math.hypot(found['cosine'], found['sine']) == pytest.approx(
        made.truth['si_parameters']['ripple'], rel=0.15)


@pytest.mark.needs_numba
def test_without_an_angle_there_is_no_order():
    channels = ('pump_command', 'pprv_command', 'oil_temperature', 'pump_outlet_pressure')
    search, _ = search_for(7, channels=channels)
    assert strongest_orders(search.campaign, search.base.errors) == []
    assert search.single('piston_ripple').fit.model.effects['piston_ripple']['count'] == 0
