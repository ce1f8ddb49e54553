# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""One effect, or two that look like it together: a friction that falls and a drag that rises."""
from dataclasses import replace
from types import SimpleNamespace

from bench.campaigns import as_runs
from hst_drive.diagnose import choose
from hst_drive.effects import effect_of
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.model import Model
from hst_drive.identify.search import Candidate, Search
from hst_drive.identify.standing import alternatives
from hst_drive.rig import default_rig
from hst_drive.rig.rig import Sensor
from hst_drive.rig.schema import DOUBTED, WAVES
import numpy as np
import pytest

from ..measure.synthetic import record
from ..truth import make_campaign

CANDIDATES = ('back_pressure', 'bearing_friction', 'stribeck_friction', 'viscous_drag')
UNIT = {'rate_hz': 50.0}


@pytest.mark.needs_numba
@pytest.mark.parametrize('seed, options, hidden, size, form, others', [
    (3702040, UNIT, 'back_pressure', 1.3, 'flow_dependent', ()),
    (12703013, {'on_datasheet': True, 'temperature': 'warm'}, 'back_pressure', 1.41,
     'flow_dependent', ()),
    (3702040, UNIT, 'bearing_friction', 1.5, 'load_dependent', ('back_pressure',)),
    (3702041, UNIT, 'hydrodynamic_drag', 1.4, 'square', CANDIDATES[:3])])
def test_one_effect_of_another_form_is_not_told_as_two(seed, options, hidden, size, form, others):
    """A return pressure that rises with the flow is constant and rising torque in one."""
    made = make_campaign(seed, {hidden: {'size': size, 'form': form}}, rig_seed=seed, **options)
    search = Search(Campaign(*as_runs(made)), (hidden, 'compressibility_flow', *(
        name for name in CANDIDATES if name not in (hidden, *others))))
    assert search.run().names == (hidden,)


@pytest.mark.needs_numba
@pytest.mark.parametrize('hidden, form, first', [
    ('bearing_friction', 'tanh', 'bearing_friction'),
    ('back_pressure', 'flow_dependent', 'back_pressure')])
def test_of_effects_that_look_alike_the_likelier_comes_first(hidden, form, first):
    """A return pressure, with more parameters, fits friction as well; but not the reverse."""
    made = make_campaign(3702040, {hidden: {'size': 1.3, 'form': form}}, **UNIT)
    search = Search(Campaign(*as_runs(made)), CANDIDATES)
    best = search.refine(search.single('back_pressure'))
    assert not search.unexplained(best)
    rivals = {'back_pressure': alternatives(search, best, 'back_pressure')}
    assert choose.likeliest(search, best, rivals).names == (first,)


def of_typical_size(*names):
    """Return a stand-in of a fitted set."""
    return Candidate(names, SimpleNamespace(model=Model(
        {name: effect_of(name).typical for name in names})), 0.0)


def as_declared(faults=()):
    """Return a stand-in of a campaign on a machine that has faults already."""
    return SimpleNamespace(faults=faults, parameter=lambda name, key: effect_of(name).parameter(
        key))


def test_of_what_logs_hardly_tell_apart_the_one_of_usual_size_comes_first(monkeypatch):
    """A gauge that is 30 bar off is likelier by a little, and has fewer parameters."""
    gauge, leak = map(of_typical_size, ('pressure_sensor_bias', 'pump_leakage'))
    gauge.fit.model.effects['pressure_sensor_bias']['bias'] = -30e5
    monkeypatch.setattr(choose, 'log_odds', lambda search, sets: np.array([0.0, -0.9]))
    monkeypatch.setattr(choose, 'standing', lambda search, found: found)
    search = SimpleNamespace(
        campaign=as_declared(), refine=lambda found: found, tried=lambda: [gauge, leak],
        unexplained=lambda found: {})
    rivals = {'pressure_sensor_bias': ('pump_leakage',)}
    assert choose.likeliest(search, gauge, rivals) is leak
    gauge.fit.model.effects['pressure_sensor_bias']['bias'] = -3e5
    assert choose.likeliest(search, gauge, rivals) is gauge


@pytest.mark.parametrize('faults, first', [
    ((), 'pressure_sensor_bias'), (('bearing_friction',), 'bearing_friction')])
def test_of_what_logs_hardly_tell_apart_a_change_of_what_is_known_comes_first(
        monkeypatch, faults, first):
    """By the evidence a gauge is a little likelier; it has fewer parameters, too."""
    gauge, friction = map(of_typical_size, ('pressure_sensor_bias', 'bearing_friction'))
    monkeypatch.setattr(choose, 'log_odds', lambda search, sets: np.array([0.0, -0.1]))
    monkeypatch.setattr(choose, 'standing', lambda search, found: found)
    search = SimpleNamespace(
        campaign=as_declared(faults), refine=lambda found: found,
        tried=lambda: [gauge, friction], unexplained=lambda found: {})
    rivals = {'pressure_sensor_bias': ('bearing_friction',)}
    assert choose.likeliest(search, gauge, rivals).names == (first,)


def test_of_two_effects_one_is_left_where_no_rival_stands_for_the_other(monkeypatch):
    """It stood only beside a worse fit of the first alone."""
    alone, both, instead = (of_typical_size(*names) for names in (
        ('accumulator',), ('accumulator', 'entrained_air'), ('accumulator', 'gearbox_loss')))
    monkeypatch.setattr(choose, 'log_odds', lambda search, sets: np.array([0.0, 6.0]))
    monkeypatch.setattr(choose, 'standing', lambda search, found: alone)
    search = SimpleNamespace(
        campaign=as_declared(), refine=lambda found: found,
        tried=lambda: [alone, both, instead], unexplained=lambda found: {})
    rivals = {'accumulator': (), 'entrained_air': ('gearbox_loss',)}
    assert choose.likeliest(search, both, rivals) is alone


@pytest.mark.needs_numba
def test_what_the_rig_file_says_of_the_curve_is_not_doubted():
    """A tolerance stays; 0 says that the curve was measured."""
    stated = dict(zip(WAVES, (0.004, 0.0)))
    rig = replace(default_rig(), tolerances={**default_rig().tolerances, **stated})
    runs = [record(3, duration=12.0)]
    tolerances = Campaign(rig, runs).doubted().tolerances
    assert tolerances[WAVES[0]] == 0.004 and WAVES[1] not in tolerances
    assert tolerances[WAVES[2]] == DOUBTED[WAVES[2]]
    known = replace(rig, tolerances={**rig.tolerances, **dict.fromkeys(DOUBTED, 0.0)})
    other = Campaign(known, runs).doubted()
    assert other.delays and not {*DOUBTED} & {*other.tolerances}
    exact = {name: replace(known.sensors.get(name, Sensor(0.0)), delay_std=0.0)
             for name in other.replays[0].noise}
    assert Campaign(replace(known, sensors={**known.sensors, **exact}), runs).doubted() is None
