# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Strict reading of a mapping whose keys carry their unit (``duration_s``, ``torque_N_m``).

Any unit of the right dimension is taken (``duration_min``, ``speed_rad_s``). Everything wrong is
one line that names file and key and suggests the mend.
"""
from __future__ import annotations

from difflib import get_close_matches
import math

from hst_drive.errors import InputError
from hst_drive.units import to_si, UnitError, UNITS


def suffix(unit: str) -> str:
    """Return a unit as keys write it: 'N.m' is 'N_m', 'rad/s' is 'rad_s', '%' is 'percent'."""
    text = unit.replace('%', 'percent').replace('^', '')
    return ''.join(sign if sign.isalnum() else '_' for sign in text).strip('_')


_SAME: dict[str, list[str]] = {}
for _name, _unit in UNITS.items():
    if suffix(_name) and not suffix(_name).isdigit():
        _SAME.setdefault(_unit.si, []).append(_name)


class Keys:
    """
    One mapping of a file, read key by key; ``done`` refuses what nobody asked for.

    Parameters
    ----------
    content : dict
        The mapping.
    source : str
        File, for messages.
    path : str
        Where in the file, e.g. 'load'; empty at the top.

    """

    def __init__(self, content, source: str, path: str = ''):
        if not isinstance(content, dict):
            raise InputError(f"{source}: '{path or 'file'}' is {content!r}, expected a mapping "
                             'of keys to values')
        self.content, self.source, self.path = content, source, path
        self._asked: list[str] = []
        self._used: set[str] = set()

    def where(self, key: str) -> str:
        """Return the full path of a key."""
        return f'{self.path}.{key}' if self.path else key

    def fail(self, key: str, what: str) -> InputError:
        """Return an error about a key."""
        return InputError(f"{self.source}: '{self.where(key)}' {what}")

    def has(self, name: str, unit: str | None = None) -> bool:
        """Tell whether a key is there, in any unit of the dimension of ``unit``."""
        return self._find(name, unit)[0] is not None

    def take(self, name: str, default=...):
        """Return the value of a key without unit as it stands."""
        key, _ = self._find(name, None)
        if key is None:
            return self._missing(name) if default is ... else default
        return self.content[key]

    def text(self, name: str, default=...) -> str:
        """Return a text."""
        value = self.take(name, default)
        if value is not default and not isinstance(value, str):
            raise self.fail(name, f'is {value!r}, expected a text')
        return value

    def choice(self, name: str, options, default=...) -> str:
        """Return one of some words."""
        value = self.take(name, default)
        if value not in options:
            near = get_close_matches(str(value), options, n=1)
            hint = f"did you mean '{near[0]}'?" if near else f'expected {", ".join(options)}'
            raise self.fail(name, f"is '{value}'; {hint}")
        return value

    def integer(self, name: str, default=...) -> int:
        """Return a whole number that is not negative."""
        value = self.take(name, default)
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise self.fail(name, f'is {value!r}, expected a whole number, 0 or above')
        return value

    def number(self, name: str, unit: str, default=..., *, low: float = -math.inf,
               high: float = math.inf) -> float:
        """Return a number in SI; limits and default are in ``unit`` and SI, in this order."""
        key, found = self._find(name, unit)
        if key is None:
            return self._missing(_key(name, unit)) if default is ... else default
        return self._in_range(self.content[key], key, found, unit, low, high)

    def numbers(self, name: str, unit: str, *, low: float = -math.inf,
                high: float = math.inf, count: int | None = None) -> list[float]:
        """Return a list of numbers in SI."""
        key, found = self._find(name, unit)
        if key is None:
            return self._missing(_key(name, unit))
        values = self.content[key]
        if not isinstance(values, list) or not values or (count and len(values) != count):
            raise self.fail(key, f'is {values!r}, expected a list of {count or "some"} numbers')
        return [self._in_range(value, f'{key}[{i}]', found, unit, low, high)
                for i, value in enumerate(values)]

    def section(self, name: str) -> Keys:
        """Return a mapping below this one."""
        return Keys(self.take(name), self.source, self.where(name))

    def sections(self, name: str) -> list[Keys]:
        """Return a list of mappings below this one."""
        values = self.take(name)
        if not isinstance(values, list) or not values:
            raise self.fail(name, f'is {values!r}, expected a list of mappings')
        return [Keys(value, self.source, f'{self.where(name)}[{i}]')
                for i, value in enumerate(values)]

    def done(self) -> None:
        """Refuse keys that nobody asked for."""
        for key in self.content:
            if key not in self._used:
                near = get_close_matches(str(key), self._asked, n=1)
                hint = f"did you mean '{near[0]}'?" if near else \
                    f'known here: {", ".join(self._asked)}'
                raise InputError(f"{self.source}: unknown key '{self.where(str(key))}'; {hint}")

    def _find(self, name: str, unit: str | None) -> tuple[str | None, str]:
        expected = _key(name, unit)
        if expected not in self._asked:
            self._asked.append(expected)
        units = [unit or '1'] if unit in (None, '1') else _SAME[UNITS[unit].si]
        found = [(key, each) for each in units for key in (_key(name, each),)
                 if key in self.content]
        if len(found) > 1:
            raise self.fail(found[1][0], f"stands beside '{found[0][0]}'; keep one")
        if not found:
            if expected != name and name in self.content:
                raise self.fail(name, f"has no unit; did you mean '{expected}'?")
            return None, ''
        self._used.add(found[0][0])
        return found[0]

    def _missing(self, key: str):
        free = [str(name) for name in self.content if name not in self._used]
        near = get_close_matches(key, free, n=1, cutoff=0.65)
        if near:
            raise InputError(f"{self.source}: unknown key '{self.where(near[0])}'; did you mean "
                             f"'{key}'?")
        raise InputError(f"{self.source}: key '{self.where(key)}' is missing; add it")

    def _in_range(self, value, key: str, found: str, unit: str, low: float, high: float):
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.fail(key, f'is {value!r}, expected a number in {found}')
        try:
            si = float(to_si(float(value), found))
        except OverflowError:
            si = math.inf
        edges = to_si(low, unit), to_si(high, unit)
        # A value on the edge may miss it by its conversion.
        slack = 1e-9 * max(abs(si), 1e-300)
        if not math.isfinite(si) or not edges[0] - slack <= si <= edges[1] + slack:
            raise self.fail(key, f'is {value} {found}, expected {low:g} to {high:g} {unit}; '
                                 'check the value and its unit')
        return si


def _key(name: str, unit: str | None) -> str:
    return name if unit in (None, '1') else f'{name}_{suffix(unit)}'


def quantity(value, keys: Keys, key: str) -> float:
    """Return a number (SI) or a text with its unit ('12 N.m', '3.5 1/bar') in SI."""
    try:
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return float(value)
        number, _, unit = str(value).strip().partition(' ')
        return float(to_si(float(number), unit))
    except UnitError as error:
        raise keys.fail(key, f'is {value!r}: {error}') from None
    except (ValueError, OverflowError):
        raise keys.fail(key, f'is {value!r}, expected a number in SI or a text such as '
                             "'12 N.m'") from None
