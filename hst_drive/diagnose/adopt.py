# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Adoption: what a diagnosis found becomes part of the rig."""
from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from types import MappingProxyType

from hst_drive.diagnose.result import require_schema
from hst_drive.effects import catalogue, effect_of
from hst_drive.effects.formula import FORMULAS
from hst_drive.errors import InputError
from hst_drive.rig.adopted import with_delays, with_inertia
from hst_drive.rig.fingerprint import SECTION
from hst_drive.rig.identity import digest
from hst_drive.rig.schema import TOLERANCES


def adopt(rig: dict, diagnosis: dict, source: str, rig_source: str, *,
          formula: bool = False, calibration: bool = False,
          dates: Mapping[str, str] = MappingProxyType({})) -> dict:
    """
    Return the mapping of a rig file with the effects that a diagnosis found.

    One that the rig has adopted before gets its new size, or goes if it is gone; its history
    stays under 'provenance'.

    Parameters
    ----------
    rig : dict
        Mapping of the rig file that was diagnosed.
    diagnosis : dict
        What ``diagnose --json`` wrote.
    source, rig_source : str
        Their files, for messages.
    formula : bool
        Adopt the formula for the unknown as well, beside the effects as they were fitted with it.
    calibration : bool
        Where nothing is missing: adopt by how much the unit is off its datasheet.
    dates : mapping of str to str
        Days for the history, as ``recorded`` and ``adopted``.

    Raises
    ------
    InputError
        If the file is no diagnosis, names no effect, was made with another rig, or was adopted
        already.

    """
    require_schema(diagnosis, source)
    effects = diagnosis.get('effects')
    if not isinstance(effects, list) or not all(isinstance(entry, dict) for entry in effects):
        raise InputError(f"{source}: key 'effects' is {type(effects).__name__}, expected a list "
                         'of effects; write the diagnosis again')
    if formula:
        effects = [*_beside(effects, diagnosis, source), _formula(diagnosis, source)]
    none = diagnosis.get('verdict') == 'none'
    if calibration and not none:
        raise InputError(f"{source}: the diagnosis is '{diagnosis.get('verdict')}': the unit's "
                         'calibration goes with its effects; leave --calibration out')
    if calibration and SECTION in rig:
        raise InputError(f'{rig_source}: is the file of a machine that was commissioned: its '
                         'numbers are its own already; leave --calibration out, or commission it '
                         "again from the make's file, with these logs")
    if not effects and not calibration:
        if _formula_of(diagnosis):
            raise InputError(f"{source}: the diagnosis is 'unknown' and names no effect; add "
                             '--formula to adopt its formula')
        raise InputError(f"{source}: the diagnosis is '{diagnosis.get('verdict')}' and names no "
                         'effect: there is nothing to adopt' + (
                             '; add --calibration to adopt by how much this unit is off its '
                             'datasheet' if none and SECTION not in rig else ''))
    names = [str(entry.get('id')) for entry in effects]
    already = [name for name in names if name in (rig.get('effects') or {})]
    expected = diagnosis.get('rig_digest')
    if expected != digest(rig):
        if already:
            raise InputError(f"{rig_source}: effect '{already[0]}' is adopted already; diagnose "
                             'again with --rig and this file to see what else is missing, or has '
                             'changed')
        if diagnosis.get('since') and SECTION not in rig:
            raise InputError(f"{source}: was made with a machine's own file, or with --since, "
                             f"on {diagnosis.get('rig')}: give the machine's file with --rig; "
                             "without one write it ('hst-drive commission OLD... -o unit.yaml'), "
                             'diagnose with --rig unit.yaml and adopt that')
        if diagnosis.get('rig') == rig_source:
            raise InputError(f'{rig_source}: has changed since it was diagnosed; diagnose again')
        raise InputError(f'{rig_source}: is not the rig that was diagnosed '
                         f"({diagnosis.get('rig')}); give that one with --rig, or diagnose again "
                         'with this one')
    adopted = with_inertia(with_delays(deepcopy(rig), _numbers(
        diagnosis, source, 'sensor_delays', 'channel', 'value')), _inertia(diagnosis, source))
    found = {name: _values(entry, source) for name, entry in zip(names, effects)}
    gone = {name for name, entry in zip(names, effects) if entry.get('change') == 'gone'}
    adopted['effects'] = {name: values for name, values
                          in {**(rig.get('effects') or {}), **found}.items() if name not in gone}
    factors = dict(rig.get('calibration') or {})
    moved = _known_factors(_numbers(diagnosis, source, 'calibration', 'quantity', 'factor'),
                           source, 'calibration')
    if formula:
        moved = _known_factors(effects[-1].get('factors', {}), source, 'unknown.formula.factors')
    if SECTION not in rig:
        # Those of a commissioned machine are its own; they follow the oil of the day already.
        for key, factor in moved.items():
            factors[key] = float(f'{factors.get(key, 1.0) * factor:.8g}')
    adopted['calibration'] = factors
    past = list((rig.get('provenance') or {}).get('adopted') or [])
    adopted['provenance'] = {**(rig.get('provenance') or {}), 'adopted': [
        *past, {**dates, **_provenance(diagnosis, source, names, effects), **(
            {'changed': {name: {'from': rig['effects'][name], 'to': found[name],
                                'change': entry.get('change')}
                         for name, entry in zip(names, effects) if name in already}}
            if already else {})}]}
    return adopted


