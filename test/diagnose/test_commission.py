# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A machine's fingerprint: against closed forms, and what a diagnosis sees with it."""
from dataclasses import replace
import math
import sys
from test.truth import make_campaign
from types import SimpleNamespace

from bench.campaigns import run_of
from hst_drive.diagnose.commission import commission, DAY_TO_DAY
from hst_drive.diagnose.decide import diagnose
from hst_drive.effects.leakage_temperature import OIL_LAW
from hst_drive.effects.oil import viscosity
from hst_drive.errors import InputError
from hst_drive.identify.conditions import prior
from hst_drive.identify.fit import fit
from hst_drive.identify.model import Model
from hst_drive.report.diagnosis import text
from hst_drive.rig import parse_rig
import numpy as np
import pytest

from .machines import (
    BENCH, braked, columns, day, DRAGGED, FLOW_NOISE, MAKE, TOLERANCES, UNIT, warming)
from ..identify.test_fit import Linear

ROUGH = {**MAKE, 'tolerances_1_sigma_relative': {
    'pump.displacement_vs_command': 0.02, 'pump.leakage': 0.3}}


@pytest.fixture(scope='module')
def unit():
    """Return a commissioned pump of a make whose units scatter much."""
    return parse_rig(commission(ROUGH, 'make.yaml', [day(1)]).rig, 'unit.yaml')


def test_factors_that_are_known_together_are_drawn_to_where_they_were_together():
    """The closed form of a linear problem with a correlated prior."""
    random = np.random.default_rng(4)
    matrix = random.standard_normal((600, 3)) * 0.04    # weak: the prior decides
    campaign = Linear(matrix, matrix @ np.array([1.0, -0.8, 0.0]) + random.standard_normal(600))
    keys = [*campaign.tolerances]
    campaign.ties = {(one, other): 1.0 if one == other else 0.9 for one in keys for other in keys}
    precision = np.linalg.inv([[1.0, 0.9], [0.9, 1.0]])
    plain = matrix[:, :2]
    exact = np.linalg.solve(plain.T @ plain + precision, plain.T @ campaign.values)
    found = fit(campaign, Model(), iterations=6)
    assert [found.model.factors[key] / campaign.tolerances[key] for key in keys] == pytest.approx(
        exact, abs=2e-3)


def test_a_fingerprint_is_the_posterior_of_the_factors():
    """Factors, deviations and their correlation as linear regression with a prior has them."""
    runs = [day(1)]
    made = commission(MAKE, 'make.yaml', runs, 0.0)
    sigmas = np.array([*TOLERANCES.values()])
    moved = columns(runs[0]['pump_outlet_pressure'], runs[0]['pump_speed']) * sigmas / FLOW_NOISE
    exact = np.linalg.inv(moved.T @ moved + np.eye(2)) * np.outer(sigmas, sigmas)
    deviation = np.sqrt(np.diag(exact))
    found = made.rig['commissioned']
    assert list(found['sigma_relative'].values()) == pytest.approx(deviation, rel=0.4)
    assert found['correlation'][0][1] == pytest.approx(
        exact[0, 1] / deviation.prod(), abs=0.1)
    for entry, true, known in zip(made.quantities, UNIT, deviation):
        assert abs(entry.factor - true) < 4 * known and not entry.test
    assert found['conditions']['oil_temperature_degC'] == pytest.approx([40.0, 40.0])
    assert made.rig['characterised_at_oil_temperature_degC'] == 40.0


@pytest.mark.parametrize('together, refused', [('none', False), ('missing_effect', True)])
def test_a_log_that_misleads_alone_is_judged_with_the_others(monkeypatch, together, refused):
    """What is missing in a machine shows in all logs of it."""
    runs = [day(1), day(2)]
    monkeypatch.setattr(sys.modules[commission.__module__], 'diagnose', lambda rig, given, **_: (
        SimpleNamespace(verdict=together if len(given) > 1 else 'unknown', sentence='Odd.',
                        effects=(), delays=(), inertia=0.0, calibration=(),
                        logs=given)))
    if refused:
        with pytest.raises(InputError, match='cannot be commissioned as healthy: Odd.'):
            commission(MAKE, 'make.yaml', runs)
    else:
        assert commission(MAKE, 'make.yaml', runs).from_logs


def test_a_unit_three_tolerances_below_its_make_is_learnt():
    """A fall by 24 % is 3.4 tolerances of 8 %, counted as logarithms."""
    made = commission(MAKE, 'make.yaml', [day(1, factors=(UNIT[0], 0.76))])
    assert made.quantities[1].factor == pytest.approx(0.76, abs=0.005)


@pytest.mark.parametrize('effects, celsius', [
    ({}, 60.0), ({'bearing_friction': {'coulomb': 5.0}}, 60.0),
    ({'formula_pump_flow': {'coefficient_1': 1e-9}}, 60.0),
    ({'viscous_drag': {'coefficient': 0.5}}, 50.0), ({'line_loss': {'laminar': 1e8}}, 50.0)])
