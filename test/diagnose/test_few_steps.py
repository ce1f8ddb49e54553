# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What shows in a few steps of a short log, on a unit that is known as well as its own past."""
from test.truth import make_campaign

from bench.campaigns import run_of
from hst_drive.diagnose.decide import diagnose
from hst_drive.rig import parse_rig
import pytest

pytestmark = pytest.mark.needs_numba
SHARE = 0.1     # of the make's tolerances, by which one machine differs from day to day


def answer(seed, effects):
    """Return what is named in two logs of half a minute."""
    made = make_campaign(seed, effects, on_datasheet=True, duration=30.0, keep_exact=False,
                         logs=('drilling', 'speed_sweep'))
    sheet = {**made.sheet, 'tolerances_1_sigma_relative': {
        key: SHARE * value for key, value in made.sheet['tolerances_1_sigma_relative'].items()}}
    return diagnose(parse_rig(sheet, 'unit'), [run_of(*log) for log in made.logs.items()])


@pytest.mark.parametrize('seed', [951_002, 951_003])
def test_a_slower_actuator_is_named_though_most_of_the_time_nothing_steps(seed):
    """16 ms more in a lag of 60: steps move by ten standard errors, all else not at all."""
    found = answer(seed, {'pump_lag': {'size': 0.2, 'form': 'first_order'}})
    names = {name for entry in found.effects for name in (entry.id, *entry.indistinguishable_from)}
    assert 'pump_lag' in names
    assert answer(seed, {}).verdict == 'none'
