# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Units: against pint, there and back, spellings of the field, and what is refused."""
import math

from hst_drive.effects import catalogue
from hst_drive.units import (
    canonical, difference_from_si, difference_to_si, for_people, from_si, parse_header, si_unit,
    to_si, UnitError, UNITS)
from hypothesis import given, strategies as st
import numpy as np
import pytest

# Spelling for pint where it differs from ours; None: no unit that pint could know.
PINT = {
    'N.m': 'N*m', 'kN.m': 'kN*m', 'lbf.ft': 'lbf*ft', 'klbf.ft': 'klbf*ft', 'lbf.in': 'lbf*inch',
    'kgf.m': 'kgf*m',
    'cc/rev': 'cm^3/revolution', 'm^3/rev': 'm^3/revolution', 'in^3/rev': 'inch^3/revolution',
    'rev': 'revolution', 'rev/s': 'revolution/s', 'Hz': 'revolution/s', 'klbf': 'klbf',
    'kg.m^2': 'kg*m^2', 'Pa.s/m^3': 'Pa*s/m^3', 'Pa.s^2/m^6': 'Pa*s^2/m^6',
    'm^3/(s.Pa)': 'm^3/(s*Pa)', 'N.m.s/rad': 'N*m*s/rad', 'N.m.s^2/rad^2': 'N*m*s^2/rad^2',
    'N.m/rad': 'N*m/rad', 'rad/(N.m)': 'rad/(N*m)', 'V.s/rad': 'V*s/rad',
    'm^3/(rad.s)': 'm^3/(rad*s)',
    'cc/rev/s': 'cm^3/revolution/s', 'm^3/(s.Pa^2)': 'm^3/(s*Pa^2)',
    'm^3/(s.Pa^0.5)': 'm^3/(s*Pa^0.5)', '1': 'dimensionless', '': 'dimensionless',
    '%': 'percent', 'L/min/bar': 'L/min/bar', 'gal/min': 'gallon/min',
    'bar/(L/min)^2': 'bar/(L/min)**2',
}


@pytest.fixture(scope='module')
def registry():
    """Return the units that pint knows."""
    return pytest.importorskip('pint').UnitRegistry()


@pytest.mark.parametrize('name', UNITS)
def test_factor_and_dimension_against_pint(registry, name):
    unit, si = (registry.Unit(PINT.get(entry, entry).replace('^', '**'))
                for entry in (name, UNITS[name].si))
    for value in (0.0, 1.0, -7.5, 1234.5):
        want = registry.Quantity(value, unit).to(si).magnitude
        assert to_si(value, name) == pytest.approx(want, rel=1e-12, abs=1e-12)


@given(st.sampled_from(sorted(UNITS)), st.floats(-1e12, 1e12))
def test_there_and_back(unit, value):
    entry = UNITS[unit]
    slack = 1e-12 * (abs(value) + abs(entry.offset / entry.factor)) + 1e-300
    assert from_si(to_si(value, unit), unit) == pytest.approx(value, abs=4 * slack)
    assert difference_from_si(difference_to_si(value, unit), unit) == pytest.approx(
        value, abs=slack)
    # A difference is what it says.
    assert to_si(value, unit) - to_si(0.0, unit) == pytest.approx(
        difference_to_si(value, unit), abs=4 * slack * entry.factor)


def test_arrays():
    np.testing.assert_allclose(to_si(np.array([0.0, 50.0]), 'degC'), [273.15, 323.15])
    np.testing.assert_allclose(from_si(np.array([math.pi]), 'rpm'), [30.0])


def test_si_units_are_their_own():
    for entry in UNITS.values():
        assert UNITS[entry.si].si == entry.si
        assert (UNITS[entry.si].factor, UNITS[entry.si].offset) == (1.0, 0.0)


@pytest.mark.parametrize('written, unit', [
    ('bar', 'bar'), (' bar ', 'bar'), ('Bar', 'bar'), ('barg', 'bar'), ('RPM', 'rpm'),
    ('1/min', 'rpm'), ('r/min', 'rpm'), ('l/min', 'L/min'), ('LPM', 'L/min'), ('Nm', 'N.m'),
    ('N·m', 'N.m'), ('N*m', 'N.m'), ('N m', 'N.m'), ('°C', 'degC'), ('C', 'degC'),
    ('cm^3/rev', 'cc/rev'), ('cc', 'cc/rev'), ('kft.lbf', 'klbf.ft'), ('MPa', 'MPa'),
    ('ms', 'ms'), ('mV', 'mV'), ('%', '%'), ('', ''), ('-', '1'), ('PSI', 'psi'), ('PSIg', 'psi'),
    ('m3/s', 'm^3/s'), ('KPA', 'kPa'), ('Rad/S', 'rad/s'), ('l/h', 'L/h')])
def test_spellings(written, unit):
    assert canonical(written) == unit


@pytest.mark.parametrize('written', ['mPa', 'Ms', 'MS', 'mpa', 'MV'])
def test_what_could_be_milli_or_mega_must_be_written_exactly(written):
    with pytest.raises(UnitError, match='unknown unit'):
        canonical(written)


@pytest.mark.parametrize('written, hint', [
    ('barr', 'did you mean [bar]'), ('rpmm', 'did you mean [rpm]'), ('N.mm', 'did you mean [N.m]'),
    ('furlong', 'unknown unit [furlong]')])
def test_unknown_units(written, hint):
    with pytest.raises(UnitError) as caught:
        to_si(1.0, written)
    assert hint in str(caught.value)


@pytest.mark.parametrize('text, want', [
    ('motor_speed[rpm]', ('motor_speed', 'rpm')), (' time [s] ', ('time', 's')),
    ('torque [Nm]', ('torque', 'N.m')), ('Rotary speed[1/min]', ('Rotary speed', 'rpm')),
    ('share[]', ('share', ''))])
def test_headers(text, want):
    assert parse_header(text) == want


@pytest.mark.parametrize('text', ['motor_speed', 'motor_speed[', '[rpm]', 'a[b][c]', '', 'x]rpm['])
def test_headers_without_a_unit(text):
    with pytest.raises(UnitError, match='has no unit; write it as name'):
        parse_header(text)


def test_si_unit():
    assert (si_unit('bar'), si_unit('degF'), si_unit('lpm')) == ('Pa', 'K', 'm^3/s')


@pytest.mark.parametrize('unit', sorted({entry.si for entry in UNITS.values()}))
def test_what_people_read_is_the_same_size(unit):
    value, read = for_people(2.5, unit)
    assert difference_to_si(value, read) == pytest.approx(2.5)
    assert si_unit(read) == unit


def test_what_people_read_of_a_unit_that_is_not_known():
    assert for_people(2e5, 'Pa') == (pytest.approx(2.0), 'bar')
    assert for_people(3.0, 'apples') == (3.0, 'apples')


def test_every_parameter_of_an_effect_can_be_given_with_its_unit():
    """On the command line and in rig files: value[unit]."""
    for effect in catalogue().values():
        for parameter in effect.parameters:
            assert si_unit(parameter.unit) == parameter.unit, effect.id
