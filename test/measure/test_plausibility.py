# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Sensors against each other, on recordings of which one channel is spoilt."""
from dataclasses import replace
from pathlib import Path

from hst_drive.bag import read_log
from hst_drive.errors import InputError
from hst_drive.measure.plausibility import drifts, refuse_wrong_units, unit_doubts
from hst_drive.rig import default_rig
import numpy as np
import pytest

CASES = Path(__file__).resolve().parents[3] / 'shared' / 'cases'
pytestmark = pytest.mark.skipif(not CASES.is_dir(), reason='no recordings beside the project')


def spoilt(change, channel, case='no_effect', log='drilling'):
    """Return a recording with one channel changed."""
    run = read_log(CASES / case / f'{log}.csv')
    return replace(run, channels={**run.channels, channel: change(run[channel])})


def test_nothing_is_said_of_sound_sensors_whatever_the_drive_lacks():
    for path in sorted(CASES.glob('*/*.csv')):
        run = read_log(path)
        assert unit_doubts(default_rig(), run) == [] and drifts(default_rig(), [run]) == [], path


@pytest.mark.parametrize('case', ('no_effect', 'dry_bearing', 'worn_motor'))
@pytest.mark.parametrize('channel, factor, title', (
    ('motor_speed', 0.1047198, 'rad/s as rpm'), ('motor_speed', 9.549297, 'rpm as rad/s'),
    ('motor_speed', -1.0, 'with the other sign'),
    ('pump_outlet_pressure', 10.0, 'a factor of 10'),
    ('pump_outlet_pressure', 14.5038, 'psi as bar'),
    ('pump_outlet_pressure', 0.1, 'MPa as bar'),
    ('motor_inlet_flow', 1 / 60, 'L/s as L/min'),
    ('motor_inlet_flow', 0.2641721, 'gal/min as L/min'),
    ('load_torque', 0.7375621, 'lbf.ft as N.m')))
def test_a_wrong_unit_is_named(case, channel, factor, title):
    told = unit_doubts(default_rig(), spoilt(lambda values: values * factor, channel, case))
    assert len(told) == 1 and told[0].startswith(f'{channel} reads ') and title in told[0]


def test_a_wrong_unit_is_refused_in_one_line():
    run = spoilt(lambda values: values / 9.549297, 'motor_speed')
    with pytest.raises(InputError, match='drilling.csv: motor_speed reads 0.1.. times what') as it:
        refuse_wrong_units(default_rig(), [run])
    assert '\n' not in str(it.value)


@pytest.mark.parametrize('channel, gain, zero', [
    ('pump_command', 10.0, 0.0), ('pprv_command', 10.0, 0.0), ('pump_command', 1.6, 4.0)])
def test_a_command_in_percent_or_milliampere_is_told(channel, gain, zero):
    told = unit_doubts(default_rig(), spoilt(lambda volts: gain * volts + zero, channel))
    assert f'{channel} is ' in told[0]
    assert 'ends at 10 V (percent or mA taken for V?)' in told[0]


@pytest.mark.parametrize('change', (
    lambda kelvin: kelvin + 273.15, lambda kelvin: (kelvin - 273.15) * 1.8 + 32.0 + 273.15))
def test_oil_that_no_oil_is(change):
    told = unit_doubts(default_rig(), spoilt(change, 'oil_temperature'))
    assert 'which no oil is (degC, K or degF taken for each other?)' in told[0]


@pytest.mark.parametrize('channel, end', (
    ('pump_outlet_pressure', 15e5), ('motor_speed', 0.84), ('load_torque', 25.0),
    ('motor_inlet_flow', 2 / 60000)))
def test_a_drift_is_the_channels_that_drifts(channel, end):
    run = spoilt(lambda values: values + end * np.linspace(0.0, 1.0, len(values)), channel)
    found = drifts(default_rig(), [run])
    assert [entry.channel for entry in found] == [channel]
    assert 'from start to end of the log it moves by +' in found[0].told


@pytest.mark.parametrize('channel, factor', (
    ('motor_speed', 0.3), ('pump_outlet_pressure', 4.0), ('pump_command', 1.8),
    ('load_torque', 1.2), ('load_torque', 0.74)))
def test_what_wear_or_a_sensor_out_of_adjustment_does_is_no_unit(channel, factor):
    """A motor that leaks 70 %, a bearing that takes 3/4, a worn pump, torque 20 or 26 % off."""
    run = spoilt(lambda values: values * factor, channel)
    refuse_wrong_units(default_rig(), [run])


def test_a_drive_that_idles_or_stands_tells_no_unit():
    """Two channels of noise may agree, and the third may be 0."""
    run = read_log(CASES / 'no_effect' / 'drilling.csv')
    random = np.random.default_rng(1)
    for size in (0.0, 1.0):
        noise = {name: size * np.std(np.diff(values)) * np.abs(random.standard_normal(len(run)))
                 for name, values in run.channels.items() if not name.endswith('command')}
        still = {**run.channels, **noise, 'oil_temperature': run['oil_temperature'],
                 'pump_command': np.zeros(len(run)), 'pprv_command': np.zeros(len(run))}
        assert unit_doubts(default_rig(), replace(run, channels=still)) == []


def test_warming_is_no_drift_where_no_thermometer_saw_it():
    run = spoilt(lambda values: values + 15e5 * np.linspace(0.0, 1.0, len(values)),
                 'pump_outlet_pressure')
    assert drifts(default_rig(), [run])
    del run.channels['oil_temperature']
    assert drifts(default_rig(), [run]) == []
