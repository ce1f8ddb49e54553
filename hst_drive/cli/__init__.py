# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The command line: one verb per file of this folder.

A file with a constant ``HELP`` (one line, a plain string) is a verb and has two functions:
``add_arguments(parser)`` and ``run(args) -> int``. Only the file of the asked verb is imported.
``VERB --help`` shows HELP and the file's docstring without its first line.

Exit codes: 0 done, 2 wrong input (one line), 1 anything else, 130 on Ctrl-C.
"""
from __future__ import annotations

import argparse
import ast
from collections.abc import Sequence
from difflib import get_close_matches
import errno
from importlib import import_module
import inspect
import os
from pathlib import Path
import sys
import traceback

import hst_drive
from hst_drive.cli.output import check_target, refuse_inputs
from hst_drive.errors import InputError

PROG = 'hst-drive'
# The matrices of a fit are small and both cores have work: threads of the linear algebra on top
# cost more than half as much again. Set before NumPy is loaded; the user's own setting stands.
ONE_THREAD = ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS')
_OUTPUTS = ('json', 'output', 'plot')     # options that name a file to write
# What the place to write to cannot take.
_NO_ROOM = {errno.ENAMETOOLONG, errno.ENOSPC, errno.EDQUOT, errno.EROFS}
_OK, _FAILED, _WRONG_INPUT, _INTERRUPTED, _BROKEN_PIPE = 0, 1, 2, 130, 141


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line."""

    def error(self, message: str):
        raise InputError(f'{message} (see {self.prog} --help)')


def verbs() -> dict[str, str]:
    """Return the one-line help of each verb, by name, without importing any of them."""
    found = {}
    for path in sorted(Path(__file__).parent.glob('*.py')):
        help_line = _help_line(path)
        if help_line is not None:
            found[path.stem.replace('_', '-')] = help_line
    return found


def _help_line(path: Path) -> str | None:
    for node in ast.parse(path.read_text(encoding='utf-8')).body:
        if isinstance(node, (ast.Assign, ast.AnnAssign)):
            target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
            if isinstance(target, ast.Name) and target.id == 'HELP':
                return ast.literal_eval(node.value)
    return None


def overview() -> str:
    """Return the list of the verbs as text."""
    found = verbs()
    width = max(map(len, found), default=0)
    return '\n'.join(['verbs:', *(f'  {name:{width}}  {text}' for name, text in found.items())])


def main(argv: Sequence[str] | None = None, *, prog: str = PROG) -> int:
    """
    Run a command line.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments after the program's name; default those of the process.
    prog : str
        How the user called it, for messages.

    Returns
    -------
    int
        Exit code.

    """
    for name in ONE_THREAD:
        os.environ.setdefault(name, '1')
    argv = list(sys.argv[1:] if argv is None else argv)
    show_traceback = '--traceback' in argv or os.environ.get('HST_DRIVE_TRACEBACK', '') == '1'
    try:
        code = _run(argv, prog)
        sys.stdout.flush()
        return code
    except SystemExit as end:
        # argparse leaves this way after --help and --version.
        return end.code or _OK
    except KeyboardInterrupt:
        return _fail('interrupted', _INTERRUPTED)
    except BrokenPipeError:
        # The reader has gone (`| head`): Python would complain again when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _BROKEN_PIPE
    except InputError as problem:
        if show_traceback:
            traceback.print_exc()
        return _fail(problem, _WRONG_INPUT)
    except Exception as problem:
        if show_traceback:
            traceback.print_exc()
        if isinstance(problem, OSError) and problem.errno in _NO_ROOM:
            return _fail(f'{problem.filename or "output"}: {problem.strerror}', _WRONG_INPUT)
        if show_traceback:
            return _FAILED
        text = ' '.join(str(problem).split())
        return _fail(f'{type(problem).__name__}{": " if text else ""}{text} (not your input: see '
                     'where it happened with --traceback or HST_DRIVE_TRACEBACK=1)', _FAILED)


def _fail(problem: object, code: int) -> int:
    print(f'{PROG}: {problem}', file=sys.stderr)
    return code


def _run(argv: list[str], prog: str) -> int:
    top = _Parser(
        prog=prog, usage=f'{prog} VERB [ARGUMENTS]', description=hst_drive.__doc__,
        epilog=f'Each verb explains itself: {prog} VERB --help',
        formatter_class=argparse.RawDescriptionHelpFormatter)
    top.add_argument('--version', action='version', version=f'{prog} {hst_drive.__version__}')
    _add_common(top)
    top.add_argument('verb', nargs='?', help=argparse.SUPPRESS)
    top.add_argument('arguments', nargs=argparse.REMAINDER, help=argparse.SUPPRESS)
    if not argv or argv[0] in ('-h', '--help'):
        top.epilog = f'{overview()}\n\n{top.epilog}'
    options = top.parse_args(argv)
    if options.verb is None:
        top.print_help()
        return _OK
    return _run_verb(options.verb, options.arguments, prog)


def _add_common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('--traceback', action='store_true',
                        help='show where in the program an error happened')


def _run_verb(name: str, arguments: list[str], prog: str) -> int:
    found = verbs()
    if name not in found:
        close = get_close_matches(name, found, n=1)
        raise InputError(f"unknown verb '{name}'; "
                         + (f"did you mean '{close[0]}'?" if close else 'the verbs are '
                            + ', '.join(found)))
    module = import_module(f'{__name__}.{name.replace("-", "_")}')
    details = inspect.cleandoc(module.__doc__ or '').partition('\n')[2]
    parser = _Parser(prog=f'{prog} {name}', description=f'{module.HELP}\n{details}'.strip(),
                     formatter_class=argparse.RawDescriptionHelpFormatter)
    module.add_arguments(parser)
    _add_common(parser)
    options = parser.parse_args(arguments)
    if getattr(options, 'json', None):
        check_target(options.json)
    _refuse_to_write_what_is_read(vars(options))
    return module.run(options)


def _refuse_to_write_what_is_read(options: dict[str, object]) -> None:
    """Raise InputError if an output is an input, or two are one: nothing is to be lost."""
    texts = {name: [text for text in (value if isinstance(value, list) else [value])
                    if isinstance(text, str)] for name, value in options.items()}
    read = [text for name, found in texts.items() if name not in _OUTPUTS
            for text in found if os.path.isfile(text)]
    refuse_inputs([text for name in _OUTPUTS for text in texts.get(name, ())], read)
