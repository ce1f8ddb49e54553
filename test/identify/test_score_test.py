# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which effect more is worth a fit: what the linear forecast says, a fit must find."""
from bench.campaigns import as_runs
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import fit
from hst_drive.identify.score_test import score_test
from hst_drive.identify.search import Search
from hst_drive.rig import default_rig
import pytest

from ..measure.synthetic import record
from ..truth import make_campaign

pytestmark = pytest.mark.needs_numba


def searched(hidden, candidates):
    campaign = Campaign(default_rig(), [record(seed, effects=hidden) for seed in (1, 2, 3)])
    search = Search(campaign, candidates)
    search.singles()
    return search


def test_the_forecast_is_what_a_fit_takes_away():
    search = searched({'viscous_drag': {'coefficient': 2.0}, 'flow_sensor_scale': {
        'gain_error': 0.02}}, ('flow_sensor_scale', 'viscous_drag', 'pump_lag'))
    drag = search.refine(search.single('viscous_drag'))
    found = {name: share for share, name in score_test(search, drag)}
    after = fit(search.campaign, drag.fit.model.with_effect(
        'flow_sensor_scale', {'gain_error': 0.01}), iterations=6)
    left = search.campaign.training(drag.fit.errors)
    assert found['flow_sensor_scale'] == pytest.approx(
        (drag.fit.cost - after.cost) / float(left @ left), rel=0.2)
    assert found['flow_sensor_scale'] > 10 * found['pump_lag']
    # Jacobians of hours of logs would fill the memory: that of one fit of many is formed anew.
    lag = search.single('pump_lag')
    assert not lag.fit.columns
    assert {*search.whole(lag).fit.columns} == {*lag.fit.names}


@pytest.mark.parametrize('bias, hoped', [(-1.5e5, False), (1.5e5, True)])
def test_an_effect_cannot_be_less_than_nothing(bias, hoped):
    """A gauge that reads low is no return pressure of less than nothing."""
    search = searched({'pressure_sensor_bias': {'bias': bias}},
                      ('back_pressure', 'pressure_sensor_bias'))
    found = {name: share for share, name in score_test(search, search.baseline)}
    assert found['pressure_sensor_bias'] > 0.05
    assert (found['back_pressure'] > 0.05) == hoped


def test_what_the_unit_can_only_do_beyond_its_tolerance_an_effect_may_do():
    """Without a speed a wrong factor of the flow moves pump and leakages to their limits."""
    made = make_campaign(
        11700042, {'flow_sensor_scale': {'size': 1.01, 'form': 'bent'},
                   'line_loss': {'size': 1.18, 'form': 'blasius'}}, rig_seed=11700042,
        channels=('pump_command', 'pprv_command', 'oil_temperature', 'pump_outlet_pressure',
                  'motor_inlet_flow', 'load_torque'))
    search = Search(Campaign(*as_runs(made)), (
        'line_loss', 'pump_command_offset', 'flow_sensor_scale', 'gearbox_loss'))
    search.singles()
    line = search.refine(search.single('line_loss'))
    likely = sorted(score_test(search, line), reverse=True)
    assert likely[0][1] == 'flow_sensor_scale'
    assert likely[0][0] > 1.5 * likely[1][0]
