# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Results to files, whole or not at all, and back."""
from __future__ import annotations

from collections.abc import Mapping
import errno
import json
import os
from pathlib import Path
import sys
import tempfile

from hst_drive.errors import InputError
from hst_drive.plain import plain


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


def read_json(path: str) -> dict:
    """Read a JSON file; one line says what is wrong with it."""
    try:
        return json.loads(Path(path).read_text(encoding='utf-8')) or {}
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror}); check the path') from None
    except ValueError as error:
        raise InputError(f'{path}: is not JSON ({error}); expected what '
                         "'hst-drive diagnose --json' wrote") from None


def write_yaml(data: Mapping, target: str | os.PathLike) -> None:
    """Write a mapping as YAML, in its order and with short lists on one line, whole or not."""
    import yaml

    class Plain(yaml.SafeDumper):
        """People read and edit it: what stands twice is written twice, not as '*id001'."""

        def ignore_aliases(self, data: object) -> bool:
            return True

    write_text(yaml.dump(data, Dumper=Plain, sort_keys=False, default_flow_style=None, width=99,
                         allow_unicode=True), target)


def check_target(target: str | os.PathLike) -> None:
    """Raise InputError if a file cannot be written."""
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


def write_text(text: str, target: str | os.PathLike) -> None:
    """Write a text file, whole or not at all; '-' is standard output."""
    if os.fspath(target) == '-':
        sys.stdout.write(text)
        return
    path = Path(target)
    scratch = None
    try:
        if path.exists() and not path.is_file():
            # /dev/stdout, a named pipe: nothing to replace. A folder is refused by open().
            path.write_text(text, encoding='utf-8')
            return
        handle, scratch = tempfile.mkstemp(dir=path.parent, prefix=f'.{path.name}.')
        with open(handle, 'w', encoding='utf-8') as stream:
            # mkstemp makes files that nobody else may read.
            os.chmod(scratch, 0o666 & ~_umask())
            stream.write(text)
        os.replace(scratch, path)
    except BrokenPipeError:
        raise
    except OSError as problem:
        raise _unwritable(path, problem) from problem
    finally:
        if scratch is not None and os.path.exists(scratch):
            os.unlink(scratch)


def _unwritable(path: Path, problem: OSError) -> InputError:
    return InputError(f'{path}: cannot be written ({problem.strerror}); name a file in a folder '
                      'that exists and that you may write to')


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
