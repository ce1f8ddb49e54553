# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A real pump with leaks that its rig's makers labelled: commissioned, diagnosed, adopted."""
import json
from pathlib import Path

from hst_drive.bag import read_log
from hst_drive.diagnose.adopt import adopt
from hst_drive.diagnose.commission import commission
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.result import as_json
from hst_drive.rig import parse_rig
import pytest

LOGS = Path(__file__).resolve().parents[3] / 'shared' / 'real' / 'zema_pump'
pytestmark = pytest.mark.skipif(not LOGS.is_dir(), reason='the recordings are not here')
# Induction motor at about 1450 1/min; the healthy slope, motor's slip included, as its leakage.
MAKE = {
    'name': 'pump', 'pump': {
        'shaft_speed_rpm': 1450, 'max_displacement_cc_rev': 6.03, 'leakage_L_min': {
            'pressure_bar': [0, 200], 'command_V': [0, 10], 'table': [[0, 0], [1.16, 1.16]]}},
    'line': {'bulk_modulus_Pa': 1.2e9, 'volume_m3': 1e-3, 'oil_density_kg_m3': 870,
             'oil_grade': 'ISO VG 46'},
    'sensors': {'motor_inlet_flow': {'noise_std_L_min': 0.015},
                'pump_outlet_pressure': {'noise_std_bar': 0.1}},
    'tolerances_1_sigma_relative': {'pump.displacement_vs_command': 0.006, 'pump.leakage': 0.08}}
LEAK, AT = 0.221e-3 / 60, 155e5     # m^3/s at Pa, from the recordings


def judged(content, name):
    """Return the diagnosis of a recording on the rig file with this content."""
    return diagnose(parse_rig(content, 'unit.yaml'), [read_log(LOGS / f'{name}.csv')])


def test_a_leak_is_found_sized_adopted_and_not_told_again():
    unit = commission(MAKE, 'make.yaml', [read_log(LOGS / 'healthy_a.csv')]).rig
    assert judged(MAKE, 'leak_1').verdict == 'none'     # the make's tolerances swallow it
    assert judged(unit, 'healthy_b').verdict == 'none'
    # Twice as many rows; where the pump is off its sheet it was so when it was commissioned.
    assert judged(unit, 'valve_80').verdict == 'none'
    found = judged(unit, 'leak_1')
    assert found.effects[0].id == 'pump_leakage'
    assert found.effects[0].parameters['conductance'].value * AT == pytest.approx(LEAK, rel=0.05)
    leaky = adopt(unit, json.loads(json.dumps(as_json(found))), 'd.json', 'unit.yaml')
    assert judged(leaky, 'leak_1_holdout').verdict == 'none'
    repaired = judged(leaky, 'healthy_b')
    assert [(entry.id, entry.change) for entry in repaired.effects] == [('pump_leakage', 'gone')]


def test_half_of_that_leak_is_no_gauge_that_is_20_bar_off():
    unit = commission(MAKE, 'make.yaml', [read_log(LOGS / 'healthy_a.csv')]).rig
    run = read_log(LOGS / 'leak_1.csv')
    run['motor_inlet_flow'][:] += 0.5 * LEAK * run['pump_outlet_pressure'] / AT
    first, = diagnose(parse_rig(unit, 'unit.yaml'), [run]).effects
    assert first.id != 'pressure_sensor_bias'
    assert 'pump_leakage' in (first.id, *first.indistinguishable_from)


def test_warm_oil_is_no_fault_of_a_sensor():
    unit = commission(MAKE, 'make.yaml', [read_log(LOGS / 'healthy_a.csv')]).rig
    found = judged(unit, 'warm')
    assert not found.effects and 'oil temperature' in found.sentence
    assert found.unknown is None or found.unknown.enters != 'sensor'
