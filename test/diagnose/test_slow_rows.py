# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the load lacks is seen in slow rows, too: its reading is compared, not replayed."""
from bench.campaigns import as_runs
from hst_drive.diagnose.decide import diagnose
from hst_drive.identify.calibrate import calibrated
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.judge import unexplained
import pytest

from ..truth import make_campaign

STICKS = {'unknown:pprv_stiction': {'size': 1.0}}
pytestmark = pytest.mark.needs_numba


@pytest.mark.parametrize('rate', [25.0, 100.0])
@pytest.mark.parametrize('seed, hidden', [
    (8, STICKS), (9, STICKS), (11, STICKS), (8, {}), (12, {})])
def test_a_valve_that_sticks_shows_at_any_rate(seed, hidden, rate):
    campaign = Campaign(*as_runs(make_campaign(seed, hidden, rate_hz=rate)))
    unit = calibrated(campaign)
    left = {name for held_out in (True, False)
            for name in unexplained(campaign, unit, {}, held_out)}
    assert left == ({'load_torque'} if hidden else set())


def test_a_valve_that_sticks_is_no_none():
    found = diagnose(*as_runs(make_campaign(8, STICKS, rate_hz=25.0)))
    assert (found.verdict, found.effects) == ('unknown', ())
    assert (found.unknown.enters, found.unknown.signal) == ('load', 'load_torque')
