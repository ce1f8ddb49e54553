# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Rig files: the shipped one, parts of one, and one clear line for every slip."""
import copy
import math
from pathlib import Path

from hst_drive.errors import InputError
from hst_drive.model import Drive, usual_sensors
from hst_drive.model.part import PartModel
from hst_drive.model.steady import operating_point
from hst_drive.resources import share
from hst_drive.rig import default_rig, load_rig, parse_rig
from hst_drive.rig.meanings import MEANINGS
from hst_drive.rig.schema import SECTIONS
import numpy as np
import pytest
import yaml

SHIPPED = share('config', 'rig', 'test_rig.yaml')
DATASHEET = Path(__file__).resolve().parents[3] / 'shared' / 'rig' / 'datasheet.yaml'
GOOD = yaml.safe_load(SHIPPED.read_text())
MISSING = object()


def changed(path, value):
    """Return the shipped rig with one entry replaced, added or (MISSING) taken out."""
    content = copy.deepcopy(GOOD)
    *parents, last = path.split('.')
    place = content
    for key in parents:
        place = place[key]
    if value is MISSING:
        del place[last]
    else:
        place[last] = value
    return content


def test_every_number_arrives_in_si():
    rig = default_rig()
    turn = 2 * math.pi
    assert rig.pump.shaft_speed == pytest.approx(1450 * turn / 60)
    assert rig.pump.max_displacement == pytest.approx(28e-6 / turn)
    assert rig.pump.displacement(3.0) == pytest.approx(4.88e-6 / turn)
    assert rig.pump.leakage(100e5, 5.0) == pytest.approx(0.398e-3 / 60)
    assert rig.motor.displacement == pytest.approx(195e-6 / turn)
    assert rig.motor.inertia == 0.35 and rig.motor.pistons == 7
    assert rig.motor.leakage(25e5, 50 * turn / 60) == pytest.approx(0.145e-3 / 60)
    assert rig.motor.mechanical_efficiency(60e5, 100 * turn / 60) == pytest.approx(0.863)
    assert (rig.line.bulk_modulus, rig.line.volume, rig.line.oil_density) == (1.2e9, 9e-4, 870)
    assert rig.relief_valve.set_pressure == rig.relief_valve.reference_pressure == 200e5
    assert rig.loading.pump_displacement == pytest.approx(10e-6 / turn)
    assert rig.loading.pprv_pressure(4.0) == pytest.approx(69e5)
    assert rig.loading.pump_mechanical_efficiency(40e5) == pytest.approx(0.85)
    assert rig.loading.pprv_override == pytest.approx(0.4e5 * 60e3)
    assert rig.loading.pprv_reference_flow == pytest.approx(20e-3 / 60)
    assert rig.controller.output_limits == (0, 10)
    assert rig.sensors['motor_speed'].noise_std == pytest.approx(0.15 * turn / 60)
    assert rig.sensors['pump_outlet_pressure'].range == (0, 200e5)
    assert rig.sensors['oil_temperature'].noise_std == 0.1
    assert rig.characterised_at == pytest.approx(323.15)


@pytest.mark.skipif(not DATASHEET.is_file(), reason='the datasheet is not here')
def test_shipped_rig_is_the_datasheet_number_by_number():
    sheet = yaml.safe_load(DATASHEET.read_text())
    assert {key: value for key, value in GOOD.items() if key != 'name'} == sheet
    assert load_rig(DATASHEET).pump.shaft_speed == default_rig().pump.shaft_speed


def test_tables_hold_their_ends_and_are_linear_between():
    curve, surface = default_rig().loading.pprv_pressure, default_rig().motor.leakage
    assert curve(-1.0) == pytest.approx(3e5) and curve(99.0) == pytest.approx(200e5)
    assert curve(3.0) == pytest.approx(48e5)
    assert surface(-1e5, 0.0) == 0 and surface(999e5, 999.0) == surface.z[-1, -1]
    middle = surface((surface.x[0] + surface.x[1]) / 2, (surface.y[2] + surface.y[3]) / 2)
    assert middle == pytest.approx(surface.z[:2, 2:4].mean())
    both = surface(np.array([25e5, 50e5]), np.array([0.0, 0.0]))
    np.testing.assert_allclose(both, surface.z[1:3, 0])


