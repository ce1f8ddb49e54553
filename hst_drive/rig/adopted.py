# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a rig file has adopted: its effects are read as strictly as the rest of it."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
import math
from reprlib import repr as short

from hst_drive.effects import catalogue, left_out, Parameter
from hst_drive.errors import InputError
from hst_drive.units import for_people, si_unit, to_si, UnitError

_OWN = 'see hst-drive effects; if it is one of your own, install the package that declares it'
INERTIA_KEY = 'inertia_total_kg_m2'
_HUGE = 1e300   # an integer may be too large for a float


def with_delays(rig: dict, delays: Mapping[str, float]) -> dict:
    """
    Return the mapping of a rig file whose sensors read later, each by so much (s).

    None reads early: where all seem to, commands were recorded late, up to a row each.
    """
    known = rig.get('sensors') or {}
    late = {name: known.get(name, {}).get('delay_s', 0.0) + delay
            for name, delay in delays.items()}
    early = min([0.0, *late.values()])
    return {**rig, 'sensors': {**known, **{
        name: {**known.get(name, {}), 'delay_s': round(delay - early, 6)}
        for name, delay in late.items()}}} if late else rig


def with_inertia(rig: dict, inertia: float) -> dict:
    """Return the mapping of a rig file with the inertia (kg.m^2) that logs told; 0: as it is."""
    return {**rig, 'motor': {
        **rig['motor'], INERTIA_KEY: float(f'{inertia:.4g}')}} if inertia else rig


def read_effects(found: object, source: str,
                 sizes: tuple[float, float, float] | None) -> dict[str, dict[str, float]]:
    """
    Read ``id: {parameter: value}``, values in SI or texts with a unit.

    A parameter that is left out is neutral: a file that was adopted before an effect got that
    parameter keeps the model that was fitted. The first parameter is the effect's size and must
    be there. Bounds are those of a machine of such ``sizes`` (``Rig.sizes``), or of any.

    Raises
    ------
    InputError
        If effect or parameter is not known, the size is missing, or a value is no finite number
        within the parameter's bounds.

    """
    if not isinstance(found, dict):
        raise InputError(f"{source}: 'effects' is {_shown(found)}, expected effects by id")
    return {str(name): _effect(str(name), content, source, sizes)
            for name, content in found.items()}


def _effect(name: str, content: object, source: str,
            sizes: tuple[float, float, float] | None) -> dict[str, float]:
    effects = catalogue(everything=True)
    where = f'effects.{name}'
    if name not in effects:
        reason = next((line for line in left_out() if f"'{name}'" in line), None)
        raise InputError(f"{source}: unknown effect '{where}'; "
                         f'{reason or _near(name, effects, _OWN)}')
    if not isinstance(content, dict):
        raise InputError(f"{source}: '{where}' is {_shown(content)}, expected parameters")
    effect = effects[name]
    declared = {entry.name: entry.sized(*sizes) if sizes else entry.of_any_size
                for entry in effect.parameters}
    for key in content:
        if key not in declared:
            known = f'known: {", ".join(declared)}'
            raise InputError(f"{source}: unknown key '{where}.{key}'; "
                             f'{_near(str(key), declared, known)}')
    size = effect.size
    if size.name not in content:
        raise InputError(f"{source}: key '{where}.{size.name}' is missing; add the effect's size, "
                         f'{size.low:g} to {size.high:g} {size.unit}')
    return {key: _number(content[key], entry, source, f'{where}.{key}') if key in content
            else effect.neutral[key] for key, entry in declared.items()}


def _number(value: object, declared: Parameter, source: str, key: str) -> float:
    unit = '' if declared.unit == '1' else f' {declared.unit}'
    if isinstance(value, str):
        value = _with_unit(value, declared, source, key)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"{source}: '{key}' is {_shown(value)}, expected a number"
                         f"{unit and ' in'}{unit}")
    # An integer may be too large for a float: compare first.
    if value != declared.neutral and not declared.low <= value <= declared.high:
        found = f'{value:g}' if isinstance(value, float) else short(value)
        raise InputError(f"{source}: '{key}' is {found}{unit}{_read(declared, value)}, outside "
                         f'the plausible range {declared.low:g} to {declared.high:g}{unit}'
                         f'{_read(declared, declared.low, declared.high)}; check the value and '
                         'its unit')
    return float(value)


def _read(declared: Parameter, *values: float) -> str:
    """Return numbers as people read them; '' where that is how they stand."""
    unit = for_people(1.0, declared.unit)[1]
    return '' if unit == declared.unit else ' (' + ' to '.join(
        f'{for_people(min(max(value, -_HUGE), _HUGE), declared.unit)[0]:.4g}'
        for value in values) + f' {unit})'


def _with_unit(text: str, declared: Parameter, source: str, key: str) -> float:
    """Read '12 N.m'; a bare number in quotes has no unit unless the parameter has none."""
    number, _, unit = text.strip().partition(' ')
    expected = declared.unit
    try:
        value, unit = float(number), unit.strip() or '1'
        if math.isfinite(value):
            if unit == expected:    # also a unit of another package's effect
                return value
            if si_unit(unit) == expected:
                return float(to_si(value, unit))
    except (ValueError, UnitError):
        pass
    raise InputError(f"{source}: '{key}' is {short(text)}, expected a number with a unit of "
                     f"[{expected}], as '{declared.example}'")


def _near(word: str, known: Iterable[str], otherwise: str) -> str:
    near = get_close_matches(word, list(known), n=1)
    return f"did you mean '{near[0]}'?" if near else otherwise


def _shown(value: object) -> str:
    return 'empty' if value is None else short(value)
