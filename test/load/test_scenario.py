# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenario files: the shipped ones, and every slip as one line that says what to mend."""
import copy
import math
from pathlib import Path

from hst_drive.errors import InputError
from hst_drive.load import load_scenario, LoadingUnit, parse_scenario, shipped_scenarios
from hst_drive.rig import default_rig
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

RPM = math.pi / 30.0
MADE_UP = Path(__file__).with_name('made_up_mud_log.csv')
UNIT = LoadingUnit.of(default_rig().loading)
GOOD = {
    'title': 'A test', 'duration_s': 10, 'seed': 2, 'speed_setpoint': {'speed_rpm': 100},
    'load': {'kind': 'ground', 'start_s': 1, 'bit_diameter_mm': 76, 'penetration_rate_m_h': 6,
             'layers': [{'rock': 'coal', 'thickness_mm': 9, 'roughness': 0.1}]},
    'oil_temperature': {'temperature_degC': 50},
    'hidden_effects': {'bearing_friction': {'torque': '12 N.m', 'other': 3.0}},
}


def changed(path, value):
    """Return GOOD with one value changed, or the key removed for Ellipsis."""
    content = copy.deepcopy(GOOD)
    *above, last = path
    place = content
    for key in above:
        place = place[key]
    if value is ...:
        del place[last]
    else:
        place[last] = value
    return content


@pytest.mark.parametrize('name', sorted(shipped_scenarios()))
def test_shipped_scenarios(name):
    """Each loads, is the same twice, stays inside the commands' range and can be reached."""
    if name.startswith('real_log_') or name == 'recorded':
        pytest.skip('needs a log of its own kind; see test_drilling_log.py, test_recorded.py')
    if name == 'reverse':
        pytest.skip('needs a closed circuit; see test/nodes/test_closed_circuit.py')
    log = MADE_UP if name == 'real_log' else None
    one, two = load_scenario(name, log=log), load_scenario(name, log=log)
    times = np.arange(0.0, one.duration, 0.01)
    commands = [one.load.pprv_command(t) for t in times]
    assert commands == [two.load.pprv_command(t) for t in reversed(times.tolist())][::-1]
    assert 0.0 <= min(commands) and max(commands) <= 10.0 and np.ptp(commands) > 1.0
    assert not any('of the run' in note for note in one.notes)
    assert (one.pump_command is None) == (one.mode == 'closed_loop')
    assert 270.0 < one.oil_temperature(0.0) < 350.0


def test_step_of_the_paper():
    load = load_scenario('paper_step').load
    assert UNIT.torque_of_command(load.pprv_command(16.51), 100 * RPM) == pytest.approx(223.5)
    assert UNIT.torque_of_command(load.pprv_command(16.52), 100 * RPM) == pytest.approx(241.1)


def test_good_scenario_in_si():
    scenario = parse_scenario(GOOD, UNIT)
    assert scenario.speed_setpoint(5.0) == pytest.approx(100 * RPM)
    assert scenario.oil_temperature(5.0) == pytest.approx(323.15)
    assert scenario.hidden_effects == {'bearing_friction': {'torque': 12.0, 'other': 3.0}}
    assert scenario.load.torque(0.5) == 0.0
    # Below the unit's least load (3 bar at this speed, 14.5 N m): held there, and said.
    assert any('least load' in note for note in scenario.notes)


def test_other_units_of_the_same_kind():
    content = changed(('duration_s',), ...)
    content['duration_min'] = 0.5
    content['speed_setpoint'] = {'speed_rad_s': 10.0}
    scenario = parse_scenario(content, UNIT)
    assert scenario.duration == pytest.approx(30.0)
    assert scenario.speed_setpoint(0.0) == pytest.approx(10.0)


