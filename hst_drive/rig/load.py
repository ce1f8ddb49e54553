# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Strict loading of a rig file: every slip is one line that names file and key."""
from __future__ import annotations

from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from reprlib import repr as short

from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.resources import share
from hst_drive.rig import rig as parts
from hst_drive.rig.adopted import read_effects
from hst_drive.rig.characteristic import constant, leakage, torque_efficiency
from hst_drive.rig.fingerprint import read_fingerprint, SECTION
from hst_drive.rig.identity import digest
from hst_drive.rig.rig import Rig, Sensor
from hst_drive.rig.schema import (
    FACTORS, LEAKAGE, Limits, Number, OIL_TEMPERATURES, ONLY_IN, PART, SECTIONS, SENSOR_UNITS,
    SUFFIXES, Table, TOLERANCES, TORQUE)
from hst_drive.rig.shaft import at_measured_shaft
from hst_drive.rig.tables import Curve, Surface
from hst_drive.rig.yaml_file import read_yaml
from hst_drive.units import difference_to_si, from_si, to_si, UNITS
import numpy as np

_CLASSES = {'pump': parts.Pump, 'motor': parts.Motor, 'line': parts.Line,
            'relief_valve': parts.ReliefValve, 'loading': parts.Loading, 'gear': parts.Gear,
            'cross_port_relief': parts.CrossPortRelief, 'charge': parts.Charge,
            'supply': parts.Supply, 'valve': parts.Valve, 'controller': parts.Controller}
_TOP = (*SECTIONS, 'name', 'circuit', 'sensors', 'tolerances_1_sigma_relative',
        'characterised_at_oil_temperature_degC', 'effects', 'calibration', SECTION, 'provenance')
_SHOWN = 12     # keys in a message
# s; more is a fault of the logger, or meant in ms.
_DELAYS = {'delay_s': (0.0, 1.0), 'delay_std_s': (0.0, 0.1)}


def load_rig(path: str | Path | None = None) -> Rig:
    """
    Load a rig file, or without one the shipped test rig.

    Raises
    ------
    InputError
        One line that names file and key and suggests the mend.

    """
    path = path or default_rig_file()
    return parse_rig(read_yaml(path), str(path))


def default_rig() -> Rig:
    """Return the shipped test rig of the drill-drive paper."""
    return load_rig()


def default_rig_file() -> Path:
    """Return the file of the shipped test rig."""
    return share('config', 'rig', 'test_rig.yaml')


def parse_rig(content: dict, source: str = 'rig') -> Rig:
    """
    Build a rig from the mapping of a rig file (keys carry their unit).

    Raises
    ------
    InputError
        Naming ``source`` and the key.

    """
    _known(content, _TOP, source, '')
    part = not set(parts.WHOLE) <= set(content)
    sections = {key: _section(key, content[key], source, part)
                for key in SECTIONS if key in content}
    if not sections:
        raise InputError(f'{source}: no section of a rig found; expected at least one of '
                         f'{", ".join(SECTIONS)}')
    if 'motor' in sections:
        sections['motor'] = at_measured_shaft(sections['motor'], sections.get('gear'))
    circuit = content.get('circuit', parts.OPEN)
    if not isinstance(circuit, str):
        raise InputError(f"{source}: 'circuit' is {_shown(circuit)}, expected a word such as open "
                         'or closed')
    pump = sections.get('pump')
    if circuit == parts.OPEN and pump and pump.displacement and (
            pump.displacement.y[0] < 0):
        raise InputError(f"{source}: 'pump.displacement_vs_command' falls below 0; a pump that "
                         "delivers both ways needs 'circuit: closed' in the rig file")
    _of_its_circuit(content, circuit, source)
    provenance = content.get('provenance') or {}
    if not isinstance(provenance, dict):
        raise InputError(f"{source}: 'provenance' is {_shown(provenance)}, expected a mapping")
    if SECTION in content and 'calibration' not in content:
        raise InputError(f"{source}: key 'calibration' is missing beside '{SECTION}'; commission "
                         'the machine again')
    temperature = content.get('characterised_at_oil_temperature_degC', 50)
    _number(temperature, *OIL_TEMPERATURES, source, 'characterised_at_oil_temperature_degC',
            'degC')
    rig = Rig(
        name=str(content.get('name', Path(source).stem)), circuit=circuit, **sections,
        sensors=_sensors(content.get('sensors', {}), source),
        tolerances=_tolerances(content.get('tolerances_1_sigma_relative', {}), source),
        characterised_at=to_si(float(temperature), 'degC'),
        calibration=_factors(content.get('calibration', {}), source),
        fingerprint=read_fingerprint(content[SECTION], source) if SECTION in content else None,
        provenance=provenance, source=source)
    # What effects may be goes with the machine's size.
    effects = read_effects(content.get('effects', {}), source, None if part else rig.sizes)
    return replace(rig, effects=effects, digest=digest(content))


