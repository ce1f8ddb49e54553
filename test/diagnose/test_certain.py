# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What shows in a single event of a short log, where no test over blocks can be sure."""
import hst_drive as hd
from hst_drive.diagnose.decide import diagnose
from hst_drive.rig import default_rig
import pytest

pytestmark = pytest.mark.needs_numba


def test_a_lag_that_shows_in_one_event_is_named_alone():
    log = hd.simulate('commissioning', effects={'pump_lag': {'time_constant': 0.08}})
    found = diagnose(default_rig(), [log.between(0.0, 30.0).run])
    effect, = found.effects
    assert (found.verdict, effect.id, effect.indistinguishable_from) == (
        'missing_effect', 'pump_lag', ())
    lag = effect.parameters['time_constant']
    assert lag.low < 0.08 < lag.high and lag.value == pytest.approx(0.08, rel=0.05)
    assert found.probability.sets[0][0] == ('pump_lag',)
