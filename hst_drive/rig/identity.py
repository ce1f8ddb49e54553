# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which rig is meant: a short digest of its numbers, whatever its file's name and comments."""
from __future__ import annotations

import hashlib
import json

# What people call a rig, and where its numbers come from, does not make it another rig.
_ASIDE = ('name', 'provenance')


def digest(content: dict) -> str:
    """Return a digest of the mapping of a rig file."""
    told = {key: _plain(value) for key, value in content.items() if key not in _ASIDE and value}
    text = json.dumps(told, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _plain(value: object) -> object:
    """Return a value with all numbers as floats: 200 and 200.0 are the same."""
    if isinstance(value, dict):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_plain(entry) for entry in value]
    return float(value) if isinstance(value, int) else value
