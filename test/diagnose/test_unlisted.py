# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What imitates a listed effect is told from it, and the effect in another form is not."""
import re

from bench.campaigns import as_runs
from hst_drive.diagnose.unlisted import unlisted_addition, unlisted_replacement
from hst_drive.effects.formula import FLOW
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import fit
from hst_drive.identify.model import Model
from hst_drive.identify.search import Search
import numpy as np
import pytest

from ..truth import make_campaign

FULL_FLOW = 20e-3 / 60  # m^3/s, at which the truth's bent meter is right again
# Hidden in the independent plant, its form, the effect that comes nearest, and whether a
# free form beats that.
CASES = [
    ('command_leakage', 'square', 'pump_speed_droop', True),
    ('command_leakage', 'ramp', 'compressibility_flow', True),
    ('pump_speed_droop', 'induction', 'pump_speed_droop', False),
    ('compressibility_flow', 'pump_dead_volume', 'compressibility_flow', False),
    ('pump_dead_time', 'pure', 'pump_lag', True),
    ('pump_lag', 'second_order', 'pump_lag', False),
    ('pump_asymmetric_lag', 'down', 'pump_rate_limit', True),
    ('pump_asymmetric_lag', 'up', 'pump_lag', True),
    ('pump_rate_limit', 'asymmetric', 'pump_rate_limit', False),
    ('flow_sensor_square', 'square', 'pump_command_offset', True),
    ('pump_command_offset', 'wide_dead_band', 'pump_command_offset', False),
]


def replaced(search, best):
    """Return what fits better in the place of an effect of a set."""
    return unlisted_replacement(search, best, search.unexplained(best))


@pytest.mark.needs_numba
@pytest.mark.parametrize('hidden, form, named, beaten', CASES)
def test_imitation_is_told_from_another_form(hidden, form, named, beaten):
    made = make_campaign(41, {hidden: {'size': 1.0, 'form': form}})
    search = Search(Campaign(*as_runs(made)), (named,))
    found = replaced(search, search.refine(search.single(named)))
    assert bool(found) is beaten
    assert set(found) <= {named}


def told(hidden, size, named, form=None):
    """Return what is told in the place of an effect, and what was hidden."""
    made = make_campaign(42, {hidden: {'size': size, **({'form': form} if form else {})}})
    search = Search(Campaign(*as_runs(made)), (named,))
    found = replaced(search, search.single(named))
    return found[named].unknown, made.truth['si_parameters']


@pytest.mark.needs_numba
def test_dead_time_is_told_with_its_size():
    found, truth = told('pump_dead_time', 0.8, 'pump_lag')
    assert (found.enters, found.depends_on) == ('pump_actuator', ('pump_command',))
    size = float(re.search(r'dead time of ([0-9]+) ms', found.expression)[1])
    assert size == pytest.approx(1e3 * truth['dead_time'], abs=10)


@pytest.mark.needs_numba
@pytest.mark.parametrize('way', ['down', 'up'])
def test_lag_of_one_way_is_told_with_its_size(way):
    found, truth = told('pump_asymmetric_lag', 1.0, 'pump_rate_limit', way)
    assert (found.enters, found.depends_on) == ('pump_actuator', ('pump_command',))
    size, slow = re.search(r'([0-9.]+) times as long on the plate.s way (\w+)',
                           found.expression).groups()
    assert slow == way
    assert float(size) == pytest.approx(1 + truth['lag_ratio'], rel=0.2)


@pytest.mark.needs_numba
def test_bent_flow_meter_is_told_with_a_formula_to_adopt():
    found, truth = told('flow_sensor_square', 1.5, 'pump_command_offset')
    assert (found.enters, found.depends_on) == ('sensor', ('motor_inlet_flow',))
    # The bend alone: the unit's displacements may take up a gain.
    bend = truth['flow_square'] * FLOW**2 / FULL_FLOW
    assert found.formula.parameters['coefficient_2'].value == pytest.approx(bend, rel=0.2)
    assert found.formula.before['motor_inlet_flow'] > found.formula.after['motor_inlet_flow']


@pytest.mark.needs_numba
@pytest.mark.parametrize('seed, hidden, beaten', [
    (46, {'temperature_friction': 1.2}, True),
    # Three effects explain it down to the noise; one cause is the better answer.
    (11702054, {'temperature_friction': {'size': 0.76, 'form': 'exponential'}}, True),
    (46, {'bearing_friction': 0.8, 'viscous_drag': 0.8}, False),
    (46, {'back_pressure': 0.8, 'stribeck_friction': 1.2}, False)])
def test_several_effects_do_not_stand_for_one_of_the_oils_temperature(seed, hidden, beaten):
    search = Search(Campaign(*as_runs(make_campaign(seed, hidden))), (
        'bearing_friction', 'viscous_drag', 'stribeck_friction', 'pressure_sensor_bias',
        'back_pressure', 'line_loss'))
    best = search.run()
    found = replaced(search, best)
    assert bool(found) is beaten
    if beaten:
        assert set(found) == set(best.names) and len(best.names) > 1
        unknown = found[best.names[0]].unknown
        assert (unknown.enters, unknown.depends_on) == ('torque', ('oil_temperature',))
        assert unknown.formula.after['pump_outlet_pressure'] < 1.25


@pytest.mark.needs_numba
def test_a_torque_reading_that_goes_with_the_oils_temperature_is_told_as_that():
    rig, runs, held = as_runs(make_campaign(46, {}, temperature='warm'))
    for run in (*runs, *held):
        run['load_torque'][:] += 0.3 * (run['oil_temperature'] - 323.15)
    search = Search(Campaign(rig, runs, held), (
        'bearing_friction', 'viscous_drag', 'stribeck_friction', 'pressure_sensor_bias',
        'back_pressure', 'line_loss'))
    best = search.run()
    found = replaced(search, best)
    assert set(found) == set(best.names) and len(best.names) > 1
    unknown = found[best.names[0]].unknown
    assert (unknown.enters, unknown.signal) == ('sensor', 'load_torque')
    assert unknown.formula.parameters['coefficient_2'].value == pytest.approx(3.0, rel=0.1)


