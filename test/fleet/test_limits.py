# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Limits as users write them."""
from hst_drive.errors import InputError
from hst_drive.fleet.limits import read_limit, read_limits
import pytest


def test_units_and_short_forms():
    """1 L/min/bar is 1e-3/60/1e5 m^3/(s.Pa)."""
    key = ('motor_leakage', 'conductance')
    for text in ('motor_leakage=0.02 L/min/bar', 'motor_leakage.conductance = 0.02 L/min/bar',
                 'motor_leakage=3.3333333333e-12', 'motor_leakage=0.02[L/min/bar]'):
        assert read_limit(text) == (key, pytest.approx(0.02e-3 / 60 / 1e5))
    assert read_limit('line.bulk_modulus=-20 %') == (('line.bulk_modulus', 'change'), -0.2)
    assert read_limits({'bearing_friction': '12 N.m', 'flow_sensor_scale': 0.03}, 'f') == {
        ('bearing_friction', 'coulomb'): 12.0, ('flow_sensor_scale', 'gain_error'): 0.03}


def test_a_limit_that_comes_twice_is_refused():
    with pytest.raises(InputError, match="'motor_leakage.conductance' has one already; give one"):
        read_limits({'motor_leakage': 1e-12, 'motor_leakage.conductance': 2e-12}, 'f')


@pytest.mark.parametrize(('text', 'told'), [
    ('motor_leakage', 'expected EFFECT=SIZE'),
    ('motor_leak=1', "unknown effect 'motor_leak'; did you mean 'motor_leakage'?"),
    ('motor_leakage.size=1', "what is followed is 'motor_leakage.conductance'"),
    ('motor_leakage=0.02 bar', 'expected a number with a unit of'),
    ('motor_leakage=much', 'expected a number with a unit of'),
    ('motor_leakage=nan', 'expected a number with a unit of'),
    ('motor_leakage=0.02 bar', "as '0.0078 L/min/bar'"),
    ('motor_leakage=3', "more than is plausible .* check its unit, .* '0.0078 L/min/bar'"),
    ('motor_leakage=-0.02 L/min/bar', 'below what it is without'),
    ('motor_leakage=0', 'not there at all'),
    ('line.bulk_modulus=-20', "more than any oil's; expected a share, as '-20 %'"),
    ('line.bulk_modulus=-3000 bar', "as '-20 %'")])
def test_slips_are_one_line(text, told):
    with pytest.raises(InputError, match=told.replace('?', '[?]')) as caught:
        read_limit(text)
    assert '\n' not in str(caught.value)
