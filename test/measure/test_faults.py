# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What sensors, cables and loggers do to a recording, told from what a drive does."""
from pathlib import Path

from hst_drive.bag import read_log
from hst_drive.channels import CHANNELS
from hst_drive.measure.faults import find_faults, without_faults, without_lost_rows
import numpy as np
import pytest

CASES = Path(__file__).resolve().parents[3] / 'shared' / 'cases'
RATE = 100.0
TIME = np.arange(6000) / RATE


def sensors(seed=0, time=TIME):
    """Return three readings of a resonance that steps of a load excite, each with its noise."""
    random = np.random.default_rng(seed)
    step = np.zeros(len(time))
    for begin in np.arange(3.0, 58.0, 4.0):
        after = time > begin
        step[after] += 20.0 * random.standard_normal() * (1.0 - np.exp(
            -3.0 * (time[after] - begin)) * np.cos(60.0 * (time[after] - begin)))
    return {name: np.round((offset + gain * step + noise * random.standard_normal(len(time)))
                           / resolution) * resolution
            for name, offset, gain, noise, resolution in (
                ('pump_outlet_pressure', 100.0, 1.0, 0.12, 0.049),
                ('motor_speed', 100.0, -0.1, 0.15, 0.1),
                ('load_torque', 200.0, 2.0, 0.5, 0.1))}


@pytest.mark.parametrize('places', ([1000], [1000, 1001, 1002], range(500, 5900, 500),
                                    range(2000, 2300)))
def test_rows_that_the_logger_filled_with_zeros_are_left_out(places):
    places = list(places)
    channels = {**sensors(), 'oil_temperature': np.full(len(TIME), 320.0),
                'pump_command': np.full(len(TIME), 5.0), 'speed_setpoint': np.zeros(len(TIME))}
    broken = {name: values.copy() for name, values in channels.items()}
    for name, null in (('pump_outlet_pressure', -101325.0), ('motor_speed', 0.0),
                       ('load_torque', 0.0), ('oil_temperature', 273.15),
                       ('pump_command', 0.0)):
        broken[name][places] = null
    clean, notes = without_lost_rows(TIME, broken, ('pump_command', 'speed_setpoint'))
    assert f'{len(places)} of {len(TIME)} rows' in notes[0]
    for name, values in clean.items():
        lost = np.flatnonzero(np.isnan(values))
        np.testing.assert_array_equal(lost, places)
        rest = np.isfinite(values)
        np.testing.assert_array_equal(values[rest], channels[name][rest])


def test_a_drive_that_stands_still_is_no_lost_row():
    slowly = np.clip(np.abs(TIME - 30.0) - 5.0, 0.0, 1.0)       # at rest from 25 to 35 s
    at_once = (TIME > 2.0).astype(float)                        # and before it was switched on
    for shape in (slowly, at_once):
        channels = {name: values * shape for name, values in sensors().items()}
        clean, notes = without_lost_rows(TIME, channels, ())
        assert not notes and all(clean[name] is values for name, values in channels.items())


@pytest.mark.parametrize('rate', (500.0, 100.0, 50.0, 20.0))
def test_a_drive_has_no_faults(rate):
    for seed in range(5):
        time = np.arange(0.0, 60.0, 1.0 / rate)
        assert find_faults(time, sensors(seed, time)) == {}


@pytest.mark.skipif(not CASES.is_dir(), reason='no recordings beside the project')
@pytest.mark.parametrize('every', (1, 2, 5, 10))
def test_recordings_of_drives_have_none_at_any_rate(every):
    for path in sorted(CASES.glob('*/*.csv')):
        run = read_log(path)
        assert not any('left out' in note for note in run.notes), path
        found = find_faults(run.time[::every], {
            name: values[::every] for name, values in run.channels.items()
            if CHANNELS[name].hold == 'linear'})
        assert found == {}, path


@pytest.mark.parametrize('name, size', (
    ('pump_outlet_pressure', 60.0), ('pump_outlet_pressure', -12.0), ('motor_speed', 12.0),
    ('load_torque', 200.0)))
