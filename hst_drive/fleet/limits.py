# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How large an effect may get: limits that a user gives; there are none else."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
import math

from hst_drive.effects import catalogue, unknown_effect
from hst_drive.errors import InputError
from hst_drive.fleet.track import CHANGE, OIL, one_way
from hst_drive.units import si_unit, to_si, UnitError

Limits = dict[tuple[str, str], float]
"""By effect and parameter, SI."""
_LARGER = 1000.0    # than what is plausible on the drill drive: no machine is so much larger


def read_limit(text: str, source: str = '--limit') -> tuple[tuple[str, str], float]:
    """
    Read 'motor_leakage.conductance=0.02 L/min/bar'.

    Without a parameter it is the effect's size, without a unit a number in SI. InputError says in
    one line what is wrong with it.
    """
    key, found, value = (part.strip() for part in text.partition('='))
    if not found:
        raise InputError(f"{source} '{text}': expected EFFECT=SIZE, as "
                         "'motor_leakage=0.02 L/min/bar'")
    return read_entry(key, value, source)


def read_limits(content: Mapping, source: str) -> Limits:
    """Read the mapping of a file with limits, 'motor_leakage: 0.02 L/min/bar'."""
    return once((source, read_entry(str(key), str(value), source))
                for key, value in content.items())


def once(entries: Iterable[tuple[str, tuple[tuple[str, str], float]]]) -> Limits:
    """Return limits, each after its source, as one mapping; raise InputError if one is twice."""
    limits: Limits = {}
    for source, (key, limit) in entries:
        if key in limits:
            raise InputError(f"{source}: '{'.'.join(key)}' has one already; give one")
        limits[key] = limit
    return limits


def read_entry(key: str, value: str, source: str) -> tuple[tuple[str, str], float]:
    """Read one limit: its key and its size."""
    if key in (OIL, f'{OIL}.{CHANGE}'):
        limit = _number(key, value, '1', source, '-20 %')
        if not 0.0 < abs(limit) < 1.0:
            raise InputError(f"{source}: '{key}' is {value}: no change of the oil's stiffness, or "
                             "more than any oil's; expected a share, as '-20 %'")
        return (OIL, CHANGE), limit
    name, _, parameter = key.partition('.')
    known = catalogue(everything=True)
    if name not in known:
        raise InputError(f'{source}: {unknown_effect(name, OIL)}')
    size = known[name].size
    if parameter not in ('', size.name):
        raise InputError(f"{source}: '{key}' is not the size of {name}; what is followed is "
                         f"'{name}.{size.name}'")
    limit = _number(key, value, size.unit, source, size.example) - size.neutral
    if abs(limit) > _LARGER * max(abs(size.low), abs(size.high)):
        raise InputError(f"{source}: '{key}' is {value}, more than is plausible on a machine; "
                         f"check its unit, expected something like '{size.example}'")
    if limit < 0.0 and one_way(name):
        raise InputError(f"{source}: '{key}' is {value}, below what it is without the effect; "
                         f"it only grows: expected something like '{size.example}'")
    if not limit:
        raise InputError(f"{source}: '{key}' is {value}: there the effect is not there at all")
    return (name, size.name), limit


def _number(key: str, text: str, expected: str, source: str, example: str) -> float:
    text = text.replace('[', ' ').replace(']', '')      # as --effect has it
    number, _, unit = text.partition(' ')
    if text.endswith('%'):
        number, unit = text[:-1], '%'
    unit = unit.strip() or expected
    try:
        value = float(number)
        if math.isfinite(value) and (unit == expected or si_unit(unit) == si_unit(expected)):
            # A size is a difference: an offset of its unit does not count.
            return value if unit == expected else float(
                to_si(value, unit) - to_si(0.0, unit))
    except (ValueError, UnitError):
        pass
    raise InputError(f"{source}: '{key}' is '{text}', expected a number with a unit of "
                     f"[{expected}], as '{example}'")
