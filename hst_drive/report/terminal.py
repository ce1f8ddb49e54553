# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers and tables as a terminal shows them."""
from __future__ import annotations

from collections.abc import Sequence
import math

from hst_drive.units import for_people

MISSING = '-'


def size(value: float, unit: str, digits: int = 4) -> tuple[str, str]:
    """Return a size in SI as people read it: number and unit as text."""
    shown, read = for_people(value, unit)
    return f'{shown:.{digits}g}', read


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """
    Return a table for a terminal.

    Parameters
    ----------
    header : sequence of str, length n
        Titles of the columns, unit included.
    rows : sequence of sequences, each of length n
        Text, or numbers, which are shown with 3 significant digits; None and NaN show as a dash.

    """
    cells = [[_cell(value) for value in row] for row in rows]
    for row in cells:
        if len(row) != len(header):
            raise ValueError(f'a row of {len(row)} in a table of {len(header)} columns')
    numeric = [bool(rows) and all(_is_number(row[column]) for row in rows)
               for column in range(len(header))]
    widths = [max(map(len, column)) for column in zip(header, *cells)]
    lines = [_line(header, widths, numeric), '  '.join('-' * width for width in widths)]
    lines += [_line(row, widths, numeric) for row in cells]
    return '\n'.join(lines)


def _is_number(value: object) -> bool:
    return value is None or (hasattr(value, '__float__') and not isinstance(value, (bool, str)))


def _cell(value: object) -> str:
    if value is None:
        return MISSING
    if isinstance(value, bool):
        return 'yes' if value else 'no'
    if not _is_number(value) or hasattr(value, '__index__'):
        return str(value)
    number = float(value)
    if not math.isfinite(number):
        return MISSING if math.isnan(number) else f'{number:+}'
    if number and not 1e-4 <= abs(number) < 1e7:
        return f'{number:.2e}'
    magnitude = math.floor(math.log10(abs(number))) if number else 0
    return f'{number:.{max(2 - magnitude, 0)}f}'


def _line(cells: Sequence[str], widths: Sequence[int], numeric: Sequence[bool]) -> str:
    return '  '.join(text.rjust(width) if right else text.ljust(width)
                     for text, width, right in zip(cells, widths, numeric)).rstrip()