def test_spikes_are_found_and_nothing_else_goes(name, size):
    """All of them, singles and pairs; of the good samples none."""
    clean = sensors(3)
    random = np.random.default_rng(1)
    quiet = np.flatnonzero((TIME - 3.0) % 4.0 > 1.5)[::10]
    places = np.sort(random.choice(quiet[2:-2], 15, replace=False))
    spoilt = {**clean, name: clean[name].copy()}
    spoilt[name][places] += size
    spoilt[name][places[3] + 1] += size
    found = find_faults(TIME, spoilt)
    assert list(found) == [name]
    assert set(found[name].spikes) == {*places, places[3] + 1}
    mended, notes = without_faults(TIME, spoilt)
    keep = np.isfinite(mended[name])
    assert keep.sum() == len(TIME) - 16 and np.array_equal(mended[name][keep], clean[name][keep])
    assert '16 of 6000 samples are spikes that no other channel follows' in notes[0]


def test_a_blow_that_all_sensors_feel_is_no_fault():
    spoilt = {name: values + 50.0 * (np.arange(6000) % 700 == 350)
              for name, values in sensors(2).items()}
    assert find_faults(TIME, spoilt) == {}


def test_a_blow_beside_a_row_that_is_missing_is_no_fault():
    spoilt = {name: values * np.where(np.arange(6000) == 1000, 1.5, 1.0)
              for name, values in sensors(2).items()}
    for values in spoilt.values():
        values[999] = np.nan
    assert find_faults(TIME, spoilt) == {}


def test_rows_that_a_logger_lost_are_at_zero_throughout():
    spoilt = sensors(2)
    for values in spoilt.values():
        values[[1000, 2500, 4321]] = 0.0
    assert {name: list(entry.spikes) for name, entry in find_faults(TIME, spoilt).items()} == \
        dict.fromkeys(spoilt, [1000, 2500, 4321])


@pytest.mark.parametrize('value', (None, 0.0))
def test_a_frozen_sensor_is_left_out_while_it_stands(value):
    spoilt = sensors(4)
    speed = spoilt['motor_speed']
    speed[2000:2600] = speed[2000] if value is None else value
    mended, notes = without_faults(TIME, spoilt)
    assert np.isnan(mended['motor_speed'][2001:2600]).all()
    assert np.isnan(mended['motor_speed']).sum() <= 603
    assert len(notes) == 1 and notes[0].startswith('motor_speed: stands still')


def test_a_sensor_that_froze_early_is_left_out_from_there_on():
    spoilt = sensors(4)
    spoilt['motor_speed'][2000:] = spoilt['motor_speed'][2000]
    mended, notes = without_faults(TIME, spoilt)
    assert np.isnan(mended['motor_speed'][2001:]).all()
    assert np.isnan(mended['motor_speed']).sum() <= 4003 and len(notes) == 1


def test_what_stood_at_the_end_of_its_range_is_known_in_no_row_there():
    """Where it comes and goes slowly, too, and in single rows."""
    spoilt = sensors(6)
    true = spoilt['load_torque']
    spoilt['load_torque'] = np.minimum(true, 215.0)
    mended, notes = without_faults(TIME, spoilt)
    assert np.array_equal(np.isnan(mended['load_torque']), true >= 215.0)
    assert len(notes) == 1 and notes[0].startswith('load_torque: stands still')


@pytest.mark.parametrize('sign', (1.0, -1.0))
def test_what_saturates_slowly_is_known_in_no_row_there(sign):
    """A flow meter that ends below what passes it: it comes there and goes without a jump."""
    noise = 0.05 * np.random.default_rng(10).standard_normal(6000)
    true = 40.0 + 12.0 * np.sin(0.7 * TIME) + noise
    mended, notes = without_faults(TIME, {'motor_inlet_flow': sign * np.minimum(true, 48.0)})
    assert np.array_equal(np.isnan(mended['motor_inlet_flow']), true >= 48.0)
    assert len(notes) == 1 and 'saturated' in notes[0]


