# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The catalogue: one file per physical effect, found by looking into this folder.

Another package brings its own through the entry-point group ``hst_drive.effects``: each entry
names an ``Effect``.
"""
from __future__ import annotations

from functools import lru_cache
from importlib import import_module
from importlib.metadata import entry_points
import pkgutil

from hst_drive.effects.base import Effect, Parameter, READABLE, Slot, SLOTS

__all__ = ['Effect', 'Parameter', 'READABLE', 'SLOTS', 'Slot', 'catalogue']


@lru_cache(maxsize=1)
def catalogue() -> dict[str, Effect]:
    """
    Return all effects by id, those of this package first.

    Raises
    ------
    ValueError
        If two effects have one id.

    """
    found: dict[str, Effect] = {}
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    own = [import_module(f'{__name__}.{name}') for name in names if name not in ('base', 'oil')]
    foreign = [entry.load() for entry in entry_points(group='hst_drive.effects')]
    for effect in [module.EFFECT for module in own] + foreign:
        if effect.id in found:
            raise ValueError(f"effect '{effect.id}' is declared twice")
        found[effect.id] = effect
    return found
