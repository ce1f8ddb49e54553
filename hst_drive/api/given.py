# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Arguments of another kind than asked for get one line that says what was expected."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
import math
import os
from typing import Any

from hst_drive.errors import InputError

TABLE = 'a path, a pandas frame or a mapping of columns'


def number(value: Any, name: str, what: str = 'a number') -> float:
    """Return an argument that is a finite number."""
    if isinstance(value, bool) or not hasattr(value, '__float__') or not math.isfinite(value):
        raise InputError(f'{name}: found {value!r}, expected {what}')
    return float(value)


def whole(value: Any, name: str) -> int:
    """Return an argument that is a whole number, 0 or more."""
    if isinstance(value, bool) or not hasattr(value, '__index__') or value < 0:
        raise InputError(f'{name}: found {value!r}, expected a whole number from 0 on')
    return int(value)


def ids(value: Any, name: str) -> list[str]:
    """Return an argument that is the id of an effect, or several."""
    found = [value] if isinstance(value, str) or not isinstance(value, Iterable) else list(value)
    if not all(isinstance(entry, str) for entry in found):
        raise InputError(f'{name}: found {value!r}, expected ids of effects')
    return found


def sizes(value: Any, name: str) -> dict[str, dict[str, Any]]:
    """Return an argument that maps ids of effects to their parameters."""
    if not isinstance(value, Mapping) or not all(isinstance(
            entry, Mapping) for entry in value.values()):
        raise InputError(f'{name}: found {value!r}, expected a mapping of ids of effects to their '
                         "parameters, as {'motor_leakage': {'conductance': '0.0078 L/min/bar'}}")
    return {str(key): dict(entry) for key, entry in value.items()}


def path(value: Any, name: str, what: str = 'the path of a file') -> str:
    """Return an argument that is the path of a file."""
    if not isinstance(value, (str, os.PathLike)):
        raise InputError(f'{name}: found {type(value).__name__}, expected {what}')
    return os.fspath(value)


def progress(value: Any) -> Callable[[str], None]:
    """Return an argument that is called with texts while the work goes on; None: nobody is."""
    if value is not None and not callable(value):
        raise InputError(f'progress: found {value!r}, expected a function, as print')
    return value or (lambda text: None)
