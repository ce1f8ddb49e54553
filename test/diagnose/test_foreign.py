# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Campaigns of another simulator (Hopsan), whose sizes are known; all begin in motion."""
from pathlib import Path

from hst_drive.bag import read_log
from hst_drive.diagnose.decide import diagnose
from hst_drive.rig import load_rig
import pytest

FOREIGN = Path(__file__).resolve().parents[3] / 'shared' / 'foreign'
pytestmark = [pytest.mark.needs_numba, pytest.mark.skipif(
    not FOREIGN.exists(), reason='the shared recordings are not there')]


def answer(folder):
    """Return the diagnosis of a campaign, with one recording held out."""
    logs = [read_log(str(FOREIGN / folder / f'{name}.csv'))
            for name in ('layers', 'sweep', 'steps', 'hold')]
    return diagnose(load_rig(FOREIGN / 'rig.yaml'), logs[:3], logs[3:])


def test_nothing_is_missing():
    assert answer('healthy2').verdict == 'none'


@pytest.mark.parametrize('folder, verdict, among', [
    # An orifice is another form of the same effect: the exponent tells it.
    ('orif', 'missing_effect', {'pump_leakage'}),
    # The drive turns one way: a torque that keeps its sign looks like friction.
    ('backp', 'ambiguous', {'back_pressure', 'bearing_friction', 'constant_torque',
                            'pressure_sensor_bias'}),
    # The oil in a long hose has mass, too: beside what is not explained less is told apart.
    ('hose', 'unknown', {'hydrodynamic_drag', 'line_loss', 'viscous_drag'})])
def test_what_looks_alike_is_told_as_a_set(folder, verdict, among):
    found = answer(folder)
    named, = found.effects
    told = [named.id, *named.indistinguishable_from]
    # A Stribeck curve that hardly falls is dry friction: at most that beside.
    assert found.verdict == verdict and among <= {*told} <= among | {'stribeck_friction'}


def test_a_shaft_that_is_hardly_damped_is_found_with_its_size():
    found = answer('shaft')
    named, = found.effects
    assert (found.verdict, named.id) == ('missing_effect', 'shaft_compliance')
    assert max(found.ladder[-1].holdout.values()) < 1.1
    for key, true in {'compliance': 3.13e-3, 'load_side_share': 0.35}.items():
        size = named.parameters[key]
        assert size.low <= true <= size.high
        assert size.value == pytest.approx(true, rel=0.03)


@pytest.mark.parametrize('folder, quantity, percent', [
    ('volume', 'line.volume', 80.0), ('inertia', 'motor.inertia', 60.0)])
def test_a_wrong_number_of_the_datasheet_is_told(folder, quantity, percent):
    found = answer(folder)
    assert found.verdict == 'unknown' and not found.effects
    told = found.sentence[found.sentence.rindex(quantity):].split()
    assert float(told[1]) == pytest.approx(percent, abs=2.0) and told[2:4] == ['%', 'above']