def _of_its_circuit(content: dict, circuit: str, source: str) -> None:
    """Refuse sections, and tolerances of sections, that another circuit has."""
    for key in (*content, *(content.get('tolerances_1_sigma_relative') or {})):
        owner = ONLY_IN.get(str(key).partition('.')[0], circuit)
        if owner != circuit and circuit in (parts.OPEN, *ONLY_IN.values()):
            raise InputError(f"{source}: '{key}' belongs to 'circuit: {owner}', and this file is "
                             f"of 'circuit: {circuit}'; leave it out, or change the circuit")


def _known(mapping, allowed, source: str, where: str) -> None:
    if not isinstance(mapping, dict):
        raise InputError(f"{source}: '{where}' is {_shown(mapping)}, expected a mapping of keys")
    for key in mapping:
        if key in allowed:
            continue
        path = f'{where}.{key}' if where else str(key)
        for name in allowed:
            mend = _other_unit(str(key), name)
            if mend:
                raise InputError(f"{source}: '{path}' has the wrong unit; {mend}")
        near = get_close_matches(str(key), allowed, n=1)
        more = ', ... (docs/rig_file.md)' if len(allowed) > _SHOWN else ''
        hint = (f"did you mean '{near[0]}'?" if near
                else f'known: {", ".join(allowed[:_SHOWN])}{more}')
        raise InputError(f"{source}: unknown key '{path}'; {hint}")


def _other_unit(key: str, name: str) -> str:
    """Say how to write a key that names the right quantity in another unit."""
    for suffix, unit in SUFFIXES.items():
        stem = name[:-len(suffix) - 1]
        if not name.endswith('_' + suffix) or not key.startswith(stem + '_'):
            continue
        found = SUFFIXES.get(key[len(stem) + 1:])
        if found and UNITS[found].si == UNITS[unit].si:
            factor = UNITS[found].factor / UNITS[unit].factor
            return f"write it as '{name}' (value x {factor:.6g})"
        return f"write it as '{name}'" if found else ''
    return ''


def _shown(value) -> str:
    """Return a value for a message: short, and without Python's word for nothing."""
    return 'empty' if value is None else short(value)


def _number(value, low: float, high: float, source: str, key: str, unit: str) -> float:
    unit = '' if unit == '1' else f' {unit}'
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"{source}: '{key}' is {_shown(value)}, expected a number"
                         f"{unit and ' in'}{unit}")
    # An integer may be too large for a float: compare first.
    if not low <= value <= high:
        found = f'{value:g}' if isinstance(value, float) else short(value)
        raise InputError(f"{source}: '{key}' is {found}{unit}, outside the physical range "
                         f'{low:g} to {high:g}{unit}; check the value and its unit')
    return float(value)


