# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which effects a machine is followed by, and that their sizes are there on every date."""
from dataclasses import replace
import math
from test.measure.test_circuit import campaign

from hst_drive.diagnose.commission import commission
from hst_drive.effects import catalogue
from hst_drive.effects.oil import viscosity
from hst_drive.fleet.track import POWERS, to_follow, track
from hst_drive.rig import default_rig, parse_rig
from hst_drive.rig.fingerprint import Fingerprint
import numpy as np
import pytest

from ..diagnose.machines import columns, day, L_MIN, MAKE, UNIT

RIG = default_rig()


def row(*effects):
    """Return a row in which effects were named, each with its look-alikes."""
    return {'diagnosis': {'effects': [{
        'id': name, 'indistinguishable_from': alike,
        'parameters': {parameter: {'value': size, 'unit': ''}}}
        for name, parameter, size, alike in effects]}}


LEAK = ('motor_leakage', 'conductance', 1e-12, ['motor_orifice_leakage'])
LEAKAGE = catalogue()['motor_leakage'].parameters[0]
SCORED = ('motor_orifice_leakage', 'flow_at_100_bar', 1e-5, ['motor_leakage'])


def test_look_alikes_are_one_and_others_are_others():
    drag = ('viscous_drag', 'coefficient', 0.5, [])
    found = to_follow([row(LEAK), row(SCORED), row(SCORED, drag), {'diagnosis': None}], RIG)
    assert [*found] == ['motor_orifice_leakage', 'viscous_drag']
    assert found['viscous_drag'] == {**found['viscous_drag'], 'coefficient': 0.5}


def test_what_the_oil_does_may_be_what_has_a_limit():
    unit = replace(RIG, fingerprint=Fingerprint({}))
    flow = ('compressibility_flow', 'volume_ratio', 1.0, ['swash_compliance', 'pump_leakage'])
    assert [*to_follow([row(flow)], unit, {'pump_leakage'})] == ['pump_leakage']
    assert to_follow([row(flow)], unit) == {}


def test_what_has_a_limit_is_followed_though_nothing_was_named():
    found = to_follow([{'diagnosis': None}], RIG, {'motor_leakage'})
    assert found == {'motor_leakage': {**found['motor_leakage'], 'conductance': LEAKAGE.typical}}
    assert to_follow([{'diagnosis': None}], RIG) == {}


def test_what_is_declared_as_alike_is_one_though_both_were_told_on_one_date():
    dry = ('bearing_friction', 'coulomb', 9.0, [])
    constant = ('constant_torque', 'torque', 8.0, [])
    assert [*to_follow([row(dry), row(dry), row(dry, constant)], RIG)] == ['bearing_friction']


def test_an_effect_that_is_not_installed_any_more_is_passed_over():
    assert [*to_follow([row(('of_my_own', 'size', 1.0, [])), row(LEAK)], RIG)] == ['motor_leakage']


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
    assert abs(size['value'] - true) < 4 * math.hypot(
        size['sigma'], size['offset']) < 0.1 * L_MIN / 100e5
    assert found.oil_temperature == pytest.approx(40.0)


def test_a_leak_is_told_for_each_way_to_follow_the_viscosity():
    """Of a laminar gap, as here: what is left of it and of the table's, by the power 1, is 0."""
    thin = viscosity(313.15, 'ISO VG 46') / viscosity(323.15, 'ISO VG 46')
    unit = parse_rig(commission(MAKE, 'make.yaml', [day(1), day(2)], 0.1).rig, 'unit.yaml')
    form = {'pump_leakage': {'conductance': 1e-12, 'exponent': 1.0}}
    typical = L_MIN / 100e5
    for leak in (0.0, 0.4):
        found = track(unit, [day(31, leak * thin, factors=(UNIT[0], UNIT[1] * thin),
                                 celsius=50.0)], form)
        size = found.sizes['pump_leakage']
        # By a lower power the table lets less through: the rest is the leak's.
        assert size['by_power'] == pytest.approx([
            (leak * thin + UNIT[1] * (thin - thin**power)) * typical for power in POWERS],
            abs=0.03 * typical)
        assert size['value'] == size['by_power'][1]
        assert found.viscosity == pytest.approx(viscosity(323.15, 'ISO VG 46'))
        # One temperature does not tell the power.
        assert np.ptp(found.misfits) < 2.0


