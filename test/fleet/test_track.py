# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which effects a machine is followed by, and that their sizes are there on every date."""
from hst_drive.diagnose.commission import commission
from hst_drive.effects.oil import viscosity
from hst_drive.fleet.track import to_follow, track
from hst_drive.rig import default_rig, parse_rig
import pytest

from ..diagnose.machines import day, L_MIN, MAKE, UNIT

RIG = default_rig()


def row(*effects):
    """Return a row in which effects were named, each with its look-alikes."""
    return {'diagnosis': {'effects': [{
        'id': name, 'indistinguishable_from': alike,
        'parameters': {parameter: {'value': size, 'unit': ''}}}
        for name, parameter, size, alike in effects]}}


LEAK = ('motor_leakage', 'conductance', 1e-12, ['motor_orifice_leakage'])
SCORED = ('motor_orifice_leakage', 'flow_at_100_bar', 1e-5, ['motor_leakage'])


def test_look_alikes_are_one_and_others_are_others():
    drag = ('viscous_drag', 'coefficient', 0.5, [])
    found = to_follow([row(LEAK), row(SCORED), row(SCORED, drag), {'diagnosis': None}], RIG)
    assert [*found] == ['motor_orifice_leakage', 'viscous_drag']
    assert found['viscous_drag'] == {**found['viscous_drag'], 'coefficient': 0.5}


def test_what_has_a_limit_gives_its_name():
    assert [*to_follow([row(LEAK), row(SCORED), row(SCORED)], RIG, {'motor_leakage'})] == [
        'motor_leakage']
    # Also where it was only ever a look-alike; not where it was none.
    assert [*to_follow([row(SCORED)], RIG, {'motor_leakage'})] == ['motor_leakage']
    assert [*to_follow([row(SCORED)], RIG, {'pump_leakage'})] == ['motor_orifice_leakage']


@pytest.mark.parametrize('leak', [0.0, 0.05, 0.4])
def test_sizes_are_those_of_the_pump_also_where_nothing_is_named(leak):
    """L/min at 100 bar are L_MIN/100e5 m^3/(s.Pa)."""
    unit = parse_rig(commission(MAKE, 'make.yaml', [day(1), day(2)]).rig, 'unit.yaml')
    form = {'pump_leakage': {**dict.fromkeys(
        ('conductance',), 1e-12), 'exponent': 1.0}}
    found = track(unit, [day(31, leak)], form)
    size = found.sizes['pump_leakage']
    true = leak * L_MIN / 100e5
    assert abs(size['value'] - true) < 4 * size['sigma'] < 0.1 * L_MIN / 100e5
    assert found.oil_temperature == pytest.approx(40.0)


@pytest.mark.parametrize('celsius', [37.5, 42.5])
def test_a_size_is_known_no_better_than_the_oil_within_what_was_commissioned(celsius):
    """A kelvin changes what passes a gap by some 4 %, beside which a small leak is small."""
    def healthy(seed, at):
        thin = viscosity(313.15, 'ISO VG 46') / viscosity(273.15 + at, 'ISO VG 46')
        return day(seed, factors=(UNIT[0], UNIT[1] * thin), celsius=at)

    unit = parse_rig(commission(MAKE, 'make.yaml', [
        healthy(1, 37.5), healthy(2, 42.5)], 0.1).rig, 'unit.yaml')
    found = track(unit, [healthy(31, celsius)], {
        'pump_leakage': {'conductance': 1e-12, 'exponent': 1.0}}).sizes['pump_leakage']
    assert abs(found['value']) < 2 * found['sigma']
