# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Kinds of files, told apart by their first bytes."""
from __future__ import annotations

from pathlib import Path

MCAP_MAGIC = b'\x89MCAP0\r\n'


def is_mcap(path: Path) -> bool:
    """Tell whether a file begins as an MCAP file does."""
    with open(path, 'rb') as file:
        return file.read(len(MCAP_MAGIC)) == MCAP_MAGIC
