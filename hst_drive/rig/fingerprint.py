# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How well one machine's own numbers are known, and where that was learnt; read strictly."""
from __future__ import annotations

from dataclasses import dataclass, field
import math
from typing import Iterator, Mapping

from hst_drive.channels import LINES
from hst_drive.errors import InputError
from hst_drive.rig.schema import SENSOR_UNITS, TOLERANCES
from hst_drive.units import difference_from_si, difference_to_si, to_si
import numpy as np

# Conditions that a fingerprint holds for: channel, suffix of its key, unit.
CONDITIONS: dict[str, tuple[str, str]] = {
    **{name: ('bar', 'bar') for name in ('pump_outlet_pressure', 'motor_inlet_pressure', *LINES)},
    'motor_speed': ('rpm', 'rpm'), 'pump_speed': ('rpm', 'rpm'),
    'oil_temperature': ('degC', 'degC')}
SECTION = 'commissioned'
_KEYS = ('sigma_relative', 'correlation', 'day_to_day_share_of_tolerance', 'conditions')
_MOST_DAY_TO_DAY = 10.0
OIL_LAW_SIGMA = 'leakage_temperature_exponent_sigma'    # only where that was learnt
ZEROS = 'zeros'     # of sensors, each its value and one sigma
STARTS = 'start_error'  # how far the model errs while the drive starts from rest
_OPTIONAL = (OIL_LAW_SIGMA, ZEROS, STARTS)


@dataclass(frozen=True)
class Fingerprint:
    """
    What commissioning told of a machine, beside its factors (``Rig.calibration``).

    Attributes
    ----------
    sigmas : dict of str to float
        By quantity: one standard deviation, as a share of its factor, day-to-day
        repeatability included.
    correlation : dict of (str, str) to float
        Of pairs of quantities and of channels with a zero, each pair in both orders.
    day_to_day : float
        Repeatability, in the make's tolerances.
    conditions : dict of str to (float, float)
        Lowest and highest value, SI, of each channel that tells conditions.
    oil_law : float
        One standard deviation of the power by which its leakages follow the oil, if that was
        learnt.
    zeros : dict of str to (float, float)
        By channel: what its sensor reads beyond the truth throughout, and one standard deviation
        of that, SI.
    starts : dict of str to float
        By channel: how far the model errs while the drive starts from rest (rms), SI.

    """

    sigmas: dict[str, float]
    correlation: dict[tuple[str, str], float] = field(default_factory=dict)
    day_to_day: float = 0.0
    conditions: dict[str, tuple[float, float]] = field(default_factory=dict)
    oil_law: float = 0.0
    zeros: dict[str, tuple[float, float]] = field(default_factory=dict)
    starts: dict[str, float] = field(default_factory=dict)


def read_fingerprint(found: object, source: str) -> Fingerprint:
    """
    Read the section 'commissioned' of a rig file.

    Raises
    ------
    InputError
        Naming ``source``, the key, what was found and what was expected.

    """
    content = _mapping(found, source, SECTION)
    for key in content:
        if key not in (*_KEYS, *_OPTIONAL):
            raise InputError(f"{source}: unknown key '{SECTION}.{key}'; known: "
                             f'{", ".join((*_KEYS, *_OPTIONAL))}')
    for key in _KEYS:
        if key not in content:
            raise InputError(f"{source}: key '{SECTION}.{key}' is missing; commission the "
                             'machine again')
    where = f'{SECTION}.sigma_relative'
    sigmas = _mapping(content['sigma_relative'], source, where)
    for key, value in sigmas.items():
        if key not in TOLERANCES:
            raise InputError(f"{source}: unknown key '{where}.{key}'; known: "
                             f'{", ".join(TOLERANCES)}')
        _number(value, 1e-9, 0.5, source, f'{where}.{key}')
    share = f'{SECTION}.{_KEYS[2]}'
    zeros = _zeros(content.get(ZEROS, {}), source)
    return Fingerprint(
        {key: float(value) for key, value in sigmas.items()},
        _correlation(content['correlation'], [*sigmas, *zeros], source),
        _number(content[_KEYS[2]], 0.0, _MOST_DAY_TO_DAY, source, share),
        _conditions(content['conditions'], source),
        _number(content.get(OIL_LAW_SIGMA, 0.0), 0.0, 1.0, source, f'{SECTION}.{OIL_LAW_SIGMA}'),
        zeros, _starts(content.get(STARTS, {}), source))


