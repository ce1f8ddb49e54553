# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Results on disk: one JSON file per campaign, whole or not at all, found again by content."""
from __future__ import annotations

import json
import os
from pathlib import Path
import tempfile

from hst_drive.errors import InputError
from hst_drive.fleet.task import SCHEMA


class Store:
    """
    A folder of rows; it is made if it is not there.

    InputError is raised if it cannot be made or written.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError as error:
            raise InputError(f'{folder}: cannot be written: {error.strerror}') from None

    def path(self, key: str) -> Path:
        """Return where the row of a key is."""
        return self.folder / f'{key}.json'

    def get(self, key: str) -> dict | None:
        """Return a row; None if it is not there, or not one."""
        try:
            row = json.loads(self.path(key).read_text(encoding='utf-8'))
        except (OSError, ValueError):
            return None
        return row if isinstance(row, dict) and row.get('schema') == SCHEMA else None

    def put(self, key: str, row: dict) -> None:
        """Write a row; who reads at the same time sees the old one or the new one."""
        handle, draft = tempfile.mkstemp(dir=self.folder, prefix='.', suffix='.draft')
        try:
            with os.fdopen(handle, 'w', encoding='utf-8') as file:
                json.dump(row, file, ensure_ascii=False, allow_nan=False)
                file.flush()
                os.fsync(file.fileno())
            os.replace(draft, self.path(key))
        except BaseException:
            Path(draft).unlink(missing_ok=True)
            raise