def _section(name: str, content, source: str, part: bool):
    fields = SECTIONS[name]
    _known(content, tuple(fields), source, name)
    values = {}
    for key, entry in fields.items():
        path = f'{name}.{key}'
        if key not in content:
            if getattr(entry, 'optional', False):
                continue
            if part and key in PART.get(name, ()):
                continue
            raise InputError(f"{source}: key '{path}' is missing; add it")
        found = content[key]
        if isinstance(entry, Number):
            number = _number(found, entry.low, entry.high, source, path, entry.unit)
            values[entry.attribute] = to_si(number, entry.unit)
        elif isinstance(entry, Table):
            values[entry.attribute] = (
                _characteristic(entry, found, content, source, path) or
                _table(entry, found, source, path))
        elif isinstance(entry, Limits):
            values[entry.attribute] = _limits(found, source, path, entry.unit)
        else:
            if not isinstance(found, str):
                raise InputError(f"{source}: '{path}' is {_shown(found)}, expected a text")
            if found not in entry.known:
                raise InputError(f"{source}: '{path}' is {_shown(found)}; known: "
                                 f'{", ".join(entry.known)}')
            values[entry.attribute] = found
    if name == 'relief_valve':
        values.setdefault('reference_pressure', values['set_pressure'])
    for key in ('pistons', 'count'):
        if key in values:
            values[key] = int(values[key])
            if values[key] != content[key]:
                raise InputError(f"{source}: 'motor.{key}' is {content[key]}, expected a whole "
                                 'number')
    losses = content.get('mechanical_efficiency')
    if name == 'motor' and isinstance(losses, dict) and set(losses) <= set(TORQUE):
        values['torque_loss'] = tuple(float(losses.get(key, 0.0)) for key in TORQUE)
    if name in PART:
        values['given'] = frozenset(content)
    return _CLASSES[name](**values)


def _limits(found, source: str, path: str, unit: str) -> tuple[float, float]:
    if not isinstance(found, list) or len(found) != 2:
        raise InputError(f"{source}: '{path}' is {_shown(found)}, expected [low, high] in {unit}")
    low, high = (to_si(_number(value, -1e9, 1e9, source, path, unit), unit) for value in found)
    if not low < high:
        raise InputError(f"{source}: '{path}' is {found}, expected low below high")
    return low, high


def _list(found, low: float, high: float, source: str, path: str, unit: str) -> np.ndarray:
    if not isinstance(found, list) or len(found) < 2:
        raise InputError(f"{source}: '{path}' is {_shown(found)}, expected a list of at "
                         'least 2 numbers')
    return np.array([_number(value, low, high, source, f'{path}[{index}]', unit)
                     for index, value in enumerate(found)])


def _characteristic(entry: Table, found, content, source: str,
                    path: str) -> Surface | None:
    """Return a loss that is given as one number or by coefficients, None if it is a table."""
    if len(entry.axes) < 2:
        return None
    if not isinstance(found, (dict, list)):
        return constant(to_si(_number(
            found, entry.low, entry.high, source, path, entry.unit), entry.unit),
            leaks=entry.coefficients == LEAKAGE)
    if not isinstance(found, dict) or not set(found) & set(entry.coefficients):
        return None
    _known(found, entry.coefficients, source, path)
    given = {key: _number(value, 0, 1e6, source, f'{path}.{key}', '1')
             for key, value in found.items()}
    if entry.coefficients == LEAKAGE:
        surface = leakage(given)
    elif not content.get('displacement_cc_rev'):
        raise InputError(f"{source}: '{path}' by coefficients needs 'motor.displacement_cc_rev'; "
                         'add it')
    else:
        surface = torque_efficiency(given, to_si(_number(
            content['displacement_cc_rev'], 0.1, 50000, source, 'motor.displacement_cc_rev',
            'cc/rev'), 'cc/rev'))
    usual = float(from_si(surface(to_si(100.0, 'bar'), to_si(100.0, 'rpm')), entry.unit))
    if usual > entry.high or 0 < usual <= entry.low:
        raise InputError(
            f"{source}: '{path}' gives {usual:.3g}{f' {entry.unit}' * (entry.unit != '1')} at "
            f'100 bar and 100 rpm, outside the physical range {entry.low:g} to {entry.high:g}; '
            'check the coefficients and their units')
    return surface


