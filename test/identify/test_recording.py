# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Steps between rows, zeros of sensors and scatter, on machines of independent generators."""
from dataclasses import replace
from test.diagnose import benches
from test.measure.test_circuit import campaign as closed_campaign
from test.truth import make_campaign
from types import SimpleNamespace

from bench.campaigns import run_of
from hst_drive.identify.calibrate import calibrated
from hst_drive.identify.columns import Column
from hst_drive.identify.judge import CLEAN_RATIO, over_own_floors, unexplained
from hst_drive.identify.part import campaign_of
from hst_drive.identify.recording import in_time, lasting
from hst_drive.rig import parse_rig
import numpy as np
import pytest


def calibration(effects, late):
    """Return campaign and fit of a log in which half of the steps may show a row late."""
    made = make_campaign(41, effects, logs=('open_loop',), noise=0.4, keep_exact=False)
    (name, columns), = made.logs.items()
    random = np.random.default_rng(41)
    for key in ('pump_command[V]', 'pprv_command[V]') if late else ():
        steps = np.flatnonzero(np.diff(columns[key]))
        steps = steps[random.random(len(steps)) < 0.5]
        columns[key][steps + 1] = columns[key][steps]
    campaign = campaign_of(parse_rig(made.sheet, 'rig'), [run_of(name, columns)])
    return campaign, calibrated(campaign)


def worst(campaign, fitted, held):
    """Return the largest noise ratio: as it is, or with steps in time."""
    own, fitted = over_own_floors(campaign, fitted)
    errors = in_time(own, fitted.errors) if held else fitted.errors
    return max(own.ratios(errors, None).values())


def test_steps_that_show_up_to_a_row_late_are_no_physics():
    campaign, fitted = calibration({}, late=True)
    assert worst(campaign, fitted, False) > CLEAN_RATIO
    assert worst(campaign, fitted, True) < 1.2
    assert not unexplained(campaign, fitted, {}, None)


@pytest.mark.parametrize('effects', [{}, {'pump_lag': 1.0}, {'motor_leakage': 1.0}])
def test_what_is_missing_does_not_go_into_the_time_of_steps(effects):
    campaign, fitted = calibration(effects, late=False)
    before = worst(campaign, fitted, False)
    assert worst(campaign, fitted, True) > 0.95 * before
    assert bool(unexplained(campaign, fitted, {}, None)) == bool(effects)


def with_gauges_off(folder, pascals):
    """Return logs of a healthy closed circuit whose gauges are off in opposite directions."""
    rig, logs, _ = closed_campaign(folder, '--circuit', 'closed', '--kind', 'none',
                                   '--seed', '100')
    return campaign_of(rig, [replace(run, channels={
        **run.channels, 'line_a_pressure': run['line_a_pressure'] - pascals,
        'line_b_pressure': run['line_b_pressure'] + pascals})
        for run in (logs['drilling'], logs['sweep'])])


@pytest.mark.parametrize('noises, explained', [
    (0.0, True), (1.0, True), (-1.0, True), (2.0, False)])
def test_a_zero_within_the_noise_of_a_sensor_is_no_physics(tmp_path, noises, explained):
    """Two gauges off by 0.3 bar in opposite directions, as where zeros are not fitted."""
    campaign = with_gauges_off(tmp_path, noises * 0.3e5)
    campaign.zeros = {}
    fitted = calibrated(campaign)
    own, there = over_own_floors(campaign, fitted)
    assert (max(own.ratios(there.errors, None).values()) > 1.5) == (noises != 0.0)
    assert any(unexplained(campaign, fitted, {}, part) for part in (False, True)) != explained


@pytest.mark.parametrize('bar, explained', [
    (0.0, True), (0.3, True), (-0.3, True), (0.9, False)])
def test_zeros_of_gauges_are_found(tmp_path, bar, explained):
    """They scatter by 0.15 bar; a gauge that is off by six times that stays unexplained."""
    campaign = with_gauges_off(tmp_path, bar * 1e5)
    fitted = calibrated(campaign)
    if explained:
        zeros = [fitted.model.zeros[f'line_{line}_pressure'] for line in 'ab']
        assert zeros == pytest.approx([-bar * 1e5, bar * 1e5], abs=0.05e5)
    assert any(unexplained(campaign, fitted, {}, part) for part in (False, True)) != explained


@pytest.mark.parametrize('rows, explained', [(1, True), (30, False)])
def test_scatter_that_grows_with_what_is_read_is_no_physics(rows, explained):
    """A torque meter scatters by 2 % of its reading, from row to row or every 0.3 s."""
    run = benches.motor_bench(seed=6)
    random = np.random.default_rng(6)
    scatter = np.repeat(random.standard_normal(len(run) // rows), rows)
    run = replace(run, channels={**run.channels, 'motor_torque':
                                 run['motor_torque'] * (1.0 + 0.02 * scatter)})
    campaign = campaign_of(benches.motor_rig(), [run])
    fitted = calibrated(campaign)
    own, there = over_own_floors(campaign, fitted)
    assert max(own.ratios(there.errors, None).values()) > CLEAN_RATIO
    assert any(unexplained(campaign, fitted, {}, part) for part in (False, True)) != explained


@pytest.mark.parametrize('rows, apart', [(2000, 1), (2000, 60), (30, 60)])
def test_what_lasts_is_no_scatter_however_short_the_log(rows, apart):
    column = Column(0, 'flow', np.arange(rows), np.arange(0), 1.0, np.ones(rows))
    campaign = SimpleNamespace(columns=[column], replays=[SimpleNamespace(
        apart=lambda name: apart, run=SimpleNamespace(sample_time=0.01))])
    assert lasting(campaign, [np.full(rows, 2.0)], 'flow', None) == pytest.approx(4.0)
    if rows > apart:
        white = 2.0 * np.random.default_rng(1).standard_normal(rows)
        assert lasting(campaign, [white], 'flow', None) < 0.5