def _values(entry: dict, source: str) -> dict[str, float]:
    name = str(entry.get('id'))
    if name not in catalogue(everything=True):
        raise InputError(f"{source}: effect '{name}' is not in the catalogue; see "
                         "'hst-drive effects'")
    try:
        values = {str(key): float(value['value']) for key, value in entry['parameters'].items()}
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(f"{source}: effect '{name}' has no readable 'parameters'; write the "
                         'diagnosis again') from None
    effect = effect_of(name)
    known = effect.neutral
    for key in values:
        if key not in known:
            raise InputError(f"{source}: effect '{name}' has no parameter '{key}'; it has "
                             f'{", ".join(known)}')
    if effect.size.name not in values:
        raise InputError(f"{source}: effect '{name}' lacks its size '{effect.size.name}'; write "
                         'the diagnosis again')
    if name in FORMULAS:
        # Powers of 0 are what a formula has without being told.
        return {key: value for key, value in values.items()
                if value or key.startswith('coefficient')}
    # What the diagnosis did not know of was not there when it was fitted.
    return {**{entry.name: entry.neutral for entry in effect.own}, **values}


def _formula_of(diagnosis: dict) -> dict | None:
    unknown = diagnosis.get('unknown')
    found = unknown.get('formula') if isinstance(unknown, dict) else None
    return found if isinstance(found, dict) else None


def _formula(diagnosis: dict, source: str) -> dict:
    found = _formula_of(diagnosis)
    if found is None or found.get('id') not in FORMULAS:
        raise InputError(f"{source}: the diagnosis is '{diagnosis.get('verdict')}' and has no "
                         'formula that lowers the error; leave --formula out')
    return found


def _beside(effects: list[dict], diagnosis: dict, source: str) -> list[dict]:
    """Return the effects with the values that they have beside the formula."""
    values = _formula(diagnosis, source).get('beside')
    moved = []
    for entry in effects:
        own = values.get(entry.get('id')) if isinstance(values, dict) else None
        parameters = entry.get('parameters')
        if not isinstance(own, dict) or not isinstance(parameters, dict):
            raise InputError(f"{source}: key 'unknown.formula.beside' lacks '{entry.get('id')}'; "
                             'write the diagnosis again')
        moved.append({**entry, 'parameters': {
            key: {**value, 'value': own.get(key)} if isinstance(value, dict) else value
            for key, value in parameters.items()}})
    return moved


def _numbers(diagnosis: dict, source: str, where: str, what: str, number: str) -> dict[str, float]:
    """Return the numbers by name that a list of a diagnosis tells."""
    try:
        return {str(entry[what]): float(entry[number]) for entry in diagnosis.get(where, [])}
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{source}: key '{where}' is no list with '{what}' and "
                         f"'{number}' in each entry; write the diagnosis again") from None


def _inertia(diagnosis: dict, source: str) -> float:
    """Return the inertia that a diagnosis found, kg.m^2; 0 if it found none."""
    try:
        return float((diagnosis.get('inertia') or {'value': 0.0})['value'])
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{source}: key 'inertia' has no number as its 'value'; write the "
                         'diagnosis again') from None


def _known_factors(factors: object, source: str, where: str) -> dict[str, float]:
    if not isinstance(factors, dict):
        raise InputError(f"{source}: key '{where}' is {type(factors).__name__}, expected factors "
                         'by quantity; write the diagnosis again')
    for key, value in factors.items():
        if key not in TOLERANCES:
            raise InputError(f"{source}: key '{where}' names '{key}'; known: "
                             f'{", ".join(TOLERANCES)}')
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{source}: key '{where}.{key}' is {value!r}, expected a number; "
                             'write the diagnosis again')
    return factors


def _provenance(diagnosis: dict, source: str, names: list[str], effects: list[dict]) -> dict:
    return {
        'diagnosis': source, 'verdict': diagnosis.get('verdict'),
        'logs': _texts(diagnosis.get('logs')),
        'held_out_noise_ratio': diagnosis.get('holdout'),
        'intervals_95_percent': {
            name: {key: [value.get('low'), value.get('high'), value.get('unit')]
                   for key, value in entry['parameters'].items()}
            for name, entry in zip(names, effects)},
        'indistinguishable_from': {name: _texts(entry.get('indistinguishable_from'))
                                   for name, entry in zip(names, effects)},
    }


def _texts(found: object) -> list[str]:
    """Return a list of texts; what is none is only told, not used, and so no reason to refuse."""
    return [str(entry) for entry in found] if isinstance(found, list) else []
