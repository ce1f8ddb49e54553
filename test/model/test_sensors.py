# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Sensors: noise, steps and range of the readings, and the same again from the same seed."""
from dataclasses import replace

from hst_drive.model import SensorBank
from hst_drive.rig import default_rig
import numpy as np
import pytest

RIG = default_rig()
TRUE = {'pump_outlet_pressure': 82e5, 'motor_inlet_flow': 3.3e-4, 'motor_speed': 10.4,
        'load_torque': 223.5, 'oil_temperature': 323.0}


@pytest.mark.parametrize('name', TRUE)
def test_noise_and_resolution(name):
    sensor = RIG.sensors[name]
    readings = SensorBank(RIG, 1).read({name: np.full(40000, TRUE[name])})[name]
    # Rounding adds a uniform error of its own.
    want = np.sqrt(sensor.noise_std**2 + sensor.resolution**2 / 12)
    assert readings.std() == pytest.approx(want, rel=0.03)
    assert readings.mean() == pytest.approx(TRUE[name], abs=0.05 * want)
    steps = readings / sensor.resolution
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


def test_range_is_kept():
    low, high = RIG.sensors['pump_outlet_pressure'].range
    values = np.repeat([-0.9e5, 230e5], 200)
    readings = SensorBank(RIG, 1).read({'pump_outlet_pressure': values})['pump_outlet_pressure']
    assert readings.min() == low == 0 and readings.max() == high == 200e5


def test_seed():
    first, again, other = (SensorBank(RIG, seed) for seed in (7, 7, 8))
    a, b, c = ([bank.read(TRUE) for _ in range(3)] for bank in (first, again, other))
    assert a == b != c
    assert a[0] != a[1]
    assert all(isinstance(value, float) for value in a[0].values())


def test_only_what_a_sensor_watches_is_read():
    assert SensorBank(RIG, 1).read({'motor_speed': 1.0, 'relief_flow': 1.0}).keys() == {
        'motor_speed'}
    assert SensorBank(replace(RIG, sensors={}), 1).read(TRUE) == {}
