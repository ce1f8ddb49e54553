# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``compare``: recordings beside the model.

Replays the measured inputs through the model and says, signal by signal, how far it is off and
where. 'x floor' is the error over what a perfect model would still show: 1 is perfect.
"""
from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from hst_drive.cli.common import add_log_arguments, read_logs, rig_of
from hst_drive.cli.output import add_json_argument, check_target, say, write_json
from hst_drive.cli.sections import (
    asks_for_sections, in_sections, LONG_BAG, LONG_FILE, MINUTES)
from hst_drive.errors import InputError

if TYPE_CHECKING:
    from hst_drive.measure.compare import Comparison

HELP = 'replay recordings through the model: how well does it fit, and where not'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_log_arguments(parser)
    parser.add_argument('--closed-loop', action='store_true',
                        help='let the PI controller command the pump, and compare the command too')
    parser.add_argument('--all', action='store_true',
                        help='judge every second, also start from rest and cavitation, which '
                        "'diagnose' leaves out, too (but for starts of a commissioned machine)")
    parser.add_argument('--plot', metavar='FILE.png',
                        help='draw measured, model and error (several logs: one file each)')
    parser.add_argument('--sections', metavar='MIN', type=float,
                        help='cut each log in sections of so many minutes, so that it need not '
                        f'fit into the memory (default: {MINUTES:g} for CSV beyond '
                        f'{LONG_FILE / 1e6:.0f} MB, bags beyond {LONG_BAG / 1e6:.0f} MB)')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Compare and print."""
    from hst_drive.measure.compare import compare, model_of
    from hst_drive.report.comparison import as_json, remarks, text

    if args.plot:
        check_plot(args.plot)
    rig = rig_of(args)
    result = in_sections(rig, args) if asks_for_sections(args) else None
    runs = ([log.run for log in result.logs] if result
            else read_logs(args.logs, args.channels))
    for line in remarks(rig, runs):
        say(line)
    if result is None:
        result = compare(model_of(rig, runs), runs, closed_loop=args.closed_loop,
                         all_seconds=args.all)
    if args.json:
        write_json(as_json(result, rig.source), args.json)
    if args.plot:
        _plot(result, args.plot)
    # Last, for who reads it may have gone ('| head'). With the JSON there, nothing else may stand.
    if args.json != '-':
        print(text(result))
    return 0


def check_plot(target: str) -> None:
    """Refuse a picture that could not be written: better told before the work than after."""
    if not target.lower().endswith(('.png', '.pdf', '.svg')):
        raise InputError(f'--plot {target}: expected a name that ends in .png, .pdf or .svg')
    check_target(target)


def _plot(result: Comparison, target: str) -> None:
    from pathlib import Path

    from hst_drive.report.figures import comparison_figure

    path = Path(target)
    for log in result.logs:
        safe = ''.join(letter if letter.isalnum() or letter in '-_' else '_'
                       for letter in log.run.name)
        single = path if len(result.logs) == 1 else path.with_name(
            f'{path.stem}_{safe}{path.suffix}')
        comparison_figure(log, single)
        say(f'wrote {single}')
