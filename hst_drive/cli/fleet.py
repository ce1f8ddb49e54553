# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``fleet``: many machines over their lives.

A campaign is a folder with logs; the folder above it is the machine. rig.yaml and channels.yaml
count beside the logs or in a folder above; logs with 'holdout' in their names are judged on; the
date is that in the folder's or a log's name, or when a bag began. The first --healthy days of a
machine tell what it is like (its own file is kept in RESULTS/units), unless its rig.yaml is one
of commission already. What is done is kept in --results: the same command goes on where it was
interrupted. A campaign that cannot be diagnosed is a row with its reason.
"""
from __future__ import annotations

import argparse
from pathlib import Path
import sys
import time
from typing import TYPE_CHECKING

from hst_drive.cli.output import (
    add_json_argument, check_target, refuse_inputs, say, table, write_json, write_text)
from hst_drive.errors import InputError
from hst_drive.units import for_people

if TYPE_CHECKING:
    from hst_drive.fleet.limits import Limits
    from hst_drive.fleet.run import Progress
    from hst_drive.fleet.summary import Summary

HELP = 'follow many machines: what each lacks, what grows, since when and until when'
_SHOWN = 40     # rows on the terminal


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('place', metavar='FOLDER|LIST',
                        help='folder with campaigns in it, or a text file with a folder per line')
    parser.add_argument('--results', metavar='FOLDER', default='fleet_results',
                        help='where the answers are kept (default: fleet_results)')
    parser.add_argument('-o', '--output', metavar='PAGE.html', help='also write a page')
    parser.add_argument('--limit', metavar='EFFECT=SIZE', action='append', default=[],
                        help="tell when it is reached, as 'motor_leakage=0.02 L/min/bar'; "
                             'repeatable (default: no limit)')
    parser.add_argument('--limits', metavar='FILE.yaml',
                        help="the same in a file, a line each: 'motor_leakage: 0.02 L/min/bar'")
    parser.add_argument('--healthy', metavar='DAYS', type=int, default=2,
                        help='first days of a machine that are taken as healthy (default: 2); 0: '
                             'judge all by the make')
    parser.add_argument('--workers', metavar='N', type=int, default=0,
                        help='processes on this machine (default: one per core)')
    parser.add_argument('--scheduler', metavar='tcp://HOST:PORT', default='',
                        help='use the workers of this dask scheduler, which see the same folders')
    parser.add_argument('--again', action='store_true', help='also repeat those that failed')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Follow all machines and print the table."""
    from hst_drive.fleet.campaigns import find_campaigns
    from hst_drive.fleet.document import as_json
    from hst_drive.fleet.life import live
    from hst_drive.fleet.store import Store
    from hst_drive.fleet.summary import summarise

    for name in ('workers', 'healthy'):
        if getattr(args, name) < 0:
            raise InputError(f'--{name} {getattr(args, name)}: expected a positive number, or 0')
    limits = _limits(args)
    if args.output:
        from hst_drive.fleet.page import fleet_page

        check_target(args.output)
    campaigns = find_campaigns(args.place)
    refuse_inputs([text for text in (args.output, args.json) if text],
                  [path for campaign in campaigns for path in campaign.files])
    began = time.monotonic()
    try:
        lives = live(campaigns, Store(Path(args.results)), healthy=args.healthy,
                     limited=[name for name, _ in limits], workers=args.workers,
                     scheduler=args.scheduler, again=args.again,
                     progress=_progress(began))
    except KeyboardInterrupt:
        say(f'what is done is kept in {args.results}; the same command goes on from there')
        raise
    summary = summarise(lives, limits)
    if args.json:
        write_json(as_json(lives, summary), args.json)
    if args.output:
        write_text(fleet_page(Path(args.place).resolve().stem, lives.rows, summary),
                   args.output)
        say(f'wrote {args.output}')
    if args.json != '-':
        print(text(summary))
    return 0


def _limits(args: argparse.Namespace) -> Limits:
    from hst_drive.fleet.limits import once, read_limit, read_limits
    from hst_drive.rig.yaml_file import read_yaml

    limits = read_limits(read_yaml(args.limits), args.limits) if args.limits else {}
    return {**limits, **once((f"--limit '{text}'", read_limit(text)) for text in args.limit)}


def _progress(began: float):
    tty = sys.stderr.isatty()

    def tell(progress: Progress) -> None:
        row = progress.row
        if row is None:
            if progress.done:
                say(f'{progress.done} of {progress.total} {progress.what} are done already')
            return
        if row['status'] == 'failed':
            say(f'{row["campaign"]}: failed: {row["reason"]}')
        if tty or progress.done == progress.total or progress.done % max(
                progress.total // 10, 1) == 0:
            line = (f'{progress.done} of {progress.total} {progress.what}, '
                    f'{time.monotonic() - began:.0f} s')
            print(f'\r{line}' if tty and progress.done < progress.total else line,
                  end='' if tty and progress.done < progress.total else '\n', file=sys.stderr,
                  flush=True)

    return tell


def text(summary: Summary) -> str:
    """Return the fleet for a terminal."""
    from hst_drive.fleet.words import of_machine, sentence

    lines = [sentence(summary), '', table(
        ['machine', 'state', 'campaigns', 'failed', 'last judged', 'found (campaigns)'],
        [[machine.name, machine.state, machine.campaigns, machine.failed, machine.last,
          _counts(machine.effects)] for machine in summary.machines[:_SHOWN]])]
    for machine in summary.machines[:_SHOWN]:
        if machine.followed:
            lines += ['', f'{machine.name}:', *(f'  {told}' for told in of_machine(machine))]
    if len(summary.machines) > _SHOWN:
        lines.append(f'and {len(summary.machines) - _SHOWN} machines more: see --json or -o')
    if summary.outliers:
        lines += ['', 'unlike the others:', table(
            ['campaign', 'effect', 'size', 'median', 'unit', 'robust z'],
            [[entry.point.campaign, entry.point.effect,
              *(for_people(value, entry.point.unit)[0] for value in (
                  entry.point.value, entry.median)),
              for_people(0.0, entry.point.unit)[1], f'{entry.z:+.1f}']
             for entry in summary.outliers[:_SHOWN]])]
    if summary.failures:
        lines += ['', 'without an answer:',
                  *(f'  {name}: {reason}' for name, reason in summary.failures[:_SHOWN])]
        if len(summary.failures) > _SHOWN:
            lines.append(f'  and {len(summary.failures) - _SHOWN} more')
    return '\n'.join(lines)


def _counts(found: dict[str, int]) -> str:
    return ', '.join(f'{name} {count}' for name, count in sorted(
        found.items(), key=lambda item: -item[1]))
