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
    told = {key: value for key, value in content.items() if key not in _ASIDE and value}
    text = json.dumps(told, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
