# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The lines of a CSV file and their cells, whatever they hold."""
from __future__ import annotations

from collections.abc import Iterator, Sequence
import csv
from pathlib import Path

from hst_drive.errors import InputError


def read_lines(path: Path) -> tuple[list[str], Sequence[int]]:
    """Return the lines that count, the last with its end, and their numbers in the file."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f'{path}: cannot be read: {error.strerror}; check the path') from None
    if not data.strip():
        raise InputError(f'{path}: the file is empty; expected a header and rows of data')
    if b'\0' in data[:4096]:
        if data[:2] not in (b'\xff\xfe', b'\xfe\xff'):
            raise InputError(f'{path}: not a CSV file (binary content); expected CSV, .mcap or a '
                             'rosbag2 folder')
        text = data.decode('utf-16', 'replace')
    else:
        try:
            text = data.decode('utf-8-sig')
        except UnicodeDecodeError:
            text = data.decode('latin-1')
    # Not splitlines: in text of Windows its ... (0x85) would end a line.
    lines = text.replace('\r\n', '\n').replace('\r', '\n').removesuffix('\n').split('\n')
    last, rows = len(lines), range(1, len(lines) + 1)
    if '#' in text or not all(map(str.strip, lines)):
        rows = [number for number in rows
                if lines[number - 1].strip() and not lines[number - 1].lstrip().startswith('#')]
        if not rows:
            raise InputError(f'{path}: the file holds only comments')
        lines = [lines[number - 1] for number in rows]
    if rows[-1] < last or text.endswith(('\n', '\r')):
        lines[-1] += '\n'
    return lines, rows


def separator_of(header: str) -> str:
    """Return the separator of a header line: comma, semicolon or tab."""
    outside = ''.join(header.split('"')[::2])
    return max((',', ';', '\t'), key=outside.count)


def cells_of(lines: Sequence[str], rows: Sequence[int], separator: str,
             path: str) -> Iterator[list[str]]:
    """Yield the cells of lines, of which ``rows`` are the numbers."""
    reader = csv.reader(lines, delimiter=separator)
    try:
        yield from reader
    except csv.Error as error:
        raise InputError(f'{path}: cannot be read up to row {rows[reader.line_num - 1]} '
                         f'({error}); is a quote (") left open?') from None
