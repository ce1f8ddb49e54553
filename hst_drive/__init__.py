# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Hydrostatic rotary drive of a drill rig: model, nodes, and what the model lacks."""
from importlib import import_module
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from hst_drive.api import (
        adopt, commission, compare, design, diagnose, effects, load_rig, losses, read_log,
        simulate)
    from hst_drive.errors import InputError

__all__ = ['InputError', 'adopt', 'commission', 'compare', 'design', 'diagnose', 'effects',
           'load_rig', 'losses', 'read_log', 'simulate']
__version__ = '0.1.0'
# All of it is imported when it is asked for: verbs and nodes start without. These functions are
# packages that can be called (as_function).
_PACKAGES = ('design', 'diagnose', 'effects', 'losses')


def __getattr__(name: str) -> Any:
    if name in _PACKAGES:
        return import_module(f'{__name__}.{name}')
    if name in __all__:
        return getattr(import_module(f'{__name__}.{"errors" if name == "InputError" else "api"}'),
                       name)
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith('__'))})
