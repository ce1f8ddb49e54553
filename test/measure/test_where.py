# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Regions that hold the error: planted ones are found, and none where there is none."""
from hst_drive.measure.run import Run
from hst_drive.measure.where import operating_variables, TRANSIENT, where
import numpy as np
import pytest

TIME = np.arange(6000) * 0.01
RANDOM = np.random.default_rng(1)
SPEED = 10 + 3 * np.sin(TIME / 3)
PRESSURE = 60e5 + 40e5 * np.sin(TIME / 2.3 + 1)
VARIABLES = {'motor_speed': [SPEED], 'pump_outlet_pressure': [PRESSURE],
             'pump_command': [np.full(6000, 5.0)]}
NOISE = RANDOM.standard_normal(6000)


def test_a_planted_region_is_the_first():
    error = NOISE + 8.0 * (SPEED > 11.5)
    regions = where({'motor_inlet_flow': [error]}, VARIABLES, {'motor_inlet_flow': 1.0})
    first = regions[0]
    assert (first.signal, first.variable, first.unit) == ('motor_inlet_flow', 'motor_speed',
                                                          'rad/s')
    assert first.low == pytest.approx(11.5, abs=0.6) and first.high == pytest.approx(13, abs=0.1)
    assert first.share_of_error > 0.9 and first.share_of_time < 0.45
    assert first.explained > 0.8
    # A command that never moved says nothing.
    assert 'pump_command' not in {region.variable for region in regions}


def test_an_error_that_grows_with_pressure_is_explained_by_pressure():
    error = NOISE + 10 * ((PRESSURE - 60e5) / 40e5)**3
    regions = where({'motor_speed': [error]}, VARIABLES, {'motor_speed': 1.0})
    assert regions[0].variable == 'pump_outlet_pressure' and regions[0].explained > 0.7


def test_no_region_where_the_model_reaches_the_floor_or_the_error_is_even():
    assert where({'motor_speed': [NOISE]}, VARIABLES, {'motor_speed': 1.0}) == []
    assert where({'motor_speed': [NOISE + 20]}, VARIABLES, {'motor_speed': 1.0}) == []


def test_an_error_that_is_spread_out_or_hardly_crowded_is_not_listed():
    # A tenth more than its share says nothing; a sine of no variable neither.
    error = NOISE * np.where(SPEED > 11.5, 1.3, 1.0)
    assert where({'motor_speed': [3 * error]}, VARIABLES, {'motor_speed': 1.0}) == []
    assert where({'motor_speed': [5 * np.sin(40 * TIME)]}, VARIABLES, {'motor_speed': 1.0}) == []


def test_an_error_of_either_sign_is_listed_where_it_is_crowded():
    error = NOISE * np.where(SPEED > 12, 10.0, 1.0)
    region = where({'motor_speed': [error]}, VARIABLES, {'motor_speed': 1.0})[0]
    assert region.variable == 'motor_speed' and region.explained < 0.05
    assert region.share_of_error > 0.8 and region.share_of_time == pytest.approx(0.25)


def test_the_most_telling_comes_first_and_steady_oil_tells_nothing():
    variables = {**VARIABLES, 'oil_temperature': [323.0 + 0.1 * (SPEED - 10)]}
    errors = {'motor_inlet_flow': [NOISE + 3.0 * (SPEED > 11.5)],
              'motor_speed': [NOISE + 30.0 * (SPEED > 11.5)]}
    regions = where(errors, variables, dict.fromkeys(errors, 1.0))
    assert [region.signal for region in regions[:2]] == ['motor_speed', 'motor_inlet_flow']
    assert {region.variable for region in regions} == {'motor_speed'}


def test_several_logs_and_gaps():
    error = NOISE + 8.0 * (SPEED > 11.5)
    error[100:200] = np.nan
    halves = {name: [columns[0][:3000], columns[0][3000:]] for name, columns in VARIABLES.items()}
    regions = where({'motor_speed': [error[:3000], error[3000:]]}, halves, {'motor_speed': 1.0})
    assert regions[0].variable == 'motor_speed'
    assert where({'motor_speed': [np.full(3000, np.nan)] * 2}, halves, {'motor_speed': 1.0}) == []


def test_transients_are_told_from_steady_running():
    pressure = 60e5 + 20e5 * ((TIME / 5).astype(int) % 2)
    run = Run('a', TIME, {'pump_outlet_pressure': pressure, 'motor_speed': SPEED})
    variables = operating_variables(run)
    assert variables[TRANSIENT].max() > 5e6
    error = NOISE + 15 * (variables[TRANSIENT] > 1e6)
    regions = where({'motor_speed': [error]}, {name: [v] for name, v in variables.items()},
                    {'motor_speed': 1.0})
    assert regions[0].variable == TRANSIENT and regions[0].unit == 'Pa/s'


def test_variables_bridge_gaps():
    speed = SPEED.copy()
    speed[50:60] = np.nan
    found = operating_variables(Run('a', TIME, {'motor_speed': speed}))
    assert found.keys() == {'motor_speed'} and np.isfinite(found['motor_speed']).all()
