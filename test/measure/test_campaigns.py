# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Measured campaigns: made by an independent truth generator, and the samples where present."""
from functools import cache
from pathlib import Path

from hst_drive.bag import read_log
from hst_drive.measure.compare import compare
from hst_drive.model import Drive
from hst_drive.rig import default_rig
import pytest

pytestmark = pytest.mark.needs_numba
SAMPLES = Path(__file__).resolve().parents[3] / 'shared' / 'cases'
JUDGED = ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed')


def compared(folder):
    """Return the comparison of the shipped rig with all logs of a folder."""
    return compare(Drive(default_rig()), [read_log(path) for path in sorted(folder.glob('*.csv'))])


@pytest.fixture(scope='module')
def samples():
    """Return what gives the comparison of a sample campaign by its name."""
    if not SAMPLES.is_dir():
        pytest.skip('the sample campaigns are not here')
    return cache(lambda name: compared(SAMPLES / name))


def test_an_independent_rig_without_an_effect(tmp_path):
    """Its actuators have inner stages that no datasheet tells, which shows at steps alone."""
    from test.truth import make_campaign, write_campaign

    write_campaign(make_campaign(2, {}, True, keep_exact=False), tmp_path)
    for name, entry in compared(tmp_path).signals.items():
        assert 0.9 < entry.noise_ratio < 1.5, name


def test_no_effect_reaches_the_noise(samples):
    sensors = default_rig().sensors
    found = samples('no_effect')
    for name in JUDGED:
        entry = found.signals[name]
        assert entry.rmse < 1.5 * sensors[name].noise_std, name
        assert 0.9 < entry.noise_ratio < 1.15, name
        assert entry.noise_std == pytest.approx(sensors[name].noise_std, rel=0.1)
    assert found.where == []


@pytest.mark.parametrize('case', [
    'dry_bearing', 'foaming_oil', 'long_hose', 'no_effect_other_unit', 'not_in_catalogue',
    'slow_speed_friction', 'sticky_swash_plate', 'warm_and_dry', 'warm_oil', 'worn_motor'])
def test_every_other_case_shows_its_error(samples, case):
    found = samples(case)
    assert max(entry.noise_ratio for entry in found.signals.values()) > 2
    # Coulomb friction takes the same torque everywhere.
    assert bool(found.where) != (case == 'dry_bearing')


def test_warm_oil_is_told_by_its_temperature(samples):
    found = samples('warm_oil').where
    assert found[0].signal == 'motor_speed' and found[0].variable == 'oil_temperature'
    assert found[0].low > 330


def test_a_long_hose_is_told_by_speed(samples):
    found = samples('long_hose').where
    assert (found[0].signal, found[0].variable) == ('pump_outlet_pressure', 'motor_speed')


def test_friction_at_low_speed_is_told_by_low_speed(samples):
    found = [region for region in samples('slow_speed_friction').where
             if region.variable == 'motor_speed' and region.signal == 'pump_outlet_pressure']
    # The start from rest is left out; the sweep and the commands by hand go down to 2.3 rad/s.
    assert found and found[0].low < 2.5 and found[0].high < 10.45
    assert found[0].share_of_error > 2 * found[0].share_of_time
