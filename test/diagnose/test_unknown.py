# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What no listed effect explains: where it enters, on what it depends, and its formula adopted."""
import json

from hst_drive import cli
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.unknown import describe
from hst_drive.effects import catalogue, formula
from hst_drive.effects.base import arguments
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import fit
from hst_drive.identify.model import Model
from hst_drive.model import Drive
from hst_drive.rig import default_rig, load_rig
import numpy as np
import pytest

from . import benches
from ..measure.synthetic import record

# Hidden in the plant: effect that stands for something without a name, and what it reads.
HIDDEN = {
    'flow': ('formula_motor_flow', [(-25e-6, ['pressure', 'warmth'])],
             {'pump_outlet_pressure', 'oil_temperature'}),
    'torque': ('formula_torque', [(-40.0, ['warmth']), (-22.0, [])], {'oil_temperature'}),
    'load': ('formula_load', [(8.0, ['pprv', 'warmth'])], {'oil_temperature'}),
    'sensor': ('formula_pressure_reading', [(3e5, ['warmth'])], {'oil_temperature'}),
}


@pytest.mark.needs_numba
@pytest.mark.parametrize('enters', HIDDEN)
def test_place_dependence_and_formula_come_out(enters):
    """The place is right, it depends on what it depends on, and the error falls."""
    name, terms, channels = HIDDEN[enters]
    runs = [record(seed, duration=60.0, roughness=0.3,
                   effects={name: formula.values(name, terms)}) for seed in (1, 2, 3)]
    campaign = Campaign(default_rig(), runs[:2], runs[2:])
    base = fit(campaign, Model(), iterations=5)
    found = describe(campaign, base)
    assert found.enters == enters
    assert channels & set(found.depends_on)
    assert found.formula is not None and found.formula.id == name
    worst = max(found.formula.before, key=found.formula.before.get)
    assert found.formula.before[worst] > 2
    assert found.formula.after[worst] < 0.5 * found.formula.before[worst]


@pytest.mark.needs_numba
def test_nothing_is_described_where_nothing_is_left():
    assert diagnose(default_rig(), [record(3, duration=30.0)]).unknown is None


def test_part_has_its_unknown_too():
    """A drag in a band of speed is no listed friction: torque, by speed."""
    run = benches.motor_bench('none', seed=6)
    speed = run['motor_speed']
    run.channels['motor_torque'][:] -= 14 * np.sign(speed) * np.exp(-((speed - 9) / 1.5)**2)
    result = diagnose(benches.motor_rig(), [run])
    assert result.verdict == 'unknown'
    assert result.unknown.enters == 'torque' and result.unknown.depends_on == ('motor_speed',)


@pytest.mark.parametrize('name', formula.FORMULAS)
def test_formula_is_what_it_says(name):
    """Its value is the sum of coefficient times powers; without coefficients it is nothing."""
    effect = formula.FORMULAS[name]
    assert name not in catalogue() and name in catalogue(everything=True)
    reads = {'pressure': 8e6, 'motor_speed': 12.0, 'oil_temperature': 318.15, 'pump_command': 5.0,
             'pprv_command': 3.0, 'motor_angle': 1.0, 'load_torque': 150.0, 'flow': 2e-4,
             'high_line': 1.0}
    scaled = {'pressure': 0.8, 'speed': 1.2, 'warmth': -0.5, 'pump': 5.0, 'pprv': 3.0,
              'cosine': np.cos(1.0), 'sine': np.sin(1.0), 'torque': 1.5, 'flow': 2.0}
    variables = formula.VARIABLES[name]
    terms = [(2.0, [variables[0], variables[0]]), (-3.0, [*variables[1:3]]), (0.5, [])]

    def value(given):
        return effect.function(*(given.get(key, reads.get(key))
                                 for key in arguments(effect.function)))

    expected = sum(coefficient * np.prod([scaled[key] for key in keys])
                   for coefficient, keys in terms)
    sign = -1 if effect.slot.endswith('flow_loss') else 1
    assert value(formula.values(name, terms)) == pytest.approx(sign * expected)
    assert value(formula.values(name, [])) == 0
    for way, ways in (('forwards', 1), ('backwards', 0), ('line_a', 1), ('line_b', 0)):
        if way in variables:
            only = formula.values(name, [(2.0, [way])])
            assert value(only) == sign * 2.0 * ways
            reversing = {**only, 'motor_speed': -12.0, 'high_line': -1.0}
            assert value(reversing) == sign * 2.0 * (1 - ways)


def test_formula_is_adopted_on_request_only(tmp_path, capsys):
    """The rig with the formula runs; without the option, and without a formula, it is refused."""
    values = formula.values('formula_load', [(9.0, ['cosine'])])
    content = {
        'schema': 'hst_drive/diagnosis/1', 'verdict': 'unknown', 'effects': [],
        'rig_digest': default_rig().digest, 'calibration': [], 'unknown': {'formula': {
            'id': 'formula_load', 'factors': {'motor.leakage': 1.1}, 'beside': {},
            'parameters': {key: {'value': value, 'low': value, 'high': value, 'unit': 'N.m'}
                           for key, value in values.items()}}}}
    path, rig = tmp_path / 'diagnosis.json', tmp_path / 'rig.yaml'
    path.write_text(json.dumps(content))
    assert cli.main(['adopt', str(path), '-o', str(rig)]) == 2
    assert 'add --formula' in capsys.readouterr().err
    assert cli.main(['adopt', str(path), '-o', str(rig), '--formula']) == 0
    adopted = load_rig(rig)
    assert adopted.effects['formula_load']['cosine_1'] == 1
    assert adopted.effects['formula_load']['sine_1'] == 0
    assert adopted.calibration == {'motor.leakage': 1.1}
    assert Drive(adopted).effects['formula_load']['coefficient_1'] == 9.0
    content['unknown']['formula'] = None
    path.write_text(json.dumps(content))
    assert cli.main(['adopt', str(path), '-o', str(rig), '--formula', '--force']) == 2
    assert 'leave --formula out' in capsys.readouterr().err
