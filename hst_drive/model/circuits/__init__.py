# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Hydraulic circuits beside the open one: one file each, found by looking into this folder."""
from __future__ import annotations

from difflib import get_close_matches
from functools import lru_cache
from importlib import import_module
import pkgutil

from hst_drive.errors import InputError
from hst_drive.model.circuits.base import Balance, Circuit, Input, OF_A_LEAK, Part, State
from hst_drive.rig import Rig
from hst_drive.rig.rig import OPEN

__all__ = ['Balance', 'Circuit', 'Input', 'OF_A_LEAK', 'Part', 'State',
           'circuit_of', 'circuits']


@lru_cache(maxsize=1)
def circuits() -> dict[str, Circuit]:
    """Return all circuits by id."""
    modules = (import_module(f'{__name__}.{entry.name}')
               for entry in pkgutil.iter_modules(__path__))
    return {module.CIRCUIT.id: module.CIRCUIT for module in modules
            if hasattr(module, 'CIRCUIT')}


def circuit_of(rig: Rig) -> Circuit | None:
    """
    Return the circuit that a rig file names; None for the open one.

    Raises
    ------
    InputError
        If it is not known.

    """
    if rig.circuit == OPEN:
        return None
    if rig.circuit not in circuits():
        known = (OPEN, *circuits())
        near = get_close_matches(rig.circuit, known, n=1)
        hint = f"did you mean '{near[0]}'?" if near else f'known: {", ".join(known)}'
        raise InputError(f"{rig.source}: unknown circuit '{rig.circuit}'; {hint}")
    return circuits()[rig.circuit]
