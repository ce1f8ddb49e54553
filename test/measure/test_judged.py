# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which seconds count: start from rest and cavitation do not, and no mask hides an error."""
from pathlib import Path

from hst_drive.bag import read_log
from hst_drive.measure.compare import compare
from hst_drive.measure.judged import judged, MOST, start_of
from hst_drive.measure.run import Run
from hst_drive.model import Drive
from hst_drive.rig import default_rig
import numpy as np
import pytest

from .synthetic import record

TIME = np.arange(6000) * 0.01
SAMPLES = Path(__file__).resolve().parents[3] / 'shared' / 'cases'
LOGS = ('drilling', 'speed_sweep', 'open_loop', 'drilling_holdout')


def run(*, speed=None, pressure=None, time=TIME):
    """Return a recording of two signals."""
    return Run('a', time, {
        'motor_speed': np.full(len(time), 10.0) if speed is None else speed,
        'pump_outlet_pressure': np.full(len(time), 60e5) if pressure is None else pressure})


def test_a_recording_that_starts_running_counts_whole():
    assert judged(run()).samples.all() and judged(run()).left_out == ()
    gaps = np.where(TIME % 0.2 < 0.02, np.nan, 10.0)
    assert judged(run(speed=gaps)).samples.all()


@pytest.mark.parametrize('seconds, left_out', [(0.5, 0.0), (3.0, 4.0)])
def test_what_follows_a_command_that_was_not_read_is_left_out(seconds, left_out):
    command = np.where((TIME >= 20.0) & (TIME < 20.0 + seconds), np.nan, 5.0)
    found = judged(Run('a', TIME, {**run().channels, 'pprv_command': command}))
    assert found.seconds_left_out == pytest.approx(left_out, abs=0.05)
    assert all(span.why == 'PPRV command missing' for span in found.left_out)


def test_start_and_cavitation_are_left_out_with_what_rings_after():
    speed = np.where(TIME < 1.5, 0.0, 10.0)
    pressure = np.where((TIME >= 20) & (TIME < 21), -1e5, 60e5)
    found = judged(run(speed=speed, pressure=pressure, time=TIME + 100))
    start, low = found.left_out
    assert (start.why, low.why) == ('start from rest', 'cavitation')
    # A second after the last sample at rest, or at low pressure; times as recorded.
    assert (start.start, start.end) == pytest.approx((100, 102.5), abs=0.011)
    assert (low.start, low.end) == pytest.approx((120, 122), abs=0.011)
    assert found.seconds_left_out == pytest.approx(4.5, abs=0.03)
    assert np.count_nonzero(~found.samples) == pytest.approx(450, abs=3)
    assert found.kept == {}


@pytest.mark.parametrize('breaks_away, rows', [(1.5, 251), (2.9, 0), (4.0, 0), (0.0, 0)])
def test_a_start_is_one_that_breaks_away_in_time(breaks_away, rows):
    speed = np.where(TIME < breaks_away, 0.0, 10.0)
    assert np.count_nonzero(start_of(run(speed=speed))) == pytest.approx(rows, abs=1)


def test_a_void_is_no_part_of_a_start():
    speed = np.where(TIME < 1.5, 0.0, 10.0)
    pressure = np.where((TIME > 1.0) & (TIME < 1.2), -0.5e5, 0.1e5)
    found = start_of(run(speed=speed, pressure=pressure))
    assert not found[(TIME > 1.0) & (TIME < 1.2)].any()
    assert found[(TIME < 1.0) | (TIME > 1.2) & (TIME < 2.4)].all()


def test_a_late_stop_counts():
    speed = np.where((TIME > 10) & (TIME < 20), 0.0, 10.0)
    assert judged(run(speed=speed)).samples.all()


@pytest.mark.parametrize('name', ['pump_command', 'speed_setpoint'])
def test_a_stop_that_was_asked_for_is_left_out(name):
    asked = np.where((TIME >= 10) & (TIME < 20), 0.1, 5.0)
    speed = np.where((TIME > 10.3) & (TIME < 20.5), 0.01, 10.0)
    stop, = judged(Run('a', TIME, {**run(speed=speed).channels, name: asked})).left_out
    assert (stop.start, stop.end, stop.why) == (
        pytest.approx(10.3, abs=0.021), pytest.approx(21.5, abs=0.021), 'stop')
    # A stall is not: more is asked for than it gives.
    stalled = Run('a', TIME, {**run(speed=speed).channels, name: np.full(len(TIME), 5.0)})
    assert judged(stalled).samples.all()