@pytest.mark.parametrize('power', POWERS)
def test_oil_that_warms_up_tells_how_the_leakages_follow_it(power):
    unit = parse_rig(commission(MAKE, 'make.yaml', [day(1), day(2)], 0.1).rig, 'unit.yaml')
    kelvin = np.linspace(303.15, 333.15, 240)
    thin = viscosity(313.15, 'ISO VG 46') / viscosity(kelvin, 'ISO VG 46')
    warming = day(31)
    table = columns(warming['pump_outlet_pressure'], warming['pump_speed'])[:, 1]
    warming.channels['motor_inlet_flow'] += table * ((UNIT[1] + 0.3) * thin**power - UNIT[1])
    warming.channels['oil_temperature'] = kelvin
    found = track(unit, [warming], {'pump_leakage': {'conductance': 1e-12, 'exponent': 1.0}})
    assert POWERS[int(np.argmin(found.misfits))] == power


def test_what_is_not_known_of_the_machine_is_off_on_all_dates():
    """A leak as its table's: what the factor may be off, less what differs from day to day."""
    unit = parse_rig(commission(MAKE, 'make.yaml', [day(1), day(2)]).rig, 'unit.yaml')
    make = unit.tolerances['pump.leakage']
    for daily in (0.0, 0.06, 0.08):
        own = replace(unit, fingerprint=Fingerprint({'pump.leakage': 0.08}, {}, daily / make))
        size = track(own, [day(31, 0.4)], {
            'pump_leakage': {'conductance': 1e-12, 'exponent': 1.0}}).sizes['pump_leakage']
        assert size['offset'] == pytest.approx(
            math.sqrt(0.08**2 - daily**2) * UNIT[1] * L_MIN / 100e5, rel=0.1, abs=1e-15)
        assert size['sigma'] > daily * UNIT[1] * L_MIN / 100e5 * 0.9


def test_a_machine_may_leak_less_than_it_did():
    unit = parse_rig(commission(MAKE, 'make.yaml', [day(1), day(2)], 0.1).rig, 'unit.yaml')
    size = track(unit, [day(31, -0.2)], {
        'pump_leakage': {'conductance': 1e-12, 'exponent': 1.0}}).sizes['pump_leakage']
    assert size['value'] == pytest.approx(-0.2 * L_MIN / 100e5, rel=0.1)


def test_in_any_circuit_a_size_is_followed_and_its_form_stays(tmp_path):
    rig, logs, truth = campaign(tmp_path, '--circuit', 'closed', '--effect', 'motor_leakage=1',
                                '--seed', '100')
    form = {'motor_leakage': {'conductance': 1e-12, 'exponent': 1.0}}
    size = track(rig, [logs['reverse']], form).sizes['motor_leakage']
    assert size['parameter'] == 'conductance'
    assert size['value'] == pytest.approx(
        truth['si_parameters']['g_motor'], abs=2 * math.hypot(size['sigma'], size['offset']))


def test_how_leakages_go_with_the_oil_was_learnt_and_is_not_followed():
    unit = replace(RIG, effects={'leakage_temperature': {'exponent': 0.8}},
                   fingerprint=Fingerprint({}))
    assert [*to_follow([row(LEAK)], unit)] == ['motor_leakage']


def test_second_names_are_left_out_unless_both_are_told_on_one_date():
    leak = ('pump_leakage', 'conductance', 1e-12, [])
    alike, other = (('swash_compliance', 'share_at_100_bar', 0.01, names)
                    for names in (['pump_leakage'], ['pump_speed_droop']))
    told = [row(leak), row(leak), row(alike), row(other)]
    assert [*to_follow(told, RIG)] == ['pump_leakage']
    assert [*to_follow([*told, row(leak, other)], RIG)] == ['pump_leakage', 'swash_compliance']
    orifice = ('motor_orifice_leakage', 'flow_at_100_bar', 1e-5, [])
    laminar = ('motor_leakage', 'conductance', 1e-12, [])
    assert [*to_follow([row(laminar), row(laminar), row(orifice)], RIG)] == ['motor_leakage']
    assert {*to_follow([row(laminar), row(laminar, orifice)], RIG)} == {
        'motor_leakage', 'motor_orifice_leakage'}


def test_what_the_oil_does_is_followed_as_the_oil():
    unit = parse_rig(commission(MAKE, 'make.yaml', [day(1), day(2)]).rig, 'unit.yaml')
    air = ('entrained_air', 'share', 0.01, [])
    warm = ('leakage_temperature', 'exponent', 1.0, [])
    assert {*to_follow([row(air), row(warm)], RIG)} == {'entrained_air', 'leakage_temperature'}
    hose = ('line_inertance', 'inertance', 6e7, [])
    assert not to_follow([row(air), row(warm), row(hose)], unit)
    assert [*to_follow([row(air)], unit, {'entrained_air'})] == ['entrained_air']
