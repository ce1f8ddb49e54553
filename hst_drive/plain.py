# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Results as JSON knows them."""
from __future__ import annotations

from collections.abc import Mapping
import dataclasses
import math
import os


def plain(value: object) -> object:
    """
    Return a value as JSON knows it.

    Numbers that are not finite become None; named tuples and dataclasses become mappings, other
    tuples, sets and NumPy arrays lists, NumPy scalars numbers, paths texts.
    """
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, float):
        # float(): a NumPy float64 is a float, but must not reach the file as one.
        return float(value) if math.isfinite(value) else None
    if hasattr(value, '_asdict'):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {entry.name: plain(getattr(value, entry.name))
                for entry in dataclasses.fields(value)}
    if isinstance(value, (set, frozenset)):
        return [plain(entry) for entry in sorted(value)]
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if hasattr(value, 'tolist'):
        return plain(value.tolist())
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f'no JSON form for {type(value).__name__}')