def test_what_moves_without_noise_may_stay_where_it_ends():
    """Oil that has warmed up; a plate at full stroke."""
    oil = 40.0 + np.minimum(TIME, 30.0) / 3.0
    assert find_faults(TIME, {'oil_temperature': oil}) == {}


def test_a_cable_that_was_off_takes_no_rest_of_the_drive_with_it():
    spoilt = sensors(4)
    speed = spoilt['motor_speed']
    speed[:] = np.round(speed * np.clip(np.abs(TIME - 8.0) - 2.0, 0.0, 1.0), 1)  # rests 6 to 10 s
    rest = np.flatnonzero(speed[:1200] == 0.0)
    speed[2000:2300] = 0.0
    mended, _ = without_faults(TIME, spoilt)
    assert np.isnan(mended['motor_speed'][2000:2300]).all() and len(rest) > 300
    assert not np.isnan(mended['motor_speed'][rest]).any()


def test_a_drive_at_rest_and_a_slow_thermometer_are_not_frozen():
    readings = sensors(5)
    speed = readings['motor_speed']
    speed[:] = np.round(speed * np.clip((TIME - 5.0) / 3.0, 0.0, 1.0), 1)
    oil = np.round(np.repeat(np.linspace(40.0, 60.0, 60), 100), 1)
    assert find_faults(TIME, {**readings, 'oil_temperature': oil}) == {}


@pytest.mark.parametrize('made', ('coarse', 'dead band', 'slow'))
def test_a_coarse_or_slow_sensor_is_not_frozen(made):
    """Steps of ten times the noise, a logger of large changes, a reading in two seconds."""
    for name, values in sensors(6).items():
        step = 10.0 * {'pump_outlet_pressure': 0.12, 'motor_speed': 0.15, 'load_torque': 0.5}[name]
        told = values.copy()
        for i in range(1, len(told)):
            told[i] = values[i] if abs(values[i] - told[i - 1]) > 0.5 * step else told[i - 1]
        read = np.cumsum(np.random.default_rng(7).integers(1, 400, 60))
        late = read[np.searchsorted(read, np.arange(6000), side='right') - 1].clip(0, 5999)
        readings = {'coarse': np.round(values / step) * step, 'dead band': told,
                    'slow': values[late]}[made]
        assert find_faults(TIME, {name: readings}) == {}


def test_short_loads_on_coarse_sensors_are_no_spikes():
    """Two samples of 20 bar and 40 N.m every 5 s, each sensor with steps larger than its noise."""
    readings = sensors(8)
    pulse = (np.arange(6000) % 500 >= 498).astype(float)
    noise = 0.2 * np.random.default_rng(8).standard_normal((2, 6000))
    readings = {'pump_outlet_pressure': np.round(100.0 + 20.0 * pulse + noise[0]),
                'load_torque': 5.0 * np.round(40.0 + 8.0 * pulse + noise[1]),
                'motor_speed': readings['motor_speed']}
    assert find_faults(TIME, readings) == {}


@pytest.mark.slow
def test_a_bit_that_sticks_and_slips_has_no_spikes():
    """The generator's drive with four times the usual Stribeck friction."""
    from test.truth import make_campaign
    made = make_campaign(4246, {'stribeck_friction': 4.0}, rate_hz=200.0, logs=('speed_sweep',))
    log = {name.split('[')[0]: values for name, values in made.logs['speed_sweep'].items()}
    assert np.sum(np.diff(np.sign(log['motor_speed'] - 5.0)) != 0) > 10
    assert find_faults(log.pop('time'), {name: values for name, values in log.items()
                                         if CHANNELS[name].hold == 'linear'}) == {}


def test_a_coarse_sensor_of_a_slow_logger_is_not_frozen():
    """A reading a second, in steps of about the noise, each load for half a minute."""
    random = np.random.default_rng(9)
    load = np.repeat(random.uniform(50.0, 90.0, 40), 30)
    readings = np.round(load + 0.2 * random.standard_normal(1200))
    assert find_faults(np.arange(1200.0), {'pump_outlet_pressure': readings}) == {}
