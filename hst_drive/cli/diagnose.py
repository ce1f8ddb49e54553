# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``diagnose``: which physical effect the model lacks.

The logs are one campaign of one drive. The unit is calibrated within its tolerances, every
effect of the catalogue is fitted, and all are weighed; held-out errors are told.
With --since it says what has changed since older logs of the same machine: by how much, and what
the older ones never visited.
"""
from __future__ import annotations

import argparse
import sys
from typing import Sequence, TYPE_CHECKING

from hst_drive.cli.common import (
    add_holdout_argument, add_log_arguments, add_since_argument, day_to_day_of, read_logs,
    rig_file_of, rig_of)
from hst_drive.cli.output import add_json_argument, say, write_json

if TYPE_CHECKING:
    from hst_drive.measure.run import Run

HELP = 'say which physical effect the model lacks, how large it is and how sure that is'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_log_arguments(parser)
    add_holdout_argument(parser)
    add_since_argument(parser)
    parser.add_argument('--plot', metavar='FILE.png',
                        help='draw how the error falls with each effect (.png, .pdf or .svg)')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Diagnose and print."""
    from hst_drive.diagnose.commission import commission
    from hst_drive.diagnose.decide import diagnose
    from hst_drive.diagnose.result import as_json
    from hst_drive.report.diagnosis import text
    from hst_drive.rig import parse_rig
    from hst_drive.rig.yaml_file import read_yaml

    if args.plot:
        from hst_drive.cli.compare import check_plot
        from hst_drive.report.drawing import require_matplotlib
        from hst_drive.report.ladder_figure import ladder_figure

        check_plot(args.plot)
        require_matplotlib()
    day_to_day = day_to_day_of(args)
    rig = rig_of(args)
    runs = read_logs([*args.logs, *args.holdout, *args.since], args.channels)
    tell_notes(runs, args.rig)
    count = len(args.logs) + len(args.holdout)
    if args.since:
        source = rig_file_of(args)
        rig = parse_rig(commission(read_yaml(source), source, runs[count:], day_to_day,
                                   progress=progress_line()).rig, source)
    result = diagnose(rig, runs[:len(args.logs)], runs[len(args.logs):count],
                      progress=progress_line())
    if args.json:
        write_json(as_json(result), args.json)
    if args.plot:
        ladder_figure(result.ladder, args.plot)
        say(f'wrote {args.plot}')
    if args.json != '-':
        print(text(result))
    return 0


def tell_notes(runs: Sequence[Run], rig: str | None) -> None:
    """Say what was repaired or left out of the logs, and of which machine parts are taken."""
    from hst_drive.measure.balances import is_part
    from hst_drive.rig import default_rig

    shipped = None if rig else default_rig()
    if shipped and any(is_part(entry, shipped) for entry in runs):
        say(f"no --rig: taken for logs of the shipped '{shipped.name}'; give --rig RIG.yaml for "
            'another machine')
    for entry in runs:
        for note in entry.notes:
            say(f'{entry.name}: {note}')


def progress_line():
    """Return a function that shows what is going on: a line that renews itself."""
    if sys.stderr.isatty():
        return lambda what: print(f'\r{what:60}\r', end='', file=sys.stderr, flush=True)
    told: set[str] = set()

    def tell(what: str) -> None:
        head = what.split(':')[0]
        if head not in told:
            told.add(head)
            say(head)

    return tell