def _correlation(found: object, names: list[str],
                 source: str) -> dict[tuple[str, str], float]:
    where = f'{SECTION}.correlation'
    count = len(names)
    rows = found if isinstance(found, list) else []
    if len(rows) != count or any(not isinstance(row, list) or len(row) != count for row in rows):
        raise InputError(f"{source}: '{where}' is no table of {count} rows of {count} numbers, "
                         f"one for each entry of 'sigma_relative' and '{ZEROS}'")
    table = np.array([[_number(value, -1.0, 1.0, source, f'{where}[{i}][{k}]')
                       for k, value in enumerate(row)] for i, row in enumerate(rows)])
    table = table.reshape(count, count)
    if not (np.allclose(table, table.T) and np.allclose(np.diag(table), 1.0)) or (
            count and np.linalg.eigvalsh(table)[0] <= 0.0):
        raise InputError(f"{source}: '{where}' is no correlation: expected 1 on the diagonal, the "
                         'same on both sides of it, and no quantity that others fix; commission '
                         'the machine again')
    return {(one, other): float(table[i, k])
            for i, one in enumerate(names) for k, other in enumerate(names)}


def entry_of(channel: str, *values: float) -> tuple[str, float | list[float]]:
    """Return key and value, or values, of a channel in a unit's file; differences in SI."""
    suffix, unit = SENSOR_UNITS[channel]
    told = [float(f'{difference_from_si(value, unit):.4g}') for value in values]
    return f'{channel}_{suffix}', told if len(told) > 1 else told[0]


def _starts(found: object, source: str) -> dict[str, float]:
    where = f'{SECTION}.{STARTS}'
    return {channel: float(difference_to_si(
        _number(value, 1e-12, 1e6, source, f'{where}.{key}'), unit))
        for key, channel, unit, value in _entries(found, source, where, SENSOR_UNITS)}


def _zeros(found: object, source: str) -> dict[str, tuple[float, float]]:
    where = f'{SECTION}.{ZEROS}'
    zeros = {}
    for key, channel, unit, pair in _pairs(found, source, where, SENSOR_UNITS, '[zero, sigma]'):
        zero, sigma = (float(difference_to_si(_number(
            entry, least, 1e6, source, f'{where}.{key}'), unit))
            for entry, least in zip(pair, (-1e6, 1e-12)))
        zeros[channel] = (zero, sigma)
    return zeros


def _conditions(found: object, source: str) -> dict[str, tuple[float, float]]:
    where = f'{SECTION}.conditions'
    conditions = {}
    for key, channel, unit, pair in _pairs(found, source, where, CONDITIONS, '[low, high]'):
        low, high = (float(to_si(_number(end, -1e6, 1e6, source, f'{where}.{key}'), unit))
                     for end in pair)
        if low > high:
            raise InputError(f"{source}: '{where}.{key}' is {pair}, expected low below high")
        conditions[channel] = (low, high)
    return conditions


def _pairs(found: object, source: str, where: str, units: Mapping[str, tuple[str, str]],
           expected: str) -> Iterator[tuple[str, str, str, list]]:
    for key, channel, unit, value in _entries(found, source, where, units):
        if not isinstance(value, list) or len(value) != 2:
            raise InputError(f"{source}: '{where}.{key}' is {value!r}, expected {expected}")
        yield key, channel, unit, value


def _entries(found: object, source: str, where: str,
             units: Mapping[str, tuple[str, str]]) -> Iterator[tuple[str, str, str, object]]:
    """Yield key, channel, unit and value; ``units`` are the key's suffix and unit by channel."""
    known = {f'{channel}_{suffix}': (channel, unit) for channel, (suffix, unit) in units.items()}
    for key, value in _mapping(found, source, where).items():
        if key not in known:
            raise InputError(f"{source}: unknown key '{where}.{key}'; known: {', '.join(known)}")
        yield key, *known[key], value


def _mapping(found: object, source: str, where: str) -> dict:
    if not isinstance(found, dict):
        raise InputError(f"{source}: '{where}' is {found!r}, expected a mapping of keys")
    return found


def day_to_day_share(value: float, name: str) -> float:
    """Return a repeatability, in the make's tolerances; raise InputError if it can be none."""
    if not 0.0 <= value <= _MOST_DAY_TO_DAY:
        raise InputError(f'{name} {value:g}: expected a share of the tolerance from 0 to '
                         f'{_MOST_DAY_TO_DAY:g}, 0.1 say')
    return value


def _number(value: object, low: float, high: float, source: str, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not (
            low <= value <= high) or not math.isfinite(value):
        raise InputError(f"{source}: '{where}' is {value!r}, expected a number from {low:g} to "
                         f'{high:g}')
    return float(value)
