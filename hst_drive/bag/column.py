# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers that come block by block: in memory, or in a file that goes with its process."""
from __future__ import annotations

import os
from tempfile import gettempdir, TemporaryFile

from hst_drive.errors import InputError
import numpy as np

_AT_ONCE = 1 << 26      # bytes; one read gives 2 GiB at most


class Column:
    """
    A row of numbers.

    Parameters
    ----------
    on_disk : bool
        Whether they are kept in a file, in TMPDIR, instead of the memory.

    """

    def __init__(self, on_disk: bool = False):
        self._blocks: list[np.ndarray] = []
        self._type, self._count = np.dtype(float), 0
        self._file = TemporaryFile(prefix='hst_drive_', buffering=0) if on_disk else None

    def append(self, values: np.ndarray) -> None:
        """
        Take more numbers, all of one type.

        Raises
        ------
        InputError
            If the disk is full.

        """
        self._type = values.dtype
        self._count += len(values)
        if self._file is None:
            self._blocks.append(values)
            return
        data = memoryview(np.ascontiguousarray(values)).cast('B')
        try:
            while data:
                data = data[self._file.write(data):]
        except OSError as error:
            raise InputError(f'{gettempdir()}: {error.strerror}; a long bag needs room there for '
                             'its numbers: set TMPDIR to another folder') from None

    def part(self, start: int, stop: int) -> np.ndarray:
        """Return the numbers from one place to another."""
        if self._file is None:
            if len(self._blocks) > 1:
                self._blocks = [np.concatenate(self._blocks)]
            return self._blocks[0][start:stop]
        size = self._type.itemsize
        found = np.empty(max(min(stop, self._count) - start, 0), self._type)
        view = memoryview(found).cast('B')
        done = 0
        while done < len(view):
            piece = os.pread(self._file.fileno(), min(len(view) - done, _AT_ONCE),
                             start * size + done)
            view[done:done + len(piece)] = piece
            done += len(piece)
        return found

    def whole(self) -> np.ndarray:
        """Return all numbers."""
        return self.part(0, self._count)