@pytest.mark.parametrize('path, value, expected', [
    ('pump.shaft_sped_rpm', 3, "unknown key 'pump.shaft_sped_rpm'; did you mean 'shaft_speed_r"),
    ('pumpp', {}, "unknown key 'pumpp'; did you mean 'pump'"),
    ('xyzzy', {}, "unknown key 'xyzzy'; known: pump, motor"),
    ('pump.shaft_speed_rad_s', 3, "write it as 'shaft_speed_rpm' (value x 9.5493)"),
    ('line.volume_L', 0.9, "'line.volume_L' has the wrong unit; write it as 'volume_m3' (value x "
     '0.001)'),
    ('relief_valve.set_pressure_psi', 3, "write it as 'set_pressure_bar' (value x 0.0689476)"),
    ('sensors.motor_speed.noise_std_rad_s', 1, "write it as 'noise_std_rpm'"),
    ('pump.shaft_speed_rpm', MISSING, "key 'pump.shaft_speed_rpm' is missing; add it"),
    ('motor.leakage_L_min.table', MISSING, "key 'motor.leakage_L_min.table' is missing"),
    ('sensors.motor_speed', {}, "key 'sensors.motor_speed.noise_std_rpm' is missing"),
    ('pump.shaft_speed_rpm', 'fast', "'pump.shaft_speed_rpm' is 'fast', expected a number in rpm"),
    ('pump.shaft_speed_rpm', True, 'is True, expected a number'),
    ('pump.shaft_speed_rpm', None, 'is empty, expected a number'),
    ('pump.shaft_speed_rpm', [1], 'is [1], expected a number'),
    ('pump.shaft_speed_rpm', math.nan, 'is nan rpm, outside the physical range 50 to 20000 rpm'),
    ('pump.shaft_speed_rpm', -math.inf, 'is -inf rpm, outside the physical range'),
    ('pump.shaft_speed_rpm', 10**400, 'outside the physical range'),
    ('line.volume_m3', 0, "'line.volume_m3' is 0 m^3, outside the physical range 1e-07 to 10"),
    ('motor.mechanical_efficiency.table', [[1.2] * 6] * 11, "table[0][0]' is 1.2, outside"),
    ('motor.pistons', 7.5, "'motor.pistons' is 7.5, expected a whole number"),
    ('pump.displacement_vs_command.command_V', [0, 1.2, 1.2, 3, 5, 7, 9, 10],
     "command_V[2]' is 1.2 after 1.2; expected strictly rising values"),
    ('pump.displacement_vs_command.displacement_cc_rev', [0, 0, 3, 2, 11, 18, 24, 28],
     "displacement_cc_rev[3]' is 2 after 3; expected values that do not fall"),
    ('pump.displacement_vs_command.displacement_cc_rev', [0, 1], 'has 2 values, expected 8'),
    ('loading.pprv_pressure_vs_command.command_V', [0], 'expected a list of at least 2 numbers'),
    ('motor.leakage_L_min', 'some', "'motor.leakage_L_min' is 'some', expected a number in L/min"),
    ('motor.leakage_L_min', [1, 2], "'motor.leakage_L_min' is [1, 2], expected a mapping"),
    ('motor.leakage_L_min', {'laminar_L_min_per_bar': 0.1, 'turbulent_per_bar': 1},
     "did you mean 'turbulent_L_min_per_sqrt_bar'"),
    ('motor.mechanical_efficiency', 1.2, "'motor.mechanical_efficiency' is 1.2, outside"),
    ('pump.displacement_vs_command', 5, "'pump.displacement_vs_command' is 5, expected a mapping"),
    ('motor.leakage_L_min.table', 5, "table' is 5, expected 7 rows"),
    ('motor.leakage_L_min.table', [[0, 1]], "table' has 1 rows, expected 7 rows: one for each "
     "value of 'pressure_bar'"),
    ('motor.leakage_L_min.table', [[0, 1]] * 7, "table[0]' has 2 values, expected 5"),
    ('motor.leakage_L_min.table', [[0] * 4 + ['x']] * 7, "table[0][4]' is 'x', expected a number"),
    ('line.oil_grade', 46, "'line.oil_grade' is 46, expected a text"),
    ('motor.leakage_L_min', {'laminar_L_min_per_br': 1}, "did you mean 'laminar_L_min_per_bar'"),
    ('motor.leakage_L_min', {'laminar_L_min_per_bar': 6.0},
     "'motor.leakage_L_min' gives 600 L/min at 100 bar and 100 rpm, outside"),
    ('motor.mechanical_efficiency', {'coulomb_N_m': 1e5}, 'gives 0.01 at 100 bar'),
    ('motor.mechanical_efficiency', {'pressure_share': 3}, 'gives 0.01 at 100 bar'),
    ('controller.output_limits_V', [10, 0], 'expected low below high'),
    ('controller.output_limits_V', 5, 'expected [low, high] in V'),
    ('sensors.motor_sped', {}, "did you mean 'motor_speed'"),
    ('sensors.pump_outlet_pressure.range_bar', [0, 'a'], "range_bar' is 'a', expected a number"),
    ('tolerances_1_sigma_relative', {'motor.displacment': 0.1}, "did you mean 'motor.displac"),
    ('tolerances_1_sigma_relative', {'motor.displacement': 3}, 'is 3, outside'),
    ('calibration', {'motor.inertia': 0}, "'calibration.motor.inertia' is 0, outside"),
    ('effects', [1], "'effects' is [1], expected effects by id"),
    ('effects', {'motor_leakage': 1}, "'effects.motor_leakage' is 1, expected parameters"),
    ('effects', {'motor_leakge': {}}, "'effects.motor_leakge'; did you mean 'motor_leakage'"),
    ('effects', {'bearing_friction': {'columb': 5}}, "umb'; did you mean 'coulomb'"),
    ('effects', {'bearing_friction': {'load_share': 0.1}},
     "key 'effects.bearing_friction.coulomb' is missing; add the effect's size, 0 to 500 N.m"),
    ('effects', {'bearing_friction': {'coulomb': '12 quux'}}, "with a unit of [N.m], as '12 N.m'"),
    ('effects', {'bearing_friction': {'coulomb': '12 bar'}}, "with a unit of [N.m], as '12 N.m'"),
    ('effects', {'bearing_friction': {'coulomb': 'nan N.m'}}, "is 'nan N.m', expected"),
    ('effects', {'bearing_friction': {'coulomb': math.nan}}, 'is nan N.m, outside the plausible'),
    ('effects', {'bearing_friction': {'coulomb': 10**400}}, 'outside the plausible range'),
    ('effects', {'motor_leakage': {'conductance': 10**400}}, 'outside the plausible range'),
    ('effects', {'motor_leakage': {'conductance': 1e-10}}, 'is 1e-10 m^3/(s.Pa) (0.6 L/min/bar), '
     'outside the plausible range 0 to 3e-11 m^3/(s.Pa) (0 to 0.18 L/min/bar); check'),
    ('effects', {'bearing_friction': {'coulomb': -3}},
     "'effects.bearing_friction.coulomb' is -3 N.m, outside the plausible range 0 to 500 N.m"),
    ('effects', {'bearing_friction': {'coulomb': '13 kN.m'}}, 'outside the plausible range'),
    ('effects', {'bearing_friction': {'coulomb': None}}, 'is empty, expected a number in N.m'),
    ('effects', {'bearing_friction': {'coulomb': True}}, 'is True, expected a number in N.m'),
    ('characterised_at_oil_temperature_degC', 'warm', "is 'warm', expected a number in degC"),
    ('provenance', 5, "'provenance' is 5, expected a mapping"),
])
def test_a_slip_gets_one_line_that_names_file_and_key(path, value, expected):
    with pytest.raises(InputError) as caught:
        parse_rig(changed(path, value), 'my_rig.yaml')
    message = str(caught.value)
    assert message.startswith('my_rig.yaml: ') and '\n' not in message
    assert expected in message
    assert len(message) < 260


