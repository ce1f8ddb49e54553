# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A machine that is alike but for its size: flows, torques and inertias are so many times."""
from dataclasses import replace
from test.truth import make_campaign

from bench.campaigns import as_runs
from hst_drive.diagnose.decide import diagnose
from hst_drive.model.part import PartModel
from hst_drive.report.effects import chosen
from hst_drive.resources import share
from hst_drive.rig import default_rig, parse_rig
from hst_drive.rig.yaml_file import read_yaml
from hst_drive.watch.naming import Signatures
import pytest

pytestmark = pytest.mark.needs_numba
_TIMES = 60.0
_GROWS = ('cc_rev', 'kg_m2', 'm3', 'm2', 'N_m', 'L_min')


def larger(content, key=''):
    """Return a rig's mapping for displacements, flows and torques so many times as large."""
    if isinstance(content, dict):
        return {name: larger(value, 'L_min' if (key, name) == ('leakage_L_min', 'table') else name)
                for name, value in content.items()}
    if isinstance(content, list):
        return [larger(value, key) for value in content]
    if key.endswith('bar_per_L_min'):
        return content / _TIMES
    return _TIMES * content if key.endswith(_GROWS) and key != 'oil_density_kg_m3' else content


def large_rig():
    """Return the test rig so many times as large."""
    content = read_yaml(share('config', 'rig', 'test_rig.yaml'))
    return parse_rig(larger(content), 'large.yaml')


def test_catalogue_and_watch_have_its_bounds():
    """A friction may be so many times as large, a twist per torque so many times less."""
    rig = large_rig()
    for effect, key, times in (('bearing_friction', 'coulomb', _TIMES),
                               ('shaft_compliance', 'compliance', 1.0 / _TIMES),
                               ('pump_lag', 'time_constant', 1.0)):
        usual, found = (chosen(effect, entry)[effect].parameter(key)
                        for entry in (default_rig(), rig))
        assert (found.high, found.typical) == pytest.approx(
            (times * usual.high, times * usual.typical))
    usual, found = (Signatures(PartModel(entry)).bounds('bearing_friction', 'coulomb')
                    for entry in (default_rig(), rig))
    assert found == pytest.approx((0.0, _TIMES * usual[1]))


@pytest.mark.slow
def test_the_answer_goes_with_the_size_of_the_machine():
    """Similarity: pressures and speeds are the same, so are names; 720 N.m were at a bound."""
    rig, runs, held = as_runs(make_campaign(
        41, {'bearing_friction': 1.0}, rate_hz=50.0, duration=30.0))
    large = large_rig()
    assert large.sizes == pytest.approx((_TIMES, 1.0, _TIMES), rel=1e-3)
    small = diagnose(rig, runs, held)
    found = diagnose(large, *([replace(run, channels={
        name: values * (_TIMES if name in ('motor_inlet_flow', 'load_torque') else 1.0)
        for name, values in run.channels.items()}) for run in logs] for logs in (runs, held)))
    first, again = small.effects[0], found.effects[0]
    assert (first.id, found.verdict) == ('bearing_friction', small.verdict)
    assert [entry.id for entry in found.effects] == [entry.id for entry in small.effects]
    assert again.parameters['coulomb'].value == pytest.approx(
        _TIMES * first.parameters['coulomb'].value, rel=0.03)
