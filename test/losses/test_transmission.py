# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Transmissions at one test point: made-up ones, and the 400 real ones."""
from hst_drive.bag.bench_table import read_points
from hst_drive.errors import InputError
from hst_drive.losses.transmission import transmissions
from hst_drive.resources import share
import numpy as np
import pytest

from .tables import SHARED

REAL = SHARED / 'real' / 'hst_endofline_tests' / 'hst_196cc_tests.csv'
RPM = np.pi / 30


def made(count=300, wrong=None):
    """Return columns of units that leak 10 +- 0.5 % of the flow, read to 0.2 %."""
    rng = np.random.default_rng(3)
    leak = 0.10 * (1 + 0.05 * rng.normal(size=count))
    columns = {'pump_speed': np.full(count, 1500.0 * RPM)}
    for name in ('motor_speed', 'motor_speed_reverse'):
        columns[name] = 1500.0 * RPM * (1 - leak * (1 + 0.02 * rng.normal(size=count)))
    if wrong is not None:
        columns['motor_speed'][wrong] -= 1000.0 * RPM
    return transmissions(columns, {name: name for name in columns}, np.arange(count) + 2,
                         {'pump_displacement': 2e-5, 'motor_displacement': 2e-5,
                          'supply_pressure': 200e5}, 'made.csv')


def test_leakage_and_scatter_come_back():
    found = made()
    assert found.leakage_share.median == pytest.approx(0.10, rel=0.02)
    flow = 2e-5 * 1500 * RPM * 0.10
    assert found.leakage.median == pytest.approx(flow, rel=0.02)
    assert found.conductance.median == pytest.approx(flow / 200e5, rel=0.02)
    assert found.unit_scatter == pytest.approx(0.05, rel=0.2)
    assert found.repeatability == pytest.approx(0.02, rel=0.25)
    assert not found.outliers and 'torque losses' in found.not_determinable


@pytest.mark.parametrize('given', ['pump_displacement', 'motor_displacement'])
def test_one_displacement_stands_for_both(given):
    columns = {'pump_speed': np.full(8, 100.0), 'motor_speed': np.full(8, 90.0)}
    found = transmissions(columns, {name: name for name in columns}, np.arange(8), {given: 3e-5},
                          'made.csv')
    assert found.loss_free_speed == pytest.approx(100.0)
    assert found.leakage.median == pytest.approx(3e-4)
    assert found.speed_error_over_measured == pytest.approx(100.0 / 90.0 - 1.0)
    assert found.speed_error_over_loss_free == pytest.approx(1.0 - 90.0 / 100.0)


@pytest.mark.parametrize('name, value', [
    ('motor_displacement', 0.0), ('supply_pressure', 0.0), ('supply_pressure', -5e5)])
def test_a_constant_that_cannot_be_is_refused_like_a_cell(name, value):
    columns = {'pump_speed': np.full(8, 100.0), 'motor_speed': np.full(8, 90.0)}
    with pytest.raises(InputError, match=f'constants.{name}: found {value:.6g} '):
        transmissions(columns, {name: name for name in columns}, np.arange(8),
                      {'pump_displacement': 3e-5, name: value}, 'made.csv')


def test_a_wrong_digit_is_named_by_its_row():
    found = made(wrong=40)
    assert [(entry.line, entry.column) for entry in found.outliers] == [(42, 'motor_speed')]
    assert 'perhaps' in found.outliers[0].guess
    assert found.leakage_share.median == pytest.approx(made().leakage_share.median, rel=1e-3)


@pytest.mark.skipif(not REAL.exists(), reason='the shared recordings are not there')
def test_real_transmissions():
    table = read_points(REAL, share('config', 'channels_hst_endofline.yaml'))
    found = transmissions(table.columns, table.headers, table.lines, table.constants,
                          table.source)
    # SOURCE.txt: 1780 rpm predicted, 1574 +- 11 rpm measured, 6.7e-4 m^3/s, 3.5e-11 m^3/(s Pa).
    assert found.units == 400
    assert found.loss_free_speed / RPM == pytest.approx(1780.0)
    assert found.speed.median / RPM == pytest.approx(1574.0, abs=1.0)
    assert found.speed.sd / RPM == pytest.approx(11.0, abs=1.0)
    assert found.leakage.median == pytest.approx(6.7e-4, rel=0.01)
    assert found.conductance.median == pytest.approx(3.5e-11, rel=0.01)
    assert found.unit_scatter == pytest.approx(0.055, abs=0.006)
    assert [(entry.line, round(entry.value / RPM)) for entry in found.outliers] == [(218, 568)]
