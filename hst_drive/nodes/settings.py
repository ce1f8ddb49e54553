# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Effects as text, the form in which they pass through a command line and a ROS parameter."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
import math
import re
from typing import Any

from hst_drive.effects import catalogue, unknown_effect
from hst_drive.effects.base import Parameter
from hst_drive.errors import InputError
from hst_drive.rig import load_rig, Rig
from hst_drive.units import parse_header, si_unit, to_si, UnitError

_FORM = re.compile(r'([\w-]+)(?:\.([\w-]+)\s*=\s*([^\[\]\s]+)\s*(\[[^\]]*\])?)?')


def rig_of(settings: Mapping[str, Any]) -> Rig:
    """Return the rig of a node's parameters ``rig`` and ``circuit``, which must agree."""
    rig = load_rig(settings['rig'])
    if rig.circuit != settings['circuit']:
        raise InputError(f"parameter circuit: is '{settings['circuit']}', but {rig.source} has "
                         f"'circuit: {rig.circuit}'; give both alike")
    return rig


def effects_in(rig: Rig, texts: Iterable[str]) -> dict[str, dict[str, float]]:
    """Read effects as ``parse_effects`` does; each must have a place in the rig's circuit."""
    effects = parse_effects(texts)
    if effects:
        # Late: a start without effects needs no model for this.
        from hst_drive.model.circuit_model import part_model, refuse_placeless

        refuse_placeless(part_model(rig), effects)
    return effects


def parse_effects(texts: Iterable[str]) -> dict[str, dict[str, float]]:
    """
    Read effects given as ``id.parameter=value``, ``id.parameter=value[unit]`` or ``id``.

    Without a unit the value is in SI; a parameter that is not given has its typical value.

    Returns
    -------
    dict
        Effect id to parameter values in SI.

    Raises
    ------
    InputError
        If a text has another form, names an effect or a parameter that does not exist, or has
        a value outside the parameter's bounds.

    """
    effects: dict[str, dict[str, float]] = {}
    for text in texts:
        if not text.strip():
            continue
        match = _FORM.fullmatch(text.strip())
        if not match:
            raise InputError(f"effect '{text}': expected id.parameter=value or "
                             'id.parameter=value[unit]')
        name, parameter, value, unit = match.groups()
        if name not in catalogue():
            raise InputError(f"effect '{text}': {unknown_effect(name)}")
        values = effects.setdefault(name, {})
        if parameter:
            declared = {entry.name: entry for entry in catalogue()[name].parameters}
            if parameter not in declared:
                near = get_close_matches(parameter, declared, n=1)
                hint = f"did you mean '{near[0]}'?" if near else f'known: {", ".join(declared)}'
                raise InputError(f"effect '{text}': unknown parameter of {name} '{parameter}'; "
                                 f'{hint}')
            number = _number(text, value, unit, declared[parameter].unit)
            _plausible(text, number, declared[parameter])
            values[parameter] = number
    return effects


def _plausible(text: str, number: float, declared: Parameter) -> None:
    if number != declared.neutral and not declared.low <= number <= declared.high:
        raise InputError(f"effect '{text}': {number:g} {declared.unit} is outside the plausible "
                         f'range {declared.low:g} to {declared.high:g} {declared.unit}; check the '
                         'value and its unit')


def _number(text: str, value: str, unit: str | None, expected: str) -> float:
    try:
        number = float(value)
        if unit:
            unit = parse_header(f'value{unit}')[1]
            if si_unit(unit) != expected:
                raise UnitError(f'[{unit}] is no unit of [{expected}]')
            number = float(to_si(number, unit))
    except (UnitError, ValueError) as error:
        raise InputError(f"effect '{text}': {error}; expected a number in [{expected}]") from None
    if not math.isfinite(number):
        raise InputError(f"effect '{text}': expected a finite number in [{expected}]")
    return number


def effect_texts(effects: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Return effects as the texts that ``parse_effects`` reads."""
    return [text for name, values in effects.items() for text in (
        [f'{name}.{key}={float(value)!r}' for key, value in values.items()] or [name])]
