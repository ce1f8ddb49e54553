# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Why logs cannot show an effect, and from which size on they do."""
from hst_drive.effects import catalogue
from hst_drive.identify.calibrate import calibrated
from hst_drive.identify.evidence import CREDIBLE
from hst_drive.identify.observable import visibility
from hst_drive.identify.part import campaign_of
from hst_drive.identify.search import Search
from hst_drive.rig import default_rig
import pytest

from ..diagnose import benches
from ..diagnose.benches import motor_bench, motor_rig
from ..measure.synthetic import record

SIGNALS = ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed')


def reason(name, rig, run):
    """Return why a log cannot show an effect; empty if it can."""
    campaign = campaign_of(rig, [run])
    return visibility(campaign, calibrated(campaign), [name])[0].reason


@pytest.mark.parametrize('name, left_out, missing', [
    ('leakage_temperature', ('oil_temperature',), 'oil_temperature'),
    # Where the torque alone is recorded nobody knows the angle of the shaft.
    ('piston_ripple', SIGNALS, 'motor_speed')])
def test_what_follows_a_channel_that_no_log_has_names_it(name, left_out, missing):
    there = reason(name, default_rig(), record(1, duration=15.0, roughness=0.3))
    lacking = reason(name, default_rig(), record(1, duration=15.0, roughness=0.3,
                                                 leave_out=left_out))
    assert missing not in there
    assert missing in lacking


def test_in_a_log_of_a_part_as_well():
    """Flow and leakage are there, so that their balances are closed; how warm, no one knows."""
    run = motor_bench(channels=('motor_inlet_flow', 'case_drain_flow'))
    assert 'oil_temperature' in reason('leakage_temperature', motor_rig(), run)


def test_in_a_table_without_noise_all_that_enters_shows(monkeypatch):
    """Figures of a datasheet: what is far too small to matter would be seen."""
    monkeypatch.setattr(benches, 'NOISE', {})
    monkeypatch.setattr(benches, 'SENSORS', {})
    campaign = campaign_of(motor_rig(), [motor_bench(table=True)])
    found = visibility(campaign, calibrated(campaign), ['viscous_drag', 'back_pressure'])
    assert all(0.0 < entry.smallest < 1e-2 * catalogue()[entry.id].parameters[0].typical
               for entry in found)


@pytest.mark.parametrize('name', ['motor_leakage', 'entrained_air'])
def test_what_is_larger_than_the_smallest_is_found_and_what_is_smaller_is_not(name):
    """The linear forecast of healthy logs, beside fits to logs of machines that have it."""
    def campaign(effects):
        logs = [record(seed, duration=20.0, effects=effects) for seed in range(4)]
        return campaign_of(default_rig(), logs[:3], logs[3:])

    healthy, size = campaign({}), catalogue()[name].parameters[0].name
    smallest = visibility(healthy, calibrated(healthy), [name])[0].smallest
    odds = []
    for share in (0.6, 1.6):
        search = Search(campaign({name: {size: share * smallest}}), healthy.candidates())
        odds.append(search.odds(search.baseline, [search.refine(search.single(name))])[0])
    assert odds[0] < CREDIBLE < odds[1]