@pytest.mark.parametrize('path, value, what', (
    (('titel',), 'x', "unknown key 'titel'; did you mean 'title'"),
    (('title',), ..., "'title' is missing"),
    (('duration_s',), -1, "'duration_s' is -1 s, expected 0.1 to"),
    (('duration_s',), 'long', "'duration_s' is 'long', expected a number in s"),
    (('duration_s',), True, 'expected a number'), (('duration_s',), 10**400, 'expected 0.1'),
    (('seed',), 1.5, 'whole number'),
    (('mode',), 'closed', "did you mean 'closed_loop'"),
    (('speed_setpoint',), ..., 'speed_setpoint'),
    (('speed_setpoint',), 100, 'expected a mapping'),
    (('speed_setpoint',), {'speed': 100}, "did you mean 'speed_rpm'"),
    (('speed_setpoint',), {'speed_rpm': 1e9}, 'check the value and its unit'),
    (('speed_setpoint',), {'speed_rpm': 100, 'speed_rad_s': 10}, 'keep one'),
    (('speed_setpoint',), {'kind': 'steps', 'time_s': [0, 1], 'speed_rpm': [1]}, 'as many'),
    (('speed_setpoint',), {'kind': 'steps', 'time_s': [1, 0], 'speed_rpm': [1, 2]}, 'rising'),
    (('load', 'kind'), 'grund', "did you mean 'ground'"),
    (('load', 'bit_diameter_mm'), 'wide', 'load.bit_diameter_mm'),
    (('load', 'eficiency'), 0.3, "did you mean 'efficiency'"),
    (('load', 'layers'), [], 'list of mappings'),
    (('load', 'layers', 0, 'rock'), 'cole', "did you mean 'coal'"),
    (('load', 'layers', 0, 'thickness'), 9, 'load.layers\\[0\\]'),
    (('load', 'layers', 0, 'ucs_bar'), 1e9, 'MPa'),
    (('load',), ..., 'exactly one of the two'),
    (('pprv_command',), {'command_V': 2}, 'exactly one of the two'),
    (('pump_command',), {'command_V': 2}, 'set mode: open_loop'),
    (('mode',), 'open_loop', 'open_loop needs it'),
    (('hidden_effects',), ['bearing_friction'], 'effect ids'),
    (('hidden_effects', 'bearing_friction', 'torque'), '12 Nmm', 'unknown unit'),
    (('hidden_effects', 'bearing_friction', 'torque'), 'much', 'expected a number in SI'),
    (('hidden_effects', 'bearing_friction', 'torque'), 10**400, 'expected a number in SI'),
))
def test_slips_get_one_line(path, value, what):
    with pytest.raises(InputError, match=what) as error:
        parse_scenario(changed(path, value), UNIT, 'mine.yaml')
    assert '\n' not in str(error.value) and str(error.value).startswith('mine.yaml')


JSON = st.recursive(st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
                    lambda inner: st.lists(inner, max_size=3)
                    | st.dictionaries(st.text(max_size=8), inner, max_size=3), max_leaves=5)


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(('title', 'duration_s', 'seed', 'speed_setpoint', 'load', 'mode', 'start',
                        'hidden_effects', 'oil_temperature', 'description')), JSON)
def test_anything_in_a_key_is_taken_or_refused_in_one_line(key, value):
    try:
        parse_scenario({**GOOD, key: value}, UNIT)
    except InputError as error:
        assert '\n' not in str(error)


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(sorted(GOOD['load'])), JSON)
def test_anything_in_the_load_is_taken_or_refused_in_one_line(key, value):
    try:
        parse_scenario({**GOOD, 'load': {**GOOD['load'], key: value}}, UNIT)
    except InputError as error:
        assert '\n' not in str(error)


def test_rock_outside_its_range_is_noted():
    notes = parse_scenario(changed(('load', 'layers', 0, 'ucs_MPa'), 200), UNIT).notes
    assert any('200 MPa is unusual for coal (25 to 50 MPa)' in note for note in notes)


def test_too_much_torque_is_noted():
    scenario = parse_scenario(changed(('load',), {'torque_N_m': 5000}), UNIT)
    assert scenario.load.pprv_command(3.0) == 10.0
    assert '5000 N.m asked' in scenario.notes[0] and '100 % of the run' in scenario.notes[0]


@pytest.mark.parametrize('name, what', (
    ('papier_step', "did you mean 'paper_step'"), ('nowhere.yaml', 'cannot be read'),
    ('real_log', "'load.file' is missing")))
def test_files_that_are_not_there(name, what):
    with pytest.raises(InputError, match=what):
        load_scenario(name)


def test_log_beside_the_scenario(tmp_path):
    (tmp_path / 'log.csv').write_text('time[s],torque[N.m]\n0,100\n10,200\n')
    (tmp_path / 'mine.yaml').write_text(
        'title: mine\nspeed_setpoint: {speed_rpm: 100}\n'
        'load: {kind: drilling_log, file: log.csv, torque_factor: 1}\n')
    scenario = load_scenario(tmp_path / 'mine.yaml')
    assert scenario.duration == 10.0
    assert scenario.load.torque(5.0) == pytest.approx(150.0)
    with pytest.raises(InputError, match='no_log.csv: cannot be read'):
        load_scenario(tmp_path / 'mine.yaml', log=tmp_path / 'no_log.csv')


def test_the_sum_of_temperatures_has_one_zero():
    wave = {'kind': 'sine', 'mean_temperature_degC': 0, 'amplitude_K': 5, 'frequency_Hz': 0.25}
    scenario = parse_scenario({**GOOD, 'oil_temperature': {
        'kind': 'sum', 'parts': [{'temperature_degC': 40}, wave]}}, UNIT)
    assert scenario.oil_temperature(1.0) == pytest.approx(318.15)
