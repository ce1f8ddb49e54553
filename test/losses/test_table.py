# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A bench table that no motor can have measured."""
from hst_drive.effects.oil import viscosity
from hst_drive.errors import InputError
from hst_drive.losses.table import bench_of, COLUMNS, DRAIN
import numpy as np
import pytest

# A motor of 10 cc/rev that loses a tenth of the flow and of the torque.
DISPLACEMENT, PRESSURE = 10e-6 / (2 * np.pi), np.linspace(60e5, 180e5, 12)
SPEED = np.tile([80.0, 120.0], 6)
GOOD = {'motor_displacement': np.full(12, DISPLACEMENT), 'oil_temperature': np.full(12, 325.0),
        'load_torque': 0.9 * PRESSURE * DISPLACEMENT, 'motor_speed': SPEED,
        'supply_pressure': PRESSURE, 'supply_flow': SPEED * DISPLACEMENT / 0.9}


def read(columns):
    assert {*COLUMNS} <= {*columns} <= {*COLUMNS, DRAIN}
    return bench_of(columns, {name: name for name in columns}, np.arange(12) + 2, {}, 'bench.csv',
                    lambda kelvin: viscosity(kelvin, 'ISO VG 46'))


def test_a_possible_table_is_read():
    assert len(read(GOOD)) == 12


def test_two_small_motors_beside_a_large_one_are_two():
    size = np.repeat([1.0, 1.04, 50.0], 4)
    bench = read({**GOOD, **{name: GOOD[name] * size for name in (
        'motor_displacement', 'load_torque', 'supply_flow')}})
    _, sizes = bench.levels('size')
    assert sizes / DISPLACEMENT == pytest.approx([1.0, 1.04, 50.0])
    assert [bench.of_motor(found).sum() for found in sizes] == [4, 4, 4]


@pytest.mark.parametrize('change', [
    {'load_torque': GOOD['motor_speed'], 'motor_speed': GOOD['load_torque']},
    {'supply_flow': 0.85 * GOOD['supply_flow']},
    {'load_torque': 1.2 * GOOD['load_torque']},
    {'supply_flow': 3.785 * GOOD['supply_flow']},
    {'motor_speed': GOOD['motor_speed'] * 2 * np.pi / 60},
    {'case_drain_flow': 1.2 * GOOD['supply_flow']},
], ids=['torque and speed swapped', 'less flow than the motor takes', 'more torque than P D',
        'L/min as gpm', 'rad/s as rpm', 'more drain than flow'])
def test_what_no_motor_does_is_refused(change):
    """Each efficiency counts alone: losses of the one must not hide gains of the other."""
    with pytest.raises(InputError, match='bench.csv: .*check the units'):
        read({**GOOD, **change})