def test_what_goes_with_the_viscosity_keeps_its_reference(effects, celsius):
    """The drag at 60 degC is what it was; the make's tables are those of 50 degC."""
    made = commission({**MAKE, 'effects': effects}, 'make.yaml', [day(1, celsius=60.0)], 0.0)
    assert parse_rig(made.rig, 'unit.yaml').characterised_at == pytest.approx(celsius + 273.15)


@pytest.mark.parametrize('share', [0.0, 0.6])
def test_repeatability_is_that_of_the_days(share):
    """Close to what the days were made with; of days that are alike it is less than usual."""
    drawn = share * np.random.default_rng(7).standard_normal((5, 2))
    days = [day(k, rows=60, factors=UNIT + shares * [*TOLERANCES.values()])
            for k, shares in enumerate(drawn)]
    made = commission(MAKE, 'make.yaml', days)
    actual = float(np.sqrt(np.mean(np.var(drawn, axis=0, ddof=1))))
    assert made.from_logs
    assert made.day_to_day == pytest.approx(actual, rel=0.4) if share else \
        made.day_to_day < DAY_TO_DAY


def test_what_the_logs_do_not_tell_stays_as_the_make_has_it():
    """At one pressure and speed displacement and leakage act alike: each alone is hardly known."""
    made = commission(MAKE, 'make.yaml', [day(1, still=True)])
    leakage = made.quantities[1]
    assert made.day_to_day == DAY_TO_DAY and not made.from_logs
    assert leakage.sigma > 0.5 * leakage.make and 'pressure' in leakage.test
    assert all(entry.sigma <= entry.make for entry in made.quantities)


def test_logs_in_which_something_is_missing_are_refused():
    with pytest.raises(InputError, match=r'day_1\.csv: cannot be commissioned .*pump_leakage'):
        commission(MAKE, 'make.yaml', [day(1, 1.5)])


def test_a_small_leak_shows_against_the_machine_alone(unit):
    """What the make's tolerance takes up is found, in size; another healthy day is none."""
    leaky, make = day(2, 0.15), parse_rig(ROUGH, 'make.yaml')
    assert diagnose(make, [leaky]).verdict == 'none'
    found = diagnose(unit, [leaky])
    assert found.verdict in ('missing_effect', 'ambiguous')
    assert found.effects[0].id == 'pump_leakage'
    value = found.effects[0].parameters['conductance']
    assert value.low < 0.15e-3 / 60 / 100e5 < value.high
    # The pump of that day is the same but for its leak.
    same, = [line for line in text(found).splitlines() if line.startswith('the same as then')]
    assert 'pump.displacement_vs_command' in same
    assert diagnose(unit, [day(3)]).verdict == 'none'
    # Once it is known it does not alarm, and is not forgotten.
    known = replace(unit, effects={'pump_leakage': {'conductance': 0.15e-3 / 60 / 100e5}})
    assert 'pump_leakage, adopted before, stays as it was' in diagnose(known, [leaky]).sentence


def test_beyond_what_was_commissioned_is_told(unit):
    """Warm oil leaks as much more as gaps let it: nothing is missing, and it is said why."""
    thin = 1.3      # of the leakage: a power 0.3 or so of the viscosity from 40 to 60 degC
    warm = day(4, factors=(UNIT[0], UNIT[1] * thin), celsius=60.0)
    found = diagnose(unit, [warm])
    assert found.verdict == 'none' and 'oil temperature 60' in found.sentence
    assert [entry.channel for entry in found.outside] == ['oil_temperature']
    known, thinner = prior(unit, [warm]), math.log(viscosity(313.15, 'ISO VG 46')
                                                   / viscosity(333.15, 'ISO VG 46'))
    # As a number anywhere from 0 to the viscosity's ratio: orifices to laminar gaps.
    assert math.log(known.expected['pump.leakage']) == pytest.approx(thinner / 2, rel=0.05)
    assert known.sigmas['pump.leakage'] == pytest.approx(thinner / 12**0.5, rel=0.05)
    assert known.sigmas['pump.displacement_vs_command'] < 0.03
    assert not diagnose(unit, [day(3)]).outside


def test_a_leakage_is_known_for_the_oil_at_which_it_was_learnt(unit):
    """Not for any that was visited: from 40 degC in the middle of 35 to 45 it falls to 36."""
    visited = replace(unit, fingerprint=replace(
        unit.fingerprint, conditions={'oil_temperature': (308.15, 318.15)}))
    thicker = math.log(viscosity(313.15, 'ISO VG 46') / viscosity(309.15, 'ISO VG 46'))
    known = prior(visited, [day(5, celsius=36.0)])
    assert math.log(known.expected['pump.leakage']) == pytest.approx(thicker / 2, rel=0.05)
    assert prior(visited, [day(5)]).expected['pump.leakage'] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize('last, beyond', [(318.15, None), (323.15, 318.15)])
