# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""An effect that the rig has adopted: as it was, grown, shrunk, gone; and adopted anew."""
import json

from hst_drive.diagnose.adopt import adopt
from hst_drive.diagnose.commission import commission
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.result import as_json
from hst_drive.measure.run import Run
from hst_drive.rig import parse_rig
import numpy as np
import pytest

from .machines import day, L_MIN, MAKE, plateaus, UNIT, warming

FIRST = 0.3     # L/min at 100 bar
COLD = 46 / 75  # viscosity of ISO VG 46 at 40 degC over that at 30 degC, from charts of its makers
PER_BAR = L_MIN / 100e5


def written(result):
    """Return a diagnosis as it comes back from its file."""
    return json.loads(json.dumps(as_json(result)))


def diagnosed(content, log):
    """Return the diagnosis of a log on the rig file with this content."""
    return diagnose(parse_rig(content, 'unit.yaml'), [log])


@pytest.fixture(scope='module')
def leaky():
    """Return the rig file of a commissioned pump with a leak that was adopted, and its size."""
    unit = commission(MAKE, 'make.yaml', [day(1)]).rig
    found = diagnosed(unit, day(2, FIRST))
    adopted = adopt(unit, written(found), 'first.json', 'unit.yaml')
    return adopted, adopted['effects']['pump_leakage']['conductance'] / PER_BAR


def test_the_same_leak_is_told_once(leaky):
    content, size = leaky
    assert size == pytest.approx(FIRST, rel=0.1)
    found = diagnosed(content, day(3, FIRST))
    assert found.verdict == 'none' and not found.effects


@pytest.mark.parametrize('now, change', [(0.5, 'grown'), (0.15, 'shrunk'), (0.0, 'gone')])
def test_what_changed_is_told_and_adopted(leaky, now, change):
    """With its new size; its history stays, and what is gone is no longer in the model."""
    content, size = leaky
    result = diagnosed(content, day(4, now))
    found, = result.effects
    assert found.id == 'pump_leakage' and found.change == change
    assert found.adopted['conductance'] / PER_BAR == pytest.approx(size)
    value = found.parameters['conductance']
    assert value.low <= now * PER_BAR <= value.high
    assert f'adopted before, {"is" if change == "gone" else "has"} {change}' in result.sentence
    anew = adopt(content, written(result), 'second.json', 'unit.yaml')
    effects = anew['effects']
    assert effects == {} if change == 'gone' else (
        effects['pump_leakage']['conductance'] == pytest.approx(value.value))
    first, second = anew['provenance']['adopted']
    assert first['diagnosis'] == 'first.json' and second['logs'] == ['day_4.csv']
    past = second['changed']['pump_leakage']
    assert past['change'] == change and past['from'] == content['effects']['pump_leakage']
    assert anew['provenance']['commissioned'] == content['provenance']['commissioned']
    assert diagnosed(anew, day(5, now)).verdict == 'none'


@pytest.mark.parametrize('now, power', [(0.8, 0.5), (0.8, 0.7), (1.2, 0.5)])
def test_growth_of_a_leak_that_follows_another_law_than_was_adopted_is_told(now, power):
    """Over loads that are near each other the first logs do not tell a gap from an orifice."""
    unit = commission(MAKE, 'make.yaml', [plateaus(1)]).rig
    leaky = adopt(unit, written(diagnosed(unit, plateaus(2, 0.4, 0.9))), 'd', 'unit.yaml')
    result = diagnosed(leaky, plateaus(3, now, power))
    assert [(entry.id, entry.change) for entry in result.effects] == [('pump_leakage', 'grown')]
    value = result.effects[0].parameters['conductance']
    assert value.low * 150e5 <= now * L_MIN <= value.high * 150e5
    anew = adopt(leaky, written(result), 'e', 'unit.yaml')
    assert diagnosed(anew, plateaus(4, now, power)).verdict == 'none'


@pytest.mark.parametrize('power', [0.25, 0.5, 0.75, 1.0])
def test_a_leak_in_colder_oil_is_the_same_leak(leaky, power):
    """All gaps let less through in thicker oil, by a power that nobody has told."""
    found = diagnosed(leaky[0], cold_day(6, FIRST, power))
    assert found.verdict == 'none' and not found.effects


