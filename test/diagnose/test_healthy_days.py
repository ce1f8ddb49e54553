# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Healthy machines that are not quite what is known of them."""
from dataclasses import replace
from test.truth import make_campaign
from test.truth.sensors import STANDARD

from bench.campaigns import as_runs, run_of
from hst_drive.diagnose.decide import diagnose
from hst_drive.rig import parse_rig
import numpy as np
import pytest

pytestmark = pytest.mark.needs_numba
SHARE = 0.1     # of the make's tolerances, by which one machine differs from day to day


@pytest.mark.parametrize('number, roughness, celsius, warms', [
    (112, 1.5, 50.0, 1.0), (111, 0.5, 63.0, 1.0), (113, 0.5, 50.0, 5.0), (114, 0.5, 50.0, 4.0)])
def test_what_is_as_on_healthy_days_is_no_alarm(number, roughness, celsius, warms):
    """
    Half of the rows may show it by chance, and leakages go with oil that was steady before.

    Rough rock is off in the held-out seconds alone; so is a pump near its dead band.
    """
    logs = ('drilling', 'speed_sweep')
    made = make_campaign(
        932_000 + number, {'leakage_temperature': {'size': 1.0, 'form': 'walther'}},
        unit_seed=910_022, duration=30.0, logs=logs, roughness=roughness, keep_exact=False,
        temperature={log: (celsius - warms, celsius + warms) for log in logs})
    tolerances = made.sheet['tolerances_1_sigma_relative']
    sheet = {**made.sheet, 'calibration': made.truth['scatter'], 'commissioned': {
        'sigma_relative': {key: SHARE * value for key, value in tolerances.items()},
        'correlation': np.eye(len(tolerances)).tolist(), 'day_to_day_share_of_tolerance': SHARE,
        'conditions': {'oil_temperature_degC': [49.0, 51.0]}}}
    found = diagnose(parse_rig(sheet, 'unit'), [run_of(*log) for log in made.logs.items()])
    assert found.verdict == 'none'


@pytest.mark.parametrize('power', [0.03, -0.03])
def test_a_leakage_of_another_power_of_the_pressure_is_the_units(power):
    """A good gauge of the case drain reads a leakage to one percent, a table has it to a few."""
    found = _with_case_drain({}, power)
    assert found.verdict == 'none'


def test_gaps_that_open_under_pressure_are_still_seen_in_the_case_drain():
    found = _with_case_drain({'elastic_leakage': {'size': 0.1, 'form': 'cubic_gap'}}, 0.0)
    effect, = found.effects
    stretch = effect.parameters['stretch']
    assert effect.id == 'elastic_leakage' and stretch.low < 2.5e-9 < stretch.high


def _with_case_drain(effects, power):
    rig, logs, held_out = as_runs(make_campaign(
        71, effects, channels=(*STANDARD, 'case_drain_flow'), on_datasheet=False, duration=40.0))
    leak = rig.motor.leakage
    other = leak.z * (np.maximum(leak.x, 1e5) / 1e7)[:, None]**-power
    rig = replace(rig, motor=replace(rig.motor, leakage=replace(leak, z=other)))
    return diagnose(rig, logs, held_out)