def test_one_factor_stood_for_all_oil_that_was_visited(unit, last, beyond):
    """Oil that warms up as it did then widens nothing; only what lies beyond is new."""
    visited = replace(unit, fingerprint=replace(
        unit.fingerprint, conditions={'oil_temperature': (308.15, 318.15)}))
    warming = day(6)
    # In no log but for a twentieth of it at each end.
    oil = np.interp(np.linspace(0.0, 1.0, 240), [0.05, 0.5, 0.95], [308.15, 313.15, last])
    warming = replace(warming, channels={**warming.channels, 'oil_temperature': oil})
    thinner = math.log(viscosity(beyond, 'ISO VG 46') / viscosity(last, 'ISO VG 46')) \
        if beyond else 0.0
    spread = math.hypot(unit.scatter['pump.leakage'], thinner / 12**0.5, thinner / 2)
    assert prior(visited, [warming]).sigmas['pump.leakage'] == pytest.approx(spread, rel=0.02)


@pytest.mark.parametrize('power', [0.0, 0.8])
def test_how_leakage_goes_with_oil_that_warms_up_is_learnt_whether_it_stands_out_or_not(power):
    # At 40 degC a pump of this make; at 50 it would leak a third more than its table.
    make = {**MAKE, 'characterised_at_oil_temperature_degC': 40}
    days = [warming(1, 34, 46, power), warming(2, 36, 48, power)]
    unit = commission(make, 'make.yaml', days).rig
    sigma = unit['commissioned']['leakage_temperature_exponent_sigma']
    assert abs(unit['effects'][OIL_LAW]['exponent'] - power) < 2.0 * sigma < 0.3
    assert diagnose(parse_rig(unit, 'unit'), [warming(3, 45, 57, power)]).verdict == 'none'
    # That another day follows it less is told as something else: nobody can repair the law.
    other = diagnose(parse_rig(unit, 'unit'), [warming(4, 45, 57, 0.8 - power)])
    assert OIL_LAW not in [entry.id for entry in other.effects]


@pytest.mark.parametrize('recorded', [True, False])
def test_where_the_oil_is_not_known_that_is_told_beside_a_leak(recorded):
    logs = [day(1), day(2, 0.5)]
    for run in logs if not recorded else ():
        del run.channels['oil_temperature']
    unit = parse_rig(commission(MAKE, 'make.yaml', logs[:1]).rig, 'unit')
    found = diagnose(unit, logs[1:])
    assert [entry.id for entry in found.effects] == ['pump_leakage']
    assert ('temperature of the oil is not known' in found.sentence) != recorded
    # A leak is no reason to buy a thermometer where it enters no balance.
    assert found.not_observable['motor_leakage'].startswith('enters no balance')


@pytest.mark.parametrize('celsius', [34.0, 42.0, 66.0])
def test_what_other_oil_does_to_a_motors_torque_is_no_fault(celsius):
    """Losses follow the viscosity by a small power that nobody knows; a fault is more."""
    unit = commission(BENCH, 'bench.yaml', [braked(1, 50.0), braked(2, 50.0)]).rig
    bench = parse_rig(unit, 'unit')
    assert diagnose(bench, [braked(3, celsius)]).verdict == 'none'
    assert 'torque_sensor_scale' in {
        name for entry in diagnose(bench, [braked(4, celsius, scale=0.96)]).effects
        for name in (entry.id, *entry.indistinguishable_from)}


def test_a_drag_that_goes_with_the_oil_is_no_fault_but_friction_is():
    unit = commission(DRAGGED, 'bench.yaml', [
        braked(seed, 50.0, drag=True) for seed in (1, 2)]).rig
    bench = parse_rig(unit, 'unit')
    assert [diagnose(bench, [braked(seed, celsius, drag=True)]).verdict
            for seed in (3, 5, 6) for celsius in (38.0, 62.0)] == ['none'] * 6
    found, = diagnose(bench, [braked(4, 38.0, drag=True, friction=6.0)]).effects
    assert 'bearing_friction' in (found.id, *found.indistinguishable_from)


@pytest.mark.needs_numba
def test_leakage_that_follows_the_oil_is_no_fault_but_learnt():
    """A healthy machine on three days with oil of 44, 50 and 56 degC; power 1 in truth."""
    def recorded(number, celsius):
        made = make_campaign(
            932_000 + number, {OIL_LAW: {'size': 1.0, 'form': 'walther'}}, unit_seed=910_022,
            duration=30.0, logs=('drilling',), keep_exact=False,
            temperature={'drilling': (celsius - 1.0, celsius + 1.0)})
        return made.sheet, [run_of(*log) for log in made.logs.items()]

    days = [recorded(number, celsius) for number, celsius in ((21, 44.0), (22, 50.0), (23, 56.0))]
    unit = commission(days[0][0], 'make.yaml', [run for _, runs in days for run in runs]).rig
    assert unit['effects'][OIL_LAW]['exponent'] == pytest.approx(1.0, abs=0.25)
    found = diagnose(parse_rig(unit, 'unit'), recorded(24, 53.0)[1])
    assert found.verdict == 'none'