def test_a_machine_stays_as_it_was_commissioned_when_a_leak_grows_in_cold_oil():
    """What the oil of the day moved is no number of the machine: it would add up."""
    unit = healthy = commission(MAKE, 'make.yaml', [day(1), day(2)]).rig
    for seed, leak in ((3, 4 * FIRST), (4, 8 * FIRST)):
        unit = adopt(unit, written(diagnosed(unit, cold_day(seed, leak, 0.5))), 'd', 'unit.yaml')
    assert unit['calibration'] == healthy['calibration']
    assert [entry.change for entry in diagnosed(unit, day(5)).effects] == ['gone']


def test_a_machine_whose_file_names_no_oil_has_a_mineral_oil():
    make = {key: value for key, value in MAKE.items() if key != 'line'}
    unit = commission(make, 'make.yaml', [day(1), day(2)]).rig
    assert diagnosed(unit, cold_day(3, 0.0, 0.5)).verdict == 'none'


@pytest.mark.parametrize('now, change', [(FIRST, ''), (3 * FIRST, 'grown'), (0.0, 'gone')])
def test_where_the_power_is_known_what_grew_is_told_as_in_the_oil_of_the_day(now, change):
    power = 0.75
    unit = commission(MAKE, 'make.yaml', [
        warming(1, 34, 46, power), warming(2, 36, 48, power)]).rig
    found = diagnosed(unit, warming(3, 39, 41, power, FIRST))
    content = adopt(unit, written(found), 'first.json', 'unit.yaml')
    result = diagnosed(content, warming(4, 29, 31, power, now))
    assert [entry.change for entry in result.effects] == [change] * bool(change)
    for entry in result.effects:
        value = entry.parameters['conductance']
        assert value.low <= now * COLD**power * PER_BAR <= value.high
        effects = content['effects']
        assert entry.adopted['conductance'] == pytest.approx(
            effects['pump_leakage']['conductance']
            * COLD**effects['leakage_temperature']['exponent'], rel=0.02)


def cold_day(seed, leak, power):
    """Return a log in oil of 30 degC, of a leak that lets so much through in oil of 40 degC."""
    thinner = COLD**power
    return day(seed, leak * thinner, factors=(UNIT[0], UNIT[1] * thinner), celsius=30.0)


def axis(seed, cogging):
    """Return a log of a mass with Coulomb and viscous friction, and perhaps with magnets."""
    random, time = np.random.default_rng(seed), np.arange(0.0, 60.0, 0.01)
    speed = 2.0 * np.sin(0.5 * time) + 1.5 * np.sin(1.3 * time) + 0.5 * np.sin(4.0 * time)
    angle = -4.0 * np.cos(0.5 * time) - 1.154 * np.cos(1.3 * time) - 0.125 * np.cos(4.0 * time)
    torque = (3.0 * np.gradient(speed, time) + 4.0 * np.sign(speed) + 3.7 * speed
              + cogging * np.sin(3.0 * angle))
    noise = random.standard_normal((2, len(time)))
    return Run('axis', time, {'motor_speed': speed + 0.002 * noise[0],
                              'motor_torque': torque + 0.05 * noise[1]})


@pytest.mark.parametrize('cogging, verdict', [(0.0, 'none'), (0.4, 'unknown')])
def test_a_friction_that_the_file_gives_hides_nothing_else(cogging, verdict):
    """Of what nobody found in logs no tenth is off: magnets were none at 13 times the noise."""
    rig = parse_rig({'name': 'axis', 'motor': {'inertia_total_kg_m2': 3.0},
                     'tolerances_1_sigma_relative': {'motor.inertia': 0.02}, 'effects': {
                         'bearing_friction': {'coulomb': 4.0, 'load_share': 0.0},
                         'viscous_drag': {'coefficient': 3.7}}}, 'axis.yaml')
    assert diagnose(rig, [axis(1, cogging), axis(2, cogging)]).verdict == verdict