@pytest.mark.parametrize('content, expected', [
    (b'', 'is empty; expected a mapping'),
    (b'# only a remark\n', 'is empty'),
    (b'- 1\n', 'found list, expected a mapping'),
    (b'pump', 'found str, expected a mapping'),
    (bytes(range(256)), 'is not a text file'),
    (b'pump: [1,\nmotor: 2', 'line 2: expected'),
    (b'pump:\n\tlag: 1\n', "line 2: found character '\\t'"),
    (b'pump: {shaft_speed_rpm: 1, shaft_speed_rpm: 2}',
     "line 1: key 'shaft_speed_rpm' is written twice; keep one"),
    (b'a: 1\n---\nb: 2\n', 'another document'),
    (b'a: &a [*a]', 'recursive'),
    (b'{[a]: 1}', 'a key must be a word'),
    (b'!!python/object:os.system {}', 'tag'),
    (b'[' * 3000, 'mend the YAML'),
    (b'pump: {shaft_speed_rpm: 2001-13-45}', 'mend the YAML'),
    (b'a: \x00', 'mend the YAML'),
    (b'name: just a name\n', 'no section of a rig found'),
])
def test_a_file_that_is_no_rig(tmp_path, content, expected):
    path = tmp_path / 'rig.yaml'
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_rig(path)
    assert str(caught.value).startswith(str(path)) and '\n' not in str(caught.value)
    assert expected.replace('\\\\', '\\') in str(caught.value)