def _table(entry: Table, found, source: str, path: str) -> Curve | Surface:
    keys = (*(key for key, _ in entry.axes), entry.value)
    _known(found, (*keys, *entry.coefficients), source, path)
    for key in keys:
        if key not in found:
            raise InputError(f"{source}: key '{path}.{key}' is missing; add it")
    axes = []
    for key, unit in entry.axes:
        axis = _list(found[key], -1e6, 1e6, source, f'{path}.{key}', unit)
        fall = np.flatnonzero(np.diff(axis) <= 0)
        if len(fall):
            at = fall[0] + 1
            raise InputError(f"{source}: '{path}.{key}[{at}]' is {axis[at]:g} after "
                             f'{axis[at - 1]:g}; expected strictly rising values; sort the table')
        axes.append(to_si(axis, unit))
    key = f'{path}.{entry.value}'
    if len(axes) == 1:
        values = _list(found[entry.value], entry.low, entry.high, source, key, entry.unit)
        if len(values) != len(axes[0]):
            raise InputError(f"{source}: '{key}' has {len(values)} values, expected "
                             f"{len(axes[0])} as in '{entry.axes[0][0]}'")
        fall = np.flatnonzero(np.diff(values) < 0)
        if entry.rising and len(fall):
            raise InputError(f"{source}: '{key}[{fall[0] + 1}]' is {values[fall[0] + 1]:g} after "
                             f'{values[fall[0]]:g}; expected values that do not fall')
        return Curve(axes[0], to_si(values, entry.unit))
    rows = found[entry.value]
    if not isinstance(rows, list) or len(rows) != len(axes[0]):
        count = f'has {len(rows)} rows' if isinstance(rows, list) else f'is {_shown(rows)}'
        raise InputError(f"{source}: '{key}' {count}, expected {len(axes[0])} rows: one for "
                         f"each value of '{entry.axes[0][0]}'")
    grid = []
    for index, row in enumerate(rows):
        values = _list(row, entry.low, entry.high, source, f'{key}[{index}]', entry.unit)
        if len(values) != len(axes[1]):
            raise InputError(f"{source}: '{key}[{index}]' has {len(values)} values, expected "
                             f"{len(axes[1])}: one for each value of '{entry.axes[1][0]}'")
        grid.append(values)
    return Surface(axes[0], axes[1], to_si(np.array(grid), entry.unit))


def _sensors(found, source: str) -> dict[str, Sensor]:
    _known(found, tuple(SENSOR_UNITS), source, 'sensors')
    sensors = {}
    for name, content in found.items():
        suffix, unit = SENSOR_UNITS[name]
        keys = tuple(f'{key}_{suffix}' for key in ('noise_std', 'resolution', 'zero_std', 'range'))
        where = f'sensors.{name}'
        delays = {} if CHANNELS[name].slow else _DELAYS
        _known(content, (*keys, *delays), source, where)
        if not {keys[0], keys[2], *delays} & content.keys():
            raise InputError(f"{source}: key '{where}.{keys[0]}' is missing; add it")
        noise, step, zero = (difference_to_si(_number(
            content.get(key, 0), 0, 1e6, source, f'{where}.{key}', unit), unit)
            for key in keys[:3])
        limits = None
        if keys[3] in content:
            limits = _limits(content[keys[3]], source, f'{where}.{keys[3]}', unit)
        late = {key.removesuffix('_s'): _number(content[key], *ends, source, f'{where}.{key}', 's')
                for key, ends in delays.items() if key in content}
        sensors[name] = Sensor(noise, step, limits, zero, **late)
    return sensors


def _tolerances(found, source: str) -> dict[str, float]:
    where = 'tolerances_1_sigma_relative'
    _known(found, TOLERANCES, source, where)
    return {key: _number(value, 0, 0.5, source, f'{where}.{key}', '1')
            for key, value in found.items()}


def _factors(found, source: str) -> dict[str, float]:
    _known(found, TOLERANCES, source, 'calibration')
    return {key: _number(value, *FACTORS, source, f'calibration.{key}', '1')
            for key, value in found.items()}
