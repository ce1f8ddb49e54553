# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Kinds of files, told apart by their first bytes; the order of those of a bag."""
from __future__ import annotations

from pathlib import Path
import re

MCAP_MAGIC = b'\x89MCAP0\r\n'


def is_mcap(path: Path) -> bool:
    """Tell whether a file begins as an MCAP file does."""
    with open(path, 'rb') as file:
        return file.read(len(MCAP_MAGIC)) == MCAP_MAGIC


def is_finished(path: Path) -> bool:
    """Tell whether a file ends as a finished MCAP file does."""
    size = path.stat().st_size
    with open(path, 'rb') as file:
        file.seek(max(size - len(MCAP_MAGIC), 0))
        return size >= 2 * len(MCAP_MAGIC) and file.read() == MCAP_MAGIC


def by_number(path: Path) -> list[str | int]:
    """Return a key for sorting files as a recorder counts them: ``bag_10`` after ``bag_2``."""
    return [int(part) if part.isdecimal() else part for part in re.split(r'(\d+)', path.name)]