def beside_nothing(hidden, **options):
    """Return what is told where no effect is searched."""
    search = Search(Campaign(*as_runs(make_campaign(43, hidden, **options))), ())
    return unlisted_addition(search, search.baseline, search.unexplained(search.baseline))[1]


@pytest.mark.needs_numba
@pytest.mark.parametrize('hidden, told', [({'bit_eccentricity': 0.6}, True), ({}, False),
                                          ({'piston_ripple': 1.0}, False)])
def test_load_of_each_turn_is_told_from_a_rough_one(hidden, told):
    """Rough rock is no angle's, and a piston passes seven times a turn."""
    found = beside_nothing(hidden)
    assert (found is not None and 'angle of the shaft' in found.told) is told


@pytest.mark.needs_numba
def test_load_of_each_turn_is_placed_at_the_load_where_no_load_is_recorded():
    found = beside_nothing({'bit_eccentricity': 1.3}, channels=(
        'pump_command', 'pprv_command', 'oil_temperature', 'pump_outlet_pressure',
        'motor_inlet_flow', 'motor_speed')).unknown
    assert (found.enters, found.depends_on) == ('load', ('motor_angle',))
    after, before = (entry['pump_outlet_pressure'] for entry in (
        found.formula.after, found.formula.before))
    assert after < 1.25 < before


@pytest.mark.needs_numba
@pytest.mark.parametrize('hidden, told', [({'pump_asymmetric_lag': 1.0}, True), ({}, False),
                                          ({'pump_dead_time': 0.2}, False)])
def test_lag_of_one_way_is_told_where_the_units_own_lag_hides_it(hidden, told):
    found = beside_nothing(hidden, rate_hz=50.0)
    assert (found is not None and "on the plate's way" in found.told) is told


def with_sensor(change):
    """Return the search of a healthy campaign whose readings were changed, and what is left."""
    rig, runs, held = as_runs(make_campaign(43))
    for run in (*runs, *held):
        change(run)
    search = Search(Campaign(rig, runs, held), ())
    return search, search.unexplained(search.baseline)


@pytest.mark.needs_numba
@pytest.mark.parametrize('signal, lag', [('pump_outlet_pressure', 0.06),
                                         ('motor_inlet_flow', 0.15), ('load_torque', 0.12)])
def test_sensor_that_reads_late_is_told_with_its_lag(signal, lag):
    def change(run):
        slow = run[signal]
        for k in range(1, len(slow)):
            slow[k] = slow[k - 1] + run.sample_time / lag * (slow[k] - slow[k - 1])

    search, left = with_sensor(change)
    if signal == 'load_torque':
        # It goes into the replay: what it spoils there may be all that is left.
        left.pop(signal, None)
    found = unlisted_addition(search, search.baseline, left)[1].unknown
    assert (found.enters, found.signal) == ('sensor', signal)
    size = float(re.search(r'a lag of ([0-9]+) ms', found.expression)[1])
    assert size == pytest.approx(1e3 * lag, rel=0.15)


@pytest.mark.needs_numba
@pytest.mark.parametrize('signal, late', [('pump_outlet_pressure', 0.06), ('load_torque', 0.03),
                                          ('motor_inlet_flow', -0.03)])
def test_sensor_whose_clock_is_off_is_told_with_how_late_it_reads(signal, late):
    def change(run):
        run[signal][:] = np.interp(run.time - late, run.time, run[signal])
        run[signal][500:520] = np.nan

    search, left = with_sensor(change)
    found = unlisted_addition(search, search.baseline, left)[1].unknown
    assert (found.enters, found.signal) == ('sensor', signal)
    told, size = re.search(r'a (lag|lead) of ([0-9]+) ms', found.expression).groups()
    assert (told == 'lead') == (late < 0)
    assert float(size) == pytest.approx(1e3 * abs(late), rel=0.15)


@pytest.mark.needs_numba
@pytest.mark.filterwarnings('error::RuntimeWarning')
def test_a_sensor_that_only_a_log_to_judge_on_has_is_not_tried():
    made = make_campaign(43)
    rig, runs, held = as_runs(made)
    for run in runs:
        del run.channels['motor_inlet_flow']
    for run in held:
        run['motor_inlet_flow'][:] = np.roll(run['motor_inlet_flow'], 20)
    search = Search(Campaign(rig, runs, held), ())
    left = search.unexplained(search.baseline)
    assert 'motor_inlet_flow' in left
    unlisted_addition(search, search.baseline, left)
    assert all(np.isfinite(search.score(trial)) for _, trial in search.unlisted)


@pytest.mark.needs_numba
def test_a_fit_that_had_stopped_too_early_is_no_sign_of_something_unlisted():
    """What a trial fits better of the unit and the effect, the set has as well."""
    made = make_campaign(43, {'prv_cracking': 1.0}, rate_hz=50.0)
    search = Search(Campaign(*as_runs(made)), ('prv_cracking',))
    good = search.refine(search.single('prv_cracking'))
    factors = {**good.fit.model.factors}
    factors['pump.displacement_lag'] += 0.2
    early = search.candidate(good.names, fit(
        search.campaign, Model(good.fit.model.effects, factors), iterations=0, refresh=True))
    assert early.score > 1.05 * good.score
    again, told = unlisted_addition(search, early, search.unexplained(early))
    assert told is None
    assert again.score == pytest.approx(good.score, rel=0.02)
