# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Conversion between SI and the units of the field, at the edge of the program.

Inside, everything is SI: Pa (gauge), rad/s, m^3/s, m^3/rad, K, N.m, V, s. One table holds all
units; ``to_si`` and ``from_si`` work on scalars and arrays alike.
"""
from __future__ import annotations

from difflib import get_close_matches
import math
import re
from typing import NamedTuple


class UnitError(ValueError):
    """An unknown unit, or one of another dimension than the quantity has."""


class Unit(NamedTuple):
    """``si value = factor * value + offset``, in the SI unit ``si``."""

    si: str
    factor: float
    offset: float = 0.0


_REV = 2.0 * math.pi
_INCH3 = 0.0254**3
_GALLON = 231.0 * _INCH3
_PSI = 4.4482216152605 / 0.0254**2
_LBF_FT = 4.4482216152605 * 0.3048

UNITS: dict[str, Unit] = {
    's': Unit('s', 1.0), 'ms': Unit('s', 1e-3), 'us': Unit('s', 1e-6), 'ns': Unit('s', 1e-9),
    'min': Unit('s', 60.0), 'h': Unit('s', 3600.0),
    'V': Unit('V', 1.0), 'mV': Unit('V', 1e-3),
    'Pa': Unit('Pa', 1.0), 'kPa': Unit('Pa', 1e3), 'MPa': Unit('Pa', 1e6),
    'bar': Unit('Pa', 1e5), 'mbar': Unit('Pa', 1e2), 'psi': Unit('Pa', _PSI),
    'rad/s': Unit('rad/s', 1.0), 'rpm': Unit('rad/s', _REV / 60.0),
    'rev/s': Unit('rad/s', _REV), 'Hz': Unit('rad/s', _REV), 'deg/s': Unit('rad/s', _REV / 360.0),
    'K': Unit('K', 1.0), 'degC': Unit('K', 1.0, 273.15),
    'degF': Unit('K', 5.0 / 9.0, 273.15 - 32.0 * 5.0 / 9.0),
    'm^3/s': Unit('m^3/s', 1.0), 'L/min': Unit('m^3/s', 1e-3 / 60.0), 'L/s': Unit('m^3/s', 1e-3),
    'L/h': Unit('m^3/s', 1e-3 / 3600.0), 'm^3/h': Unit('m^3/s', 1.0 / 3600.0),
    'cm^3/s': Unit('m^3/s', 1e-6), 'mL/min': Unit('m^3/s', 1e-6 / 60.0),
    'gal/min': Unit('m^3/s', _GALLON / 60.0),
    'N.m': Unit('N.m', 1.0), 'kN.m': Unit('N.m', 1e3), 'lbf.ft': Unit('N.m', _LBF_FT),
    'klbf.ft': Unit('N.m', 1e3 * _LBF_FT), 'lbf.in': Unit('N.m', _LBF_FT / 12.0),
    'kgf.m': Unit('N.m', 9.80665),
    'W': Unit('W', 1.0), 'kW': Unit('W', 1e3),
    'm^3/rad': Unit('m^3/rad', 1.0), 'cc/rev': Unit('m^3/rad', 1e-6 / _REV),
    'm^3/rev': Unit('m^3/rad', 1.0 / _REV), 'in^3/rev': Unit('m^3/rad', _INCH3 / _REV),
    'rad': Unit('rad', 1.0), 'deg': Unit('rad', _REV / 360.0), 'rev': Unit('rad', _REV),
    'm': Unit('m', 1.0), 'mm': Unit('m', 1e-3), 'cm': Unit('m', 1e-2), 'ft': Unit('m', 0.3048),
    'N': Unit('N', 1.0), 'kN': Unit('N', 1e3), 'klbf': Unit('N', 4448.2216152605),
    'm/s': Unit('m/s', 1.0), 'mm/s': Unit('m/s', 1e-3), 'm/min': Unit('m/s', 1.0 / 60.0),
    'cm/min': Unit('m/s', 1e-2 / 60.0), 'm/h': Unit('m/s', 1.0 / 3600.0),
    'ft/h': Unit('m/s', 0.3048 / 3600.0),
    'm^2': Unit('m^2', 1.0), 'mm^2': Unit('m^2', 1e-6),
    'm^3': Unit('m^3', 1.0), 'L': Unit('m^3', 1e-3), 'cm^3': Unit('m^3', 1e-6),
    'kg/m^3': Unit('kg/m^3', 1.0), 'kg.m^2': Unit('kg.m^2', 1.0),
    'Pa.s/m^3': Unit('Pa.s/m^3', 1.0), 'bar/(L/min)': Unit('Pa.s/m^3', 1e5 * 60e3),
    '1/s': Unit('1/s', 1.0), 'Pa.s^2/m^3': Unit('Pa.s^2/m^3', 1.0),
    'kg/m^4': Unit('Pa.s^2/m^3', 1.0),
    'Pa.s^2/m^6': Unit('Pa.s^2/m^6', 1.0), 'bar/(L/min)^2': Unit('Pa.s^2/m^6', 1e5 * 60e3**2),
    'm^3/(s.Pa)': Unit('m^3/(s.Pa)', 1.0), 'L/min/bar': Unit('m^3/(s.Pa)', 1e-5 / 60e3),
    'N.m.s/rad': Unit('N.m.s/rad', 1.0), 'N.m.s^2/rad^2': Unit('N.m.s^2/rad^2', 1.0),
    'N.m/rad': Unit('N.m/rad', 1.0), 'rad/(N.m)': Unit('rad/(N.m)', 1.0),
    '1/rad^2': Unit('1/rad^2', 1.0),
    'V.s/rad': Unit('V.s/rad', 1.0), 'V/rad': Unit('V/rad', 1.0),
    'V/s': Unit('V/s', 1.0), '1/Pa': Unit('1/Pa', 1.0), '1/bar': Unit('1/Pa', 1e-5),
    'm^3/(rad.s)': Unit('m^3/(rad.s)', 1.0), 'cc/rev/s': Unit('m^3/(rad.s)', 1e-6 / _REV),
    'm^3/(s.Pa^2)': Unit('m^3/(s.Pa^2)', 1.0), 'm^3/(s.Pa^0.5)': Unit('m^3/(s.Pa^0.5)', 1.0),
    '1': Unit('1', 1.0), '%': Unit('1', 1e-2), '': Unit('1', 1.0),
}

# What people of the field read, by SI unit; the rest is read as it is.
_FIELD = {'Pa': 'bar', 'rad/s': 'rpm', 'm^3/s': 'L/min', 'm^3/rad': 'cc/rev', '1/Pa': '1/bar',
          'm^3/(s.Pa)': 'L/min/bar', 'Pa.s/m^3': 'bar/(L/min)', 'Pa.s^2/m^6': 'bar/(L/min)^2'}

# Spellings found in the field's files; the key is compared without case and spaces.
_ALIASES = {
    'nm': 'N.m', 'n*m': 'N.m', 'n·m': 'N.m', 'knm': 'kN.m', 'kn*m': 'kN.m', 'lpm': 'L/min',
    'l/min': 'L/min', 'gpm': 'gal/min', '°c': 'degC', 'c': 'degC', 'celsius': 'degC',
    '°f': 'degF', 'fahrenheit': 'degF', 'kelvin': 'K', 'sec': 's', 'seconds': 's', 'volt': 'V',
    'volts': 'V', 'r/min': 'rpm', '1/min': 'rpm', 'rev/min': 'rpm', 'cm3/rev': 'cc/rev',
    'cm^3/rev': 'cc/rev', 'cc': 'cc/rev', 'ml/rev': 'cc/rev', 'm3/s': 'm^3/s', 'm3/h': 'm^3/h',
    'm3/rad': 'm^3/rad', 'm3/rev': 'm^3/rev', 'in3/rev': 'in^3/rev', 'psig': 'psi',
    'lbf*ft': 'lbf.ft', 'ft-lbf': 'lbf.ft', 'ft.lbf': 'lbf.ft', 'kft-lbf': 'klbf.ft',
    'kft.lbf': 'klbf.ft', 'kgm': 'kgf.m', 'kgf*m': 'kgf.m',
    'percent': '%', '-': '1', 'cm3/s': 'cm^3/s', 'rads': 'rad/s',
    'rps': 'rev/s', 'feet': 'ft', 'meter': 'm', 'metre': 'm', 'barg': 'bar',
}
_FOLDED = {name.lower(): name for name in UNITS if name.lower() not in ('ms', 'mpa', 'mv')}
# 'mPa' and 'MPa', 'Ms' and 'ms' differ by more than spelling: these must be written exactly.

_HEADER = re.compile(r'^\s*([^\[\]]+?)\s*\[([^\[\]]*)\]\s*$')


def canonical(unit: str) -> str:
    """
    Return the table's spelling of a unit.

    Raises
    ------
    UnitError
        If the unit is not known; the text suggests the nearest one.

    """
    name = unit.strip()
    if name in UNITS:
        return name
    folded = name.replace(' ', '').lower()
    if folded in _ALIASES:
        return _ALIASES[folded]
    if folded in _FOLDED:
        return _FOLDED[folded]
    near = get_close_matches(folded, [*_FOLDED, *_ALIASES], n=1)
    guess = _FOLDED.get(near[0], _ALIASES.get(near[0])) if near else None
    hint = f'; did you mean [{guess}]?' if guess else ''
    raise UnitError(f'unknown unit [{unit}]{hint}')


def si_unit(unit: str) -> str:
    """Return the SI unit of the same dimension, e.g. ``'Pa'`` for ``'bar'``."""
    return UNITS[canonical(unit)].si


def for_people(value, unit: str):
    """
    Return a difference or a size in SI as people read it, and its unit.

    ``(2e5, 'Pa')`` becomes ``(2.0, 'bar')``; what has no unit of the field stays as it is, also
    where the table does not know the unit (an effect of another package).
    """
    read = _FIELD.get(unit, unit)
    return (value if read == unit else difference_from_si(value, read)), read


def to_si(value, unit: str):
    """Convert ``value`` (scalar or array) from ``unit`` to SI."""
    entry = UNITS[canonical(unit)]
    return value * entry.factor + entry.offset


def from_si(value, unit: str):
    """Convert ``value`` (scalar or array) from SI to ``unit``."""
    entry = UNITS[canonical(unit)]
    return (value - entry.offset) / entry.factor


def difference_from_si(value, unit: str):
    """Convert a difference (an error, a standard deviation) from SI, leaving offsets out."""
    return value / UNITS[canonical(unit)].factor


def difference_to_si(value, unit: str):
    """Convert a difference (an error, a standard deviation) to SI, leaving offsets out."""
    return value * UNITS[canonical(unit)].factor


def parse_header(text: str) -> tuple[str, str]:
    """
    Split a column header ``name[unit]``.

    Returns
    -------
    name, unit : str
        Both stripped; the unit in the table's spelling.

    Raises
    ------
    UnitError
        If there is no unit in brackets, or it is not known.

    """
    match = _HEADER.match(text)
    if not match:
        raise UnitError(f'column {text.strip()!r} has no unit; write it as name[unit]')
    return match.group(1), canonical(match.group(2))
