# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The section 'commissioned' of a rig file: numbers in SI, and one clear line for every slip."""
import copy

from hst_drive.errors import InputError
from hst_drive.resources import share
from hst_drive.rig import parse_rig
import pytest
import yaml

GOOD = {
    'sigma_relative': {'motor.leakage': 0.01, 'motor.displacement': 0.001},
    'correlation': [[1.0, -0.5], [-0.5, 1.0]], 'day_to_day_share_of_tolerance': 0.1,
    'conditions': {'motor_inlet_pressure_bar': [10, 150], 'oil_temperature_degC': [30, 50]}}


def rig(section):
    """Return the shipped rig with this section."""
    content = yaml.safe_load(share('config', 'rig', 'test_rig.yaml').read_text())
    return parse_rig({**content, 'calibration': {}, 'commissioned': section}, 'unit.yaml')


def test_numbers_arrive_in_si_and_stand_in_the_place_of_tolerances():
    read = rig(GOOD)
    assert read.fingerprint.conditions == {
        'motor_inlet_pressure': pytest.approx((10e5, 150e5)),
        'oil_temperature': pytest.approx((303.15, 323.15))}
    assert read.fingerprint.correlation['motor.leakage', 'motor.displacement'] == -0.5
    assert read.scatter['motor.leakage'] == 0.01
    assert read.scatter['pump.leakage'] == read.tolerances['pump.leakage'] == 0.08
    assert read.digest != rig({**GOOD, 'day_to_day_share_of_tolerance': 0.2}).digest


def test_zeros_arrive_in_si_and_are_tied_to_the_quantities():
    read = rig({**GOOD, 'zeros': {'motor_inlet_pressure_bar': [-0.5, 0.1]}, 'correlation': [
        [1.0, -0.5, 0.2], [-0.5, 1.0, 0.0], [0.2, 0.0, 1.0]]})
    assert read.zeros == {'motor_inlet_pressure': pytest.approx(-0.5e5)}
    assert read.fingerprint.zeros['motor_inlet_pressure'][1] == pytest.approx(0.1e5)
    assert read.fingerprint.correlation['motor_inlet_pressure', 'motor.leakage'] == 0.2
    assert rig(GOOD).zeros == {}


def test_how_far_starts_are_off_arrives_in_si():
    read = rig({**GOOD, 'start_error': {'motor_inlet_pressure_bar': 0.5, 'motor_speed_rpm': 30}})
    assert read.fingerprint.starts == {'motor_inlet_pressure': pytest.approx(0.5e5),
                                       'motor_speed': pytest.approx(3.14159, 1e-5)}
    assert rig(GOOD).fingerprint.starts == {}


@pytest.mark.parametrize('path, value, said', [
    ('sigma_relative', [1], 'expected a mapping'),
    ('sigma_relative', {'motor.leak': 1}, "unknown key 'commissioned.sigma_relative.motor.leak'"),
    ('sigma_relative', {'motor.leakage': 0}, "sigma_relative.motor.leakage' is 0"),
    ('correlation', [[1.0]], 'no table of 2 rows'),
    ('correlation', [[1.0, 2.0], [2.0, 1.0]], "correlation[0][1]' is 2.0"),
    ('correlation', [[1.0, 0.5], [0.4, 1.0]], 'is no correlation'),
    ('correlation', [[1.0, 1.0], [1.0, 1.0]], 'is no correlation'),
    ('correlation', [[1.0, float('nan')], [0.4, 1.0]], "correlation[0][1]' is nan"),
    ('day_to_day_share_of_tolerance', 'much', "is 'much', expected a number"),
    ('conditions', {'motor_speed': [0, 1]}, "unknown key 'commissioned.conditions.motor_speed'"),
    ('conditions', {'motor_speed_rpm': [9]}, 'expected [low, high]'),
    ('conditions', {'motor_speed_rpm': [9, 1]}, 'expected low below high'),
    ('zeros', {'motor_speed': [0, 1]}, "unknown key 'commissioned.zeros.motor_speed'"),
    ('zeros', {'motor_speed_rpm': [9]}, 'expected [zero, sigma]'),
    ('zeros', {'motor_speed_rpm': [9, 0]}, "zeros.motor_speed_rpm' is 0, expected a number"),
    ('zeros', {'motor_speed_rpm': [9, 1]}, 'no table of 3 rows'),
    ('start_error', {'motor_speed': 1}, "unknown key 'commissioned.start_error.motor_speed'"),
    ('start_error', {'motor_speed_rpm': [1]}, "start_error.motor_speed_rpm' is [1], expected a n"),
    ('zeros', {'motor_speed_rpm': [9, 1]}, "each entry of 'sigma_relative' and 'zeros'"),
    ('sigma', {}, "unknown key 'commissioned.sigma'"), ('conditions', None, 'mapping')])
def test_a_slip_is_told_in_one_line(path, value, said):
    content = {**copy.deepcopy(GOOD), path: value}
    with pytest.raises(InputError) as problem:
        rig(content)
    assert said in str(problem.value) and str(problem.value).startswith('unit.yaml: ')
    assert '\n' not in str(problem.value)


@pytest.mark.parametrize('key', GOOD)
def test_a_missing_key_is_told(key):
    with pytest.raises(InputError, match=f'commissioned.{key}.* is missing'):
        rig({name: value for name, value in GOOD.items() if name != key})


def test_a_machine_without_its_factors_is_none():
    content = yaml.safe_load(share('config', 'rig', 'test_rig.yaml').read_text())
    with pytest.raises(InputError, match="^unit.yaml: key 'calibration' is missing"):
        parse_rig({**content, 'commissioned': GOOD}, 'unit.yaml')
