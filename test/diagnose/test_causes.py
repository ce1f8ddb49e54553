# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""One cause that is not listed: a sensor wrong in zero or span, a datasheet, one recording."""
from dataclasses import replace
import re

from bench.campaigns import as_runs
from hst_drive.diagnose.decide import diagnose
import pytest

from ..truth import make_campaign

pytestmark = pytest.mark.needs_numba


@pytest.fixture(scope='module')
def healthy():
    """Return the rig and the recordings of a drive that lacks nothing."""
    return as_runs(make_campaign(45, {}))


def read_wrong(runs, signal, span=1.0, zero=0.0):
    """Return recordings in which a sensor reads wrong."""
    return [replace(run, channels={**run.channels, signal: span * run[signal] + zero})
            for run in runs]


@pytest.mark.parametrize('signal, span, zero', [
    ('motor_speed', 1.03, 0.0), ('pump_outlet_pressure', 0.94, 0.0)])
def test_a_sensor_wrong_in_zero_or_span_is_told_and_can_be_adopted(healthy, signal, span, zero):
    rig, runs, held = healthy
    found = diagnose(rig, *(read_wrong(logs, signal, span, zero) for logs in (runs, held)))
    assert found.verdict == 'unknown' and not found.effects
    assert (found.unknown.enters, found.unknown.signal) == ('sensor', signal)
    assert max(found.unknown.formula.after.values()) < 1.2


def test_the_zero_of_the_torque_sensor_has_a_name(healthy):
    rig, runs, held = healthy
    found = diagnose(rig, *(read_wrong(logs, 'load_torque', zero=6.0) for logs in (runs, held)))
    effect, = found.effects
    assert (found.verdict, effect.id) == ('missing_effect', 'constant_torque')
    torque = effect.parameters['torque']
    assert torque.low < -6.0 < torque.high and effect.parameters['in_sensor'].value == 1.0


def test_a_wrong_number_of_the_datasheet_is_told(healthy):
    rig, runs, held = healthy
    motor = replace(rig.motor, displacement=rig.motor.displacement / 0.94)
    found = diagnose(replace(rig, motor=motor), runs, held)
    assert found.verdict == 'unknown' and not found.effects
    assert 'a motor.displacement' in found.unknown.expression
    assert 'below' in found.unknown.expression


@pytest.mark.parametrize('part, number, factor, name, share, side', [
    ('line', 'volume', 1.6, 'line.volume', 60.0, 'above'),
    ('line', 'volume', 1.6, 'line.bulk_modulus', 37.5, 'below'),
    ('line', 'volume', 0.65, 'line.volume', 35.0, 'below'),
    ('motor', 'inertia', 1.5, 'motor.inertia', 50.0, 'above')])
def test_a_wrong_number_that_moves_the_resonance_is_told(healthy, part, number, factor, name,
                                                         share, side):
    """Far beyond the tolerance of the make; volume and bulk modulus act as their ratio."""
    rig, runs, held = healthy
    section = getattr(rig, part)
    wrong = replace(section, **{number: getattr(section, number) / factor})
    found = diagnose(replace(rig, **{part: wrong}), runs, held)
    assert found.verdict == 'unknown' and not found.effects
    told = re.search(f'{name} ([0-9.]+) % {side} the datasheet', found.unknown.expression)
    # The unit itself is some percent off there.
    assert told and abs(float(told[1]) - share) < 0.15 * share


def test_a_recording_unlike_the_others_is_named(healthy):
    """Its torque is in ft.lb under a heading that says N.m."""
    rig, runs, held = healthy
    odd, = read_wrong(runs[1:2], 'load_torque', 0.7376)
    found = diagnose(rig, [runs[0], odd, *runs[2:]], held)
    assert found.verdict == 'unknown'
    assert found.sentence.startswith(f'{odd.source} is unlike the others')
    assert 'several drives' not in found.sentence


def test_two_drives_in_one_campaign_are_told(healthy):
    """Each lacks nothing; nor does any effect make one of the two."""
    rig, runs, held = healthy
    other = [replace(run, name=f'{run.name}_2', source=f'{run.name}_2')
             for run in as_runs(make_campaign(46, {}))[1][:2]]
    found = diagnose(rig, [*runs[:2], *other], held)
    assert found.verdict == 'unknown' and 'on several drives' in found.sentence
    assert found.held_out == tuple(run.source for run in held)


def test_a_healthy_drive_has_no_odd_recording(healthy):
    rig, runs, held = healthy
    found = diagnose(rig, runs, held)
    assert found.verdict == 'none'
    assert 'unlike' not in found.sentence and 'several' not in found.sentence


def test_a_sensor_that_a_listed_effect_explains_keeps_that_name():
    """Though zero and span are a freer formula of it."""
    made = make_campaign(46, {'torque_sensor_scale': {'size': 1.0, 'form': 'bent'}})
    rig, runs, held = as_runs(made)
    found = diagnose(rig, runs, held)
    assert [entry.id for entry in found.effects] == ['torque_sensor_scale']
