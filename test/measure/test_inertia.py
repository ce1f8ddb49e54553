# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The inertia of a shaft that no rig file tells is found, told, and adopted with the rest."""
from test.diagnose.test_four_quadrants import motor, REAL

from hst_drive.bag import read_log
from hst_drive.diagnose.adopt import adopt
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.result import as_json
from hst_drive.errors import InputError
from hst_drive.measure.compare import compare, model_of
from hst_drive.measure.inertia import with_found_inertia
from hst_drive.measure.run import Run
from hst_drive.rig import parse_rig
import numpy as np
import pytest

SHEET = {'motor': {'displacement_cc_rev': 4.9}}
INERTIA = 0.004     # kg.m^2


def bench(inertia, seed=2):
    """Return a bench whose shaft, which loses 12 % and 0.3 N.m, is sped up and slowed down."""
    run = motor(np.random.default_rng(seed), True)
    run['motor_torque'][:] -= inertia * np.gradient(run['motor_speed'], run.time)
    return run


def test_an_inertia_that_is_not_given_is_found_beside_the_losses():
    run = bench(INERTIA)
    found = diagnose(parse_rig(SHEET, 'rig.yaml'), [run])
    named, = found.effects
    assert named.id == 'bearing_friction'
    assert named.parameters['coulomb'].value == pytest.approx(0.3, rel=0.1)
    assert named.parameters['load_share'].value == pytest.approx(0.12, rel=0.1)
    assert found.inertia == pytest.approx(INERTIA, rel=0.05)
    assert 'gives no inertia: 0.004 kg.m^2 was found' in found.sentence
    assert 'motor.inertia' not in {entry.quantity for entry in found.calibration}
    written = adopt(SHEET, as_json(found), 'd.json', 'rig.yaml')
    rig = parse_rig(written)
    assert rig.motor.inertia == pytest.approx(found.inertia, rel=1e-3)
    assert compare(model_of(rig, [run]), [run]).signals['motor_torque'].noise_ratio < 1.2


@pytest.mark.parametrize('value', [3, {'value': 'much'}, {}])
def test_an_inertia_that_cannot_be_read_is_refused(value):
    found = as_json(diagnose(parse_rig(SHEET, 'rig.yaml'), [bench(INERTIA)]))
    with pytest.raises(InputError, match="d.json: key 'inertia' has no number as its 'value'"):
        adopt(SHEET, {**found, 'inertia': value} if value else {
            **found, 'inertia': {'unit': 'kg.m^2'}}, 'd.json', 'rig.yaml')


@pytest.mark.parametrize('inertia, sheet', [
    (0.0, {}), (-INERTIA, {}), (INERTIA, {'inertia_total_kg_m2': 0.003})])
def test_none_is_taken_where_logs_tell_none_or_the_file_does(inertia, sheet):
    rig = parse_rig({'motor': {**SHEET['motor'], **sheet}})
    assert with_found_inertia(rig, [bench(inertia)]) is rig


@pytest.mark.skipif(not REAL.exists(), reason='the real recordings are not there')
@pytest.mark.parametrize('part, of', [(0, 2), (1, 2), (0, 4), (1, 4), (2, 4), (3, 4)])
def test_any_section_of_a_real_recording_tells_the_same(part, of):
    """Its rig file gives no inertia; by its own logs it is some 0.003 kg.m^2."""
    run = read_log(str(REAL / 'mbari_motor' / 'vented_spring.csv'))
    rows = slice(part * len(run) // of, (part + 1) * len(run) // of)
    section = Run(run.name, run.time[rows],
                  {name: values[rows] for name, values in run.channels.items()}, run.source)
    found = diagnose(parse_rig({'motor': {'displacement_cc_rev': 4.916}}), [section])
    named, = found.effects
    assert named.id == 'bearing_friction' and 0.002 < found.inertia < 0.005
    assert named.parameters['load_share'].value == pytest.approx(0.2, abs=0.05)
