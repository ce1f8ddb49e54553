# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the verbs print and write: results to standard output, the rest to standard error."""
from __future__ import annotations

import argparse
import os
from pathlib import Path
import sys
from typing import Iterable, Sequence

from hst_drive.errors import InputError
from hst_drive.report.files import check_target, write_json, write_text, write_yaml
from hst_drive.report.terminal import MISSING, size, table

__all__ = ['MISSING', 'add_force_argument', 'add_json_argument', 'check_target',
           'refuse_inputs', 'refuse_to_replace', 'say', 'size', 'table', 'write_json',
           'write_text', 'write_yaml']


def say(message: str) -> None:
    """Tell progress or a warning on standard error."""
    print(message, file=sys.stderr, flush=True)


def add_json_argument(parser: argparse.ArgumentParser) -> None:
    """Add ``--json FILE``."""
    parser.add_argument('--json', metavar='FILE',
                        help='also write the result as JSON; - for standard output')


def add_force_argument(parser: argparse.ArgumentParser, name: str) -> None:
    """Add ``--force`` for the file that the help calls ``name``."""
    parser.add_argument('--force', action='store_true', help=f'replace {name} if it exists')


def refuse_inputs(outputs: Sequence[str], read: Iterable[str]) -> None:
    """Raise InputError if an output is a file that is read, or two are the same."""
    inputs = {Path(text).resolve() for text in read}
    written: set[Path] = set()
    for text in outputs:
        place = Path(text).resolve()
        if place in inputs:
            raise InputError(f'{text}: would be read and written over; choose another name for '
                             'the output')
        if place in written and text != '-':
            raise InputError(f'{text}: is the name of two outputs; give each its own')
        written.add(place)


def refuse_to_replace(target: str | os.PathLike, force: bool) -> None:
    """Raise InputError if a file is there, or none can be written: better told before the work."""
    if Path(target).is_file() and not force:
        raise InputError(f'{target}: exists already; choose another name, or replace it with '
                         '--force')
    check_target(target)