@pytest.mark.parametrize('first, last', [(0.0, 8.0), (20.0, 21.5), (40.0, 60.0)])
def test_a_load_is_not_judged_while_its_speed_was_not_read(first, last):
    lost = (TIME >= first) & (TIME < last)
    span, = judged(run(speed=np.where(lost, np.nan, 10.0))).left_out
    assert span.why == 'hydromotor speed missing'
    # Until a second after, when what it rang of has gone.
    assert (span.start, span.end) == pytest.approx((first, min(last + 1.0, 60.0)), abs=0.021)


def test_a_short_gap_of_the_speed_and_a_pause_of_the_record_count_whole():
    short = (TIME >= 20.0) & (TIME < 20.5)
    assert judged(run(speed=np.where(short, np.nan, 10.0))).samples.all()
    paused = np.where(TIME < 15.0, TIME, TIME + 10.0)
    assert judged(run(time=paused)).samples.all()
    assert judged(run(time=150.0 * TIME)).left_out == ()


def test_what_fills_the_recording_is_not_left_out():
    speed = np.where(TIME < 1.0, 0.0, 10.0)
    found = judged(run(speed=speed, pressure=np.where(TIME % 10 < 5, 0.0, 60e5)))
    assert [span.why for span in found.left_out] == ['start from rest']
    assert found.kept == {'cavitation': pytest.approx(0.6, abs=0.01)}
    short = run(speed=speed[:350], time=TIME[:350])
    assert judged(short).samples.all() and judged(short).kept.keys() == {'start from rest'}


@pytest.mark.needs_numba
def test_a_sensor_that_reads_zero_does_not_clear_itself():
    """An offset that takes most readings below the limit of cavitation is an error to show."""
    log = record(4)
    log.channels['pump_outlet_pressure'] = np.maximum(log['pump_outlet_pressure'] - 60e5, 0.0)
    assert np.mean(log['pump_outlet_pressure'] < 0.3e5) > MOST
    result = compare(Drive(default_rig()), [log])
    assert result.signals['pump_outlet_pressure'].noise_ratio > 50
    assert result.logs[0].judged.kept.keys() == {'cavitation'}


@pytest.mark.needs_numba
@pytest.mark.skipif(not SAMPLES.is_dir(), reason='the sample campaigns are not here')
@pytest.mark.parametrize('case', ['no_effect', 'foaming_oil', 'sticky_swash_plate', 'worn_motor'])
def test_samples(case):
    """Without an effect each log reaches its floor; with one each still shows it."""
    result = compare(Drive(default_rig()), [read_log(SAMPLES / case / f'{name}.csv')
                                            for name in LOGS])
    for log in result.logs:
        assert 1.0 < log.judged.seconds_left_out < 3.0
        assert 'start from rest' in log.judged.left_out[0].why
        ratios = [entry.noise_ratio for entry in log.signals.values()]
        if case == 'no_effect':
            assert 0.95 < min(ratios) and max(ratios) < 1.1
        else:
            assert max(ratios) > 3.5


@pytest.mark.needs_numba
@pytest.mark.skipif(not SAMPLES.is_dir(), reason='the sample campaigns are not here')
def test_all_seconds_are_judged_when_asked():
    log = read_log(SAMPLES / 'foaming_oil' / 'drilling.csv')
    whole = compare(Drive(default_rig()), [log], all_seconds=True)
    most = compare(Drive(default_rig()), [log])
    assert whole.signals['motor_speed'].samples == len(log)
    assert most.signals['motor_speed'].samples == np.count_nonzero(most.logs[0].judged.samples)
    assert whole.signals['motor_speed'].max_abs > 2 * most.signals['motor_speed'].max_abs
    assert whole.logs[0].judged.left_out == ()