@pytest.mark.parametrize('name, expected', [('', 'Is a directory'), ('none.yaml', 'No such file')])
def test_a_path_that_is_no_file(tmp_path, name, expected):
    with pytest.raises(InputError, match=expected):
        load_rig(tmp_path / name)


def test_numbers_may_be_written_as_everybody_writes_them(tmp_path):
    path = tmp_path / 'rig.yaml'
    path.write_text(SHIPPED.read_text().replace('area_m2: 1.6e-05', 'area_m2: 16e-6').replace(
        'bulk_modulus_Pa: 1200000000.0', 'bulk_modulus_Pa: 1.2E9'))
    rig = load_rig(path)
    assert rig.relief_valve.area == 1.6e-5 and rig.line.bulk_modulus == 1.2e9


def test_a_part_of_a_rig_loads_and_says_what_it_lacks():
    rig = parse_rig({'name': 'bench', 'motor': GOOD['motor']}, 'bench.yaml')
    assert rig.motor.displacement > 0 and rig.pump is None
    rig.require('motor', purpose='nothing')
    with pytest.raises(InputError) as caught:
        rig.require('motor', 'pump', purpose='a model of the whole drive')
    assert str(caught.value) == ("bench.yaml: section 'pump' is missing; a model of the whole "
                                 'drive needs it; add it to the rig file')
    with pytest.raises(InputError, match="section 'pump' is missing"):
        Drive(rig)


def test_a_part_may_tell_of_its_oil_alone():
    """A bench names its oil; how much of it lies in a line is the drive's matter."""
    bench = {'motor': GOOD['motor'], 'line': {'oil_grade': 'ISO VG 46'}}
    known = PartModel(parse_rig(bench)).complete({'oil_temperature': 303.15})
    assert known['viscosity_ratio'] > 2 and 1.2e9 < known['bulk_modulus'] < 1.7e9
    for unsaid in ({'line': {}}, {}):
        pump = PartModel(parse_rig({'pump': GOOD['pump'], **unsaid}))
        assert pump.capacity(pump.complete({})) == 0
        assert pump.complete({'oil_temperature': 303.15})['viscosity_ratio'] > 2
    whole = changed('line', {'oil_grade': 'ISO VG 46'})
    with pytest.raises(InputError, match="'line.bulk_modulus_Pa' is missing"):
        parse_rig(whole)


