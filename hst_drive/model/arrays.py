# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The functions of effects, which are written for numbers, over whole records."""
from __future__ import annotations

import math
from types import FunctionType
from typing import Any, Callable, Mapping

from hst_drive.effects.base import arguments
import numpy as np

# What counts as nothing where a part has it not: a mass on a known torque has no pressure.
_NOTHING = ('pressure', 'pump_pressure')


def evaluate(function: Callable[..., Any], known: Mapping[str, Any]) -> Any:
    """Call an effect's function with arrays; 0 where it reads what is not known."""
    values = []
    for name in arguments(function):
        if name not in known and name not in _NOTHING:
            return 0.0
        values.append(known.get(name, 0.0))
    try:
        result = _over_arrays(function)(*values)
    except ValueError:
        # A function that branches: sample by sample.
        result = np.vectorize(function, otypes=[float])(*values)
    return result


class _Math:
    """The names of module ``math``, for arrays."""

    pi, e, tau, inf, nan = math.pi, math.e, math.tau, math.inf, math.nan
    acos, asin, atan, atan2 = np.arccos, np.arcsin, np.arctan, np.arctan2
    acosh, asinh, atanh, pow = np.arccosh, np.arcsinh, np.arctanh, np.power

    def __getattr__(self, name: str):
        return getattr(np, name)


def _extreme(pair: Callable) -> Callable:
    def of(first, *rest):
        for value in rest:
            first = pair(first, value)
        return first
    return of


def _over_arrays(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return an effect's function with 'math', 'min', 'max' and 'abs' for arrays."""
    arrays = {'max': _extreme(np.maximum), 'min': _extreme(np.minimum), 'abs': np.abs}
    for name in function.__code__.co_names:
        value = function.__globals__.get(name)
        if value is math:
            arrays[name] = _Math()
        elif callable(value) and getattr(math, name, None) is value:
            arrays[name] = getattr(_Math(), name)
        elif value is not None:
            arrays[name] = value
    return FunctionType(function.__code__, arrays)
