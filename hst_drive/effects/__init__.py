# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The catalogue: one file per physical effect, found by looking into this folder.

Another package brings its own through the entry-point group ``hst_drive.effects``: each entry
names an ``Effect``.
"""
from __future__ import annotations

from difflib import get_close_matches
from functools import lru_cache
from importlib import import_module
from importlib.metadata import entry_points
import math
import pkgutil
from typing import Iterable

from hst_drive.as_function import make_callable
from hst_drive.effects.base import arguments, Effect, Parameter
from hst_drive.effects.formula import FORMULAS
from hst_drive.effects.slots import READABLE, readable, Slot, SLOTS
from hst_drive.errors import InputError

__all__ = ['Effect', 'GROUP', 'Parameter', 'READABLE', 'SLOTS', 'Slot', 'catalogue', 'edition',
           'effect_of', 'flexible', 'left_out', 'origin', 'readable', 'register']
make_callable(__name__)

GROUP = 'hst_drive.effects'
_HERE = 'registered here'
_editions: list[str] = []
_NOT_EFFECTS = ('base', 'formula', 'oil', 'slots')


def catalogue(everything: bool = False) -> dict[str, Effect]:
    """
    Return all effects by id, those of this package first.

    Parameters
    ----------
    everything : bool
        Add the formulas that stand for what has no name.

    """
    return {**_found()[0], **FORMULAS} if everything else _found()[0]


def effect_of(name: str) -> Effect:
    """Return an effect, or a formula that stands for one, by its id; KeyError if there is none."""
    return FORMULAS[name] if name in FORMULAS else _found()[0][name]


def flexible(names: Iterable[str]) -> bool:
    """Say whether one of some effects is a shaft that twists."""
    return any(effect_of(name).slot == 'shaft_compliance' for name in names)


def unknown_effect(name: object, *others: str) -> str:
    """Say that there is no such effect; the nearest (or other) name, or why it was left out."""
    near = get_close_matches(str(name), [*_found()[0], *others], n=1)
    hint = f"did you mean '{near[0]}'?" if near else "see 'hst-drive effects'"
    hint = next((line for line in left_out() if f"'{name}'" in line), hint)
    return f"unknown effect '{name}'; {hint}"


def left_out() -> tuple[str, ...]:
    """Return one line per effect of another package that cannot be used: which, and why."""
    return _found()[2]


def origin(identity: str) -> str:
    """Return the package that an effect comes from."""
    return _found()[1][identity]


def register(effect: Effect) -> None:
    """
    Add an effect of your own to the catalogue until the program ends.

    For trying it out; an entry point of a package (``GROUP``) adds it for good. Under the id of
    an effect that was registered before it takes that one's place.

    Raises
    ------
    InputError
        If it does not fit into the drive; one line that says why.

    """
    effects, origins, _ = _found()
    others = {name: entry for name, entry in effects.items() if origins[name] != _HERE}
    try:
        _refuse_unusable(effect, others)
    except Exception as problem:
        raise InputError(f"effect '{getattr(effect, 'id', effect)}' cannot be registered: "
                         f'{problem}') from None
    effects[effect.id] = effect
    origins[effect.id] = _HERE
    _editions.append(effect.id)


def edition() -> int:
    """Return a number that changes with the catalogue."""
    return len(_editions)


@lru_cache(maxsize=1)
def _found() -> tuple[dict[str, Effect], dict[str, str], tuple[str, ...]]:
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    own = [import_module(f'{__name__}.{name}').EFFECT for name in names
           if name not in _NOT_EFFECTS]
    effects = {effect.id: effect for effect in own}
    origins = dict.fromkeys(effects, 'hst_drive')
    problems = []
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: (entry.name, entry.value)):
        package = entry.dist.name if entry.dist else entry.value
        try:
            effect = entry.load()
            _refuse_unusable(effect, effects)
        except (Exception, SystemExit) as problem:
            # Whatever goes wrong in there is not ours, and must not stop the program.
            reason = ' '.join(str(problem).split()) or type(problem).__name__
            problems.append(f"effect '{entry.name}' of package '{package}' is left out: {reason}; "
                            f"correct '{entry.value}' or remove the package")
            continue
        effects[effect.id] = effect
        origins[effect.id] = package
    return effects, origins, tuple(problems)


def _refuse_unusable(effect: object, known: dict[str, Effect]) -> None:
    """Raise an exception unless a foreign effect fits into the drive."""
    if not isinstance(effect, Effect):
        raise TypeError(f'expected an hst_drive.effects.Effect, found {type(effect).__name__}')
    if effect.id in known or effect.id in FORMULAS:
        raise ValueError(f"there is an effect '{effect.id}' already")
    if any(slot == 'shaft_compliance' for slot, _ in effect.terms):
        raise ValueError("the drive has one flexible shaft: slot 'shaft_compliance' is taken")
    for slot, function in effect.terms:
        value = function(*(effect.typical.get(name, 1.0) for name in arguments(function)))
        if not math.isfinite(value):
            raise ValueError(f"its term at the slot '{slot}' is {value} where all that it reads "
                             'is 1')
