# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``workbench``: the page, live in the browser.

Switch effects on and off, move their sizes, fit them, ask what is missing, and save the result as
a rig file in the folder where you started it. Without LOG a sample log and a guide show how.
Only this machine can reach the page; Ctrl-C ends it.
"""
from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path

from hst_drive.cli.common import add_holdout_argument, add_log_arguments, read_logs
from hst_drive.cli.output import say, write_yaml
from hst_drive.cli.report import add_model_arguments, model_file
from hst_drive.errors import InputError

HELP = 'live page in the browser: switch effects, fit, see the error fall'
_PORT = 8765


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_log_arguments(parser, default='a sample log')
    add_holdout_argument(parser)
    add_model_arguments(parser)
    parser.add_argument('--port', type=int, metavar='N',
                        help=f'port on 127.0.0.1 (default: {_PORT}, or a free one)')
    parser.add_argument('--open', action='store_true', help='open the page in the browser')


def run(args: argparse.Namespace) -> int:
    """Read the logs and serve the page until Ctrl-C."""
    from hst_drive.rig import default_rig, default_rig_file
    from hst_drive.rig.yaml_file import read_yaml
    from hst_drive.workbench.answers import Answers, Setting
    from hst_drive.workbench.bench import Workbench
    from hst_drive.workbench.sample import sample_logs
    from hst_drive.workbench.server import Server
    from hst_drive.workbench.state import Base

    rig_file = args.rig or str(default_rig_file())
    base = Base(read_yaml(rig_file), rig_file)
    start = base.model_of(model_file(args))
    if args.holdout and not args.logs:
        raise InputError('--holdout: needs logs to fit on; name them before it')
    if find_spec('numba') is None:
        say('numba is not installed: a switch takes seconds to minutes; pip install numba')
    if args.logs:
        runs = read_logs([*args.logs, *args.holdout], args.channels)
        training, held = runs[:len(args.logs)], runs[len(args.logs):]
    else:
        sample, other = sample_logs(default_rig())
        training, held = [sample], [other]
    say('reading and comparing')
    setting = Setting(
        tuple(map(_whole, args.logs)), tuple(map(_whole, args.holdout)),
        _whole(args.rig) if args.rig else None, _whole(args.channels) if args.channels else None,
        Path.cwd(), write_yaml, not args.logs, start)
    bench = Workbench(base, training, held)
    bench.errors(start)
    server = _server(Answers(bench, setting), args.port, Server)
    print(f'the workbench is at {server.address} (Ctrl-C ends it)', flush=True)
    if args.open:
        import webbrowser

        webbrowser.open(server.address)
    try:
        server.serve_forever(poll_interval=0.2)
    except KeyboardInterrupt:
        say('the workbench has ended')
    finally:
        server.server_close()
    return 0


def _whole(path: str) -> str:
    """Return a path that holds in every folder."""
    return str(Path(path).resolve())


def _server(answers, port: int | None, kind):
    if port is not None and not 0 <= port <= 65535:
        raise InputError(f'--port {port}: expected 0 to 65535')
    try:
        return kind(answers, _PORT if port is None else port)
    except OSError as problem:
        if port is not None:
            raise InputError(f'--port {port}: cannot be used ({problem.strerror}); leave it out '
                             'to take a free one') from None
        return kind(answers, 0)
