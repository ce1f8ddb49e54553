# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the verbs print and write: results to standard output, the rest to standard error."""
from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
import dataclasses
import errno
import json
import math
import os
from pathlib import Path
import sys
import tempfile

from hst_drive.errors import InputError
from hst_drive.units import for_people

MISSING = '-'


def say(message: str) -> None:
    """Tell progress or a warning on standard error."""
    print(message, file=sys.stderr, flush=True)


def add_json_argument(parser: argparse.ArgumentParser) -> None:
    """Add ``--json FILE``."""
    parser.add_argument('--json', metavar='FILE',
                        help='also write the result as JSON; - for standard output')


def plain(value: object) -> object:
    """
    Return a value as JSON knows it.

    Numbers that are not finite become None; NumPy scalars and arrays, dataclasses, paths, sets
    and tuples become numbers, lists and strings.
    """
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, float):
        # float(): a NumPy float64 is a float, but must not reach the file as one.
        return float(value) if math.isfinite(value) else None
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


def write_json(data: object, target: str | os.PathLike) -> None:
    """
    Write data as JSON, whole or not at all.

    Parameters
    ----------
    data : object
        What ``plain`` takes.
    target : str or path
        File to replace; '-' for standard output.

    Raises
    ------
    InputError
        When the file cannot be written.

    """
    write_text(json.dumps(plain(data), indent=2, ensure_ascii=False, allow_nan=False) + '\n',
               target)


def write_yaml(data: Mapping, target: str | os.PathLike) -> None:
    """Write a mapping as YAML, in its order and with short lists on one line, whole or not."""
    import yaml

    write_text(yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=99,
                              allow_unicode=True), target)


def check_target(target: str | os.PathLike) -> None:
    """Raise InputError if a file cannot be written: better told before the work than after."""
    path = Path(target)
    if os.fspath(target) == '-' or path.exists() and not path.is_dir() and not path.is_file():
        return
    if path.is_dir():
        raise _unwritable(path, IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR)))
    try:
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as problem:
        raise _unwritable(path, problem) from None


def add_force_argument(parser: argparse.ArgumentParser, name: str) -> None:
    """Add ``--force`` for the file that the help calls ``name``."""
    parser.add_argument('--force', action='store_true', help=f'replace {name} if it exists')


def refuse_to_replace(target: str | os.PathLike, force: bool) -> None:
    """Raise InputError if a file is there; '-', a pipe or a folder is none to replace."""
    if Path(target).is_file() and not force:
        raise InputError(f'{target}: exists already; choose another name, or replace it with '
                         '--force')


def write_text(text: str, target: str | os.PathLike) -> None:
    """Write a text file, whole or not at all; '-' is standard output."""
    if os.fspath(target) == '-':
        sys.stdout.write(text)
        return
    path = Path(target)
    if path.exists() and not path.is_file():
        # /dev/stdout, a named pipe: nothing to replace. A folder is refused by open().
        _write(path, text)
        return
    scratch = None
    try:
        handle, scratch = tempfile.mkstemp(dir=path.parent, prefix=f'.{path.name}.')
        with open(handle, 'w', encoding='utf-8') as stream:
            # mkstemp makes files that nobody else may read.
            os.chmod(scratch, 0o666 & ~_umask())
            stream.write(text)
        os.replace(scratch, path)
    except OSError as problem:
        raise _unwritable(path, problem) from problem
    finally:
        if scratch is not None and os.path.exists(scratch):
            os.unlink(scratch)


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding='utf-8')
    except BrokenPipeError:
        raise
    except OSError as problem:
        raise _unwritable(path, problem) from problem


def _unwritable(path: Path, problem: OSError) -> InputError:
    return InputError(f'{path}: cannot be written ({problem.strerror}); name a file in a folder '
                      'that exists and that you may write to')


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def size(value: float, unit: str, digits: int = 4) -> tuple[str, str]:
    """Return a size in SI as people read it: number and unit as text."""
    shown, read = for_people(value, unit)
    return f'{shown:.{digits}g}', read


def table(header: Sequence[str], rows: Sequence[Sequence[object]], *, digits: int = 3) -> str:
    """
    Return a table for a terminal.

    Parameters
    ----------
    header : sequence of str, length n
        Titles of the columns, unit included.
    rows : sequence of sequences, each of length n
        Text, or numbers, which are shown with ``digits`` significant digits; None and NaN show
        as a dash.
    digits : int
        Significant digits of floats.

    """
    cells = [[_cell(value, digits) for value in row] for row in rows]
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


def _cell(value: object, digits: int) -> str:
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
        return f'{number:.{digits - 1}e}'
    magnitude = math.floor(math.log10(abs(number))) if number else 0
    return f'{number:.{max(digits - 1 - magnitude, 0)}f}'


def _line(cells: Sequence[str], widths: Sequence[int], numeric: Sequence[bool]) -> str:
    return '  '.join(text.rjust(width) if right else text.ljust(width)
                     for text, width, right in zip(cells, widths, numeric)).rstrip()
