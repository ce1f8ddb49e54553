# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A verb called in the tests' own process, and what it prints."""
from functools import partial

from hst_drive import cli


def command(verb, capsys, *arguments):
    """Return exit code, standard output and standard error."""
    code = cli.main([verb, *map(str, arguments)])
    return code, *capsys.readouterr()


def refused(verb, capsys, *arguments):
    """Return the one line with which wrong input is refused."""
    code, out, err = command(verb, capsys, *arguments)
    assert code == 2 and not out
    assert err.count('\n') == 1 and err.startswith('hst-drive: ') and 'Traceback' not in err
    return err


def calls_of(verb):
    """Return ``command`` and ``refused`` for one verb."""
    return partial(command, verb), partial(refused, verb)