def test_losses_may_be_numbers_or_coefficients():
    """What a maker's sheet has instead of tables, against the formulas themselves."""
    content = changed('motor.leakage_L_min', {
        'laminar_L_min_per_bar': 0.004, 'turbulent_L_min_per_sqrt_bar': 0.02})
    content['motor']['mechanical_efficiency'] = {
        'coulomb_N_m': 8.0, 'viscous_N_m_s_per_rad': 0.3, 'pressure_share': 0.03}
    content['pump']['leakage_L_min'] = 0.5
    rig = parse_rig(content)
    # Without a pressure nothing leaks.
    assert [rig.pump.leakage(bar * 1e5, 4.0) * 6e4 for bar in (-1.0, 0.0, 0.5, 1.0)] == \
        pytest.approx([0.0, 0.0, 0.25, 0.5])
    for bar, speed in ((15.0, 1.0), (40.0, 10.0), (163.0, 20.0)):
        leak = 0.004 * bar + 0.02 * math.sqrt(bar)
        assert rig.motor.leakage(bar * 1e5, speed) * 6e4 == pytest.approx(leak, rel=5e-3)
        assert rig.pump.leakage(bar * 1e5, 4.0) * 6e4 == pytest.approx(0.5)
        ideal = bar * 1e5 * rig.motor.displacement
        kept = max(ideal * 0.97 - 8.0 - 0.3 * speed, 0.01 * ideal)
        assert rig.motor.mechanical_efficiency(bar * 1e5, speed) * ideal == pytest.approx(
            kept, rel=5e-3, abs=0.1)
    point = operating_point(Drive(rig), 10.0, 200.0)
    pressure = point.readings['motor_inlet_pressure']
    assert pressure * rig.motor.displacement * 0.97 - 8.0 - 3.0 == pytest.approx(200.0, rel=1e-3)


def test_of_a_sensor_the_zero_alone_may_be_stated():
    """Records show the noise by themselves."""
    content = changed('sensors.motor_speed', {'zero_std_rpm': 0.2})
    sensor = parse_rig(content, 'rig.yaml').sensors['motor_speed']
    assert (sensor.noise_std, sensor.zero_std) == (0.0, pytest.approx(0.2 * 2 * math.pi / 60))


def test_how_late_a_sensor_may_read_may_be_stated():
    """0 says that the logger reads all channels at once."""
    content = changed('sensors.motor_speed', {'delay_s': 0.002, 'delay_std_s': 0.0})
    rig = parse_rig(content, 'rig.yaml')
    assert rig.sensors['motor_speed'].delay_std == 0.0 and rig.delays == {'motor_speed': 0.002}
    assert rig.sensors['pump_outlet_pressure'].delay_std is None
    # Who states the delay alone has a sensor as usual.
    without = parse_rig({**content, 'sensors': {}}, 'rig.yaml')
    assert 0.0 < usual_sensors(rig)['motor_speed'].noise_std == usual_sensors(
        without)['motor_speed'].noise_std


def test_parameters_that_are_left_out_are_neutral():
    """A file from before an effect got a parameter keeps the model that was fitted then."""
    rig = parse_rig(changed('effects', {'bearing_friction': {'coulomb': 13},
                                        'stribeck_friction': {'torque': '14 N.m'}}))
    assert rig.effects == {'bearing_friction': {'coulomb': 13.0, 'load_share': 0.0},
                           'stribeck_friction': {'torque': 14.0, 'speed': 4.0, 'shape': 2.0,
                                                 'tail': 0.0}}
    assert Drive(rig).effects == rig.effects


def test_adopted_effects_and_calibration_reach_the_model():
    content = changed('effects', {'motor_leakage': {'conductance': '0.01 L/min/bar'}})
    content['calibration'] = {'motor.inertia': 1.1}
    rig = parse_rig(content)
    # A parameter that the rig file leaves out has its usual value.
    assert rig.effects == {'motor_leakage': {
        'conductance': pytest.approx(1e-7 / 60e3), 'exponent': 1.0, 'oil_power': 0.0,
        'oil_viscosity_ratio': 1.0}}
    drive = Drive(rig)
    assert drive.effects == rig.effects
    assert drive.parameters[6] == pytest.approx(1.1 * 0.35)


def test_an_oil_that_nobody_knows():
    with pytest.raises(InputError, match="'line.oil_grade' is 'ISO VG 47'; known: ISO VG 10"):
        Drive(parse_rig(changed('line.oil_grade', 'ISO VG 47'), 'my_rig.yaml'))


def test_each_key_has_a_meaning():
    assert {section: set(keys) for section, keys in SECTIONS.items()} == {
        section: set(keys) for section, keys in MEANINGS.items()}
