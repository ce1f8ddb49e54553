# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What is named is there for sure and plausible on a machine, whichever way it was found."""
from pathlib import Path

from bench.campaigns import as_runs
from hst_drive.bag import read_log
from hst_drive.diagnose.decide import diagnose
from hst_drive.effects import catalogue
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.search import Search
from hst_drive.identify.standing import standing
from hst_drive.rig import default_rig, load_rig
import pytest

from ..measure.synthetic import record
from ..truth import make_campaign
from ..truth.sensors import STANDARD

FOREIGN = Path(__file__).resolve().parents[3] / 'shared' / 'foreign'
pytestmark = pytest.mark.needs_numba
foreign = pytest.mark.skipif(not FOREIGN.exists(), reason='the shared recordings are not there')


@pytest.fixture
def among(monkeypatch):
    """Let a diagnosis search some effects alone."""
    return lambda *names: monkeypatch.setattr(
        Campaign, 'candidates', lambda self: [name for name in catalogue() if name in names])


def recorded(folder):
    """Return the rig, the recordings to fit on and the one held out of another simulator."""
    logs = [read_log(str(FOREIGN / folder / f'{name}.csv'))
            for name in ('layers', 'sweep', 'steps', 'hold')]
    return load_rig(FOREIGN / 'rig.yaml'), logs[:3], logs[3:]


@pytest.mark.parametrize('seed, name, size, signal', [
    (71, 'flow_sensor_scale', 21.0, 'motor_inlet_flow'),            # reads 1.63 times what flows
    (72, 'pressure_sensor_bias', -17.0, 'pump_outlet_pressure')])   # 34 bar below what there is
def test_what_is_beyond_the_plausible_is_no_listed_effect(among, seed, name, size, signal):
    """A sensor that is further off than its effect allows is read wrong: the channel is told."""
    among('bearing_friction', 'flow_sensor_scale', 'pressure_sensor_bias', 'pump_leakage')
    found = diagnose(*as_runs(make_campaign(seed, {name: size}, duration=30.0, logs=(
        'drilling', 'speed_sweep', 'drilling_holdout'))))
    assert found.verdict == 'unknown' and not found.effects
    assert (found.unknown.enters, found.unknown.signal) == ('sensor', signal)


def test_a_load_that_does_not_go_with_torque_is_no_gear(among):
    """A drag of 8 N.m is a gear only if that takes as much idle as under far more than load."""
    among('back_pressure', 'bearing_friction', 'gearbox_loss', 'torque_sensor_scale')
    hidden = {'formula_load': {'coefficient_1': 8.0}}
    found = diagnose(default_rig(), [record(seed, effects=hidden) for seed in (1, 2, 3)])
    assert found.verdict == 'unknown' and not found.effects
    assert found.unknown.enters == 'load'


@pytest.mark.parametrize('hidden, named', [
    ({'viscous_drag': 1.0}, ('viscous_drag',)),
    ({'viscous_drag': 1.0, 'pump_leakage': 0.5}, ('pump_leakage', 'viscous_drag'))])
def test_of_two_effects_those_stay_that_are_there(hidden, named):
    search = Search(Campaign(*as_runs(make_campaign(73, hidden))),
                    ('pump_leakage', 'viscous_drag'))
    single = search.refine(search.single('viscous_drag'))
    pair = search.refine(search.extend(single)[0])
    assert pair.names == ('pump_leakage', 'viscous_drag')
    assert standing(search, pair).names == named


def test_an_effect_stands_whose_parts_cannot_be_told_apart(among):
    """Near one speed a hose's laminar and turbulent part are one."""
    among('line_loss')
    found = diagnose(*as_runs(make_campaign(
        74, {'line_loss': 0.6}, gentle=True, duration=30.0,
        logs=('drilling', 'drilling_holdout'))))
    assert [entry.id for entry in found.effects] == ['line_loss']


def test_an_effect_stands_beside_a_sensor_that_it_does_not_move(among):
    """A flow meter of the case drain that reads half as much again says nothing of friction."""
    among('viscous_drag')
    rig, logs, held_out = as_runs(make_campaign(
        73, {'viscous_drag': 1.0}, duration=30.0, channels=(*STANDARD, 'case_drain_flow'),
        logs=('drilling', 'speed_sweep', 'drilling_holdout')))
    for log in (*logs, *held_out):
        log.channels['case_drain_flow'] *= 1.5
    found = diagnose(rig, logs, held_out)
    assert found.verdict == 'unknown'
    assert [entry.id for entry in found.effects] == ['viscous_drag']


@foreign
def test_sizes_beside_an_unknown_are_known_no_better_than_what_is_left(among):
    """A gas accumulator, not in the list, is no foam of so and so much air."""
    among('entrained_air', 'motor_leakage')
    found = diagnose(*recorded('acc_small'))
    assert found.verdict == 'unknown' and found.unknown.enters == 'flow'
    before, after = (sum(value**2 - 1.0 for value in found.ladder[place].holdout.values())
                     for place in (1, -1))
    for entry in found.effects:
        size = next(iter(entry.parameters.values()))
        assert (size.high - size.low) / 2 > (after / before)**0.5 * abs(size.value)
