# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The PI law against hand-worked numbers, closed forms and the rig's recordings."""
import csv
import math
from pathlib import Path

from hst_drive.control import PiController, PumpFeedForward
from hypothesis import given, strategies as st
import numpy as np
import pytest

RECORDED = Path(__file__).resolve().parents[3] / 'shared' / 'cases'
DATASHEET = {'kp': 0.02, 'ki': 0.45, 'sample_time': 0.01, 'limits': (0.0, 10.0)}
RPM = math.pi / 30.0

# Set point and reading in rpm, command in V, worked by hand from the law: row n is
# 0.02 e_n + 0.0045 (e_0 + ... + e_(n-1)), e in rad/s.
BY_HAND = ((100.0, 0.0, 0.20943951), (100.0, 1.1, 0.25425957), (100.0, 1.5, 0.30002734),
           (100.0, 2.0, 0.34539717), (100.0, 110.0, 0.16538391))


def test_law_by_hand():
    control = PiController(**DATASHEET)
    for setpoint, measured, command in BY_HAND:
        assert control.update(setpoint * RPM, measured * RPM) == pytest.approx(command, abs=1e-8)


@given(st.floats(-50, 50), st.floats(0, 1), st.floats(0, 5), st.integers(1, 200))
def test_constant_error_has_closed_form(error, kp, ki, count):
    control = PiController(kp, ki, 0.01, (-1e6, 1e6))
    for _ in range(count):
        command = control.update(error, 0.0)
    assert command == pytest.approx(kp * error + ki * 0.01 * (count - 1) * error, abs=1e-9)


@pytest.mark.skipif(not RECORDED.is_dir(), reason='no recordings beside the repository')
@pytest.mark.parametrize('name', ('drilling.csv', 'drilling_holdout.csv', 'speed_sweep.csv'))
def test_reproduces_recorded_command(name):
    with (RECORDED / 'no_effect' / name).open() as file:
        rows = list(csv.DictReader(file))
    control = PiController(**DATASHEET)
    replayed = np.array([control.update(float(row['speed_setpoint[rpm]']) * RPM,
                                        float(row['motor_speed[rpm]']) * RPM) for row in rows])
    recorded = np.array([float(row['pump_command[V]']) for row in rows])
    step = 10.0 / 4096.0
    # Half a step is the recording's rounding; the rounding of the speed reading (0.05 rpm)
    # walks randomly through the integral: 0.0045 * 0.0052 / sqrt(12) * sqrt(6000) = 0.5 mV.
    assert np.abs(replayed - recorded).max() < step
    assert np.std(replayed - recorded) < 1.2 * step / math.sqrt(12.0)


@given(st.lists(st.floats(-30, 30), min_size=1, max_size=200),
       st.sampled_from(('conditional_integration', 'back_calculation', 'none')))
def test_command_stays_inside_limits(errors, strategy):
    control = PiController(0.5, 20.0, 0.01, (0.0, 10.0), antiwindup_strategy=strategy)
    assert all(0.0 <= control.update(error, 0.0) <= 10.0 for error in errors)


@pytest.mark.parametrize('strategy, longest', (
    ('conditional_integration', 1), ('back_calculation', 3), ('none', 10000)))
def test_antiwindup_leaves_the_limit(strategy, longest):
    """After a long saturation, count samples until the command leaves its limit."""
    control = PiController(0.02, 0.45, 0.01, (0.0, 10.0), antiwindup_strategy=strategy)
    for _ in range(5000):
        control.update(10.0, 0.0)
    assert control.command == 10.0
    count = 0
    while control.update(0.0, 5.0) == 10.0:
        count += 1
    assert count <= longest
    assert (count > 100) == (strategy == 'none')


def test_held_integral_cannot_lock_the_command():
    """An integral beyond the limit unwinds although the command is clipped."""
    control = PiController(0.02, 0.45, 0.01, (0.0, 10.0))
    for _ in range(5000):
        control.update(12.0, 0.0)
    control.integral = 10.1
    for _ in range(200):
        control.update(0.0, 1.0)
    assert control.command < 10.0


@given(st.floats(0, 10), st.floats(0, 20), st.floats(0, 20))
def test_bumpless_reset(output, setpoint, measured):
    control = PiController(**DATASHEET)
    control.reset(output)
    assert control.update(setpoint, measured) == pytest.approx(output, abs=1e-12)


def test_reading_that_drops_out_holds_command():
    control = PiController(**DATASHEET)
    control.update(10.0, 8.0)
    command, integral = control.command, control.integral
    assert control.update(10.0, math.nan) == command
    assert control.integral == integral
    assert math.isfinite(control.update(10.0, 8.0))


def test_setpoint_rate_limit():
    control = PiController(1.0, 0.0, 0.1, (-100.0, 100.0), setpoint_rate_limit=5.0)
    commands = [control.update(10.0, 0.0) for _ in range(30)]
    assert commands[:4] == pytest.approx([0.5, 1.0, 1.5, 2.0])
    assert commands[-1] == pytest.approx(10.0)


def test_feed_forward_inverts_the_pump_table():
    volts = np.array([0.0, 1.2, 1.8, 3.0, 5.0, 7.0, 9.0, 10.0])
    rev = 2.0 * math.pi
    table = np.array([0.0, 0.0, 0.95, 4.88, 11.5, 18.1, 24.7, 28.0]) * 1e-6 / rev
    forward = PumpFeedForward(volts, table, 1450 * RPM, 195e-6 / rev)
    for speed in np.linspace(0.1, 200.0, 50) * RPM:
        flow = np.interp(forward(speed), volts, table) * 1450 * RPM
        assert flow == pytest.approx(195e-6 / rev * speed, rel=1e-9)
    assert forward(0.0) == 0.0
    assert forward(1e-9) == pytest.approx(1.2, abs=1e-6)
    # 100 rpm without leakage: just below the 5.601 V of the drill-drive paper.
    assert 5.5 < forward(100 * RPM) < 5.601
    control = PiController(**DATASHEET, feed_forward=forward)
    assert control.update(100 * RPM, 100 * RPM) == pytest.approx(forward(100 * RPM))


@pytest.mark.parametrize('change', (
    {'kp': -1.0}, {'ki': math.nan}, {'sample_time': 0.0}, {'limits': (5.0, 5.0)},
    {'antiwindup_strategy': 'legacy'}, {'setpoint_rate_limit': 0.0},
    {'tracking_time_constant': 1e-4}))
def test_nonsense_is_refused(change):
    with pytest.raises(ValueError, match='expected'):
        PiController(**{**DATASHEET, **change})
