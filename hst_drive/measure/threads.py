# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Work on all cores: what is compiled runs beside the interpreter."""
from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
import os
from typing import Callable, Iterable, Iterator, TypeVar

_Item, _Found = TypeVar('_Item'), TypeVar('_Found')


def each(work: Callable[[_Item], _Found], items: Iterable[_Item]) -> Iterator[_Found]:
    """Yield what a function returns for each item, in their order."""
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        yield from pool.map(work, items)
