# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""On what a made-up unknown depends, and whether the formula that made it comes back."""
from hst_drive.diagnose.dependence import depends_on, expression, regress, Samples
from hst_drive.diagnose.isolate import Location
import numpy as np
import pytest

COUNT, BLOCK = 3000, 20
PLACE = Location('torque of the hydromotor', 'torque', 'pump_outlet_pressure', 'N.m', {}, ())


def samples(seed, truth, noise=0.3):
    """Return samples of ``truth(pressure, speed, warmth)`` in 100 bar, 10 rad/s and 10 K."""
    random = np.random.default_rng(seed)
    variables = {name: random.uniform(low, high, COUNT) for name, low, high in (
        ('pump_outlet_pressure', 0.1, 1.5), ('motor_speed', 0.2, 1.4),
        ('oil_temperature', -1.5, 1.5), ('pump_command', 3.0, 7.0))}
    values = truth(*list(variables.values())[:3]) + noise * random.standard_normal(COUNT)
    block = np.arange(COUNT) // BLOCK
    return Samples(values, variables, block % 3 == 1, block)


@pytest.mark.parametrize('truth, expected', [
    (lambda p, w, t: 4.0 * np.exp(-((w - 0.9) / 0.15)**2), {'motor_speed'}),
    (lambda p, w, t: 3.0 * p * t, {'pump_outlet_pressure', 'oil_temperature'}),
    (lambda p, w, t: 0.0 * p, set()),
])
def test_the_variables_are_told_whatever_the_form(truth, expected):
    assert set(depends_on(samples(1, truth))) == expected


def test_the_formula_comes_back_with_honest_intervals():
    held = 0
    for seed in range(40):
        terms, explained = regress(samples(seed, lambda p, w, t: 5.0 * p * t - 2.0 * w**2),
                                   lambda name: True)
        found = {tuple(term['variables']): term for term in terms}
        assert set(found) == {('oil_temperature', 'pump_outlet_pressure'),
                              ('motor_speed', 'motor_speed')}
        product = found['oil_temperature', 'pump_outlet_pressure']
        assert product['coefficient'] == pytest.approx(5.0, rel=0.02)
        held += product['low'] <= 5.0 <= product['high']
        assert explained > 0.95
    assert 34 <= held <= 40


def test_noise_has_no_formula():
    terms, explained = regress(samples(2, lambda p, w, t: 0.0 * p), lambda name: True)
    assert terms == [] and explained == 0.0
    assert 'no short formula holds' in expression(PLACE, terms)


def test_the_text_says_each_scale_and_sign():
    terms = [{'variables': ['pump_outlet_pressure', 'oil_temperature'], 'coefficient': 5.0},
             {'variables': ['pump_speed'], 'coefficient': -0.5}]
    assert expression(PLACE, terms) == (
        'torque of the hydromotor [N.m] += 5 * (pump_outlet_pressure / 100 bar) * '
        '((oil_temperature - 50 degC) / 10 K) - 0.5 * (pump_speed / 100 rad/s)')
