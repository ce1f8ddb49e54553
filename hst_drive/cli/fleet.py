# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``fleet``: the same diagnosis for many campaigns.

A campaign is a folder with logs; the folder above it is the machine. rig.yaml and channels.yaml
count beside the logs or in a folder above; logs with 'holdout' in their names are judged on; the
date is that in the folder's or a log's name, or when a bag began. What is done is kept in
--results, one JSON file per campaign: the same command goes on where it was interrupted. A
campaign that cannot be diagnosed is a row with its reason.
"""
from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
import sys
import time
from typing import TYPE_CHECKING

from hst_drive.cli.output import add_json_argument, check_target, say, table, write_json, \
    write_text
from hst_drive.errors import InputError
from hst_drive.units import for_people

if TYPE_CHECKING:
    from hst_drive.fleet.run import Progress
    from hst_drive.fleet.summary import Summary

HELP = 'diagnose many campaigns on all cores or a cluster: who lacks what, and what grows'
_SHOWN = 40     # rows on the terminal


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('place', metavar='FOLDER|LIST',
                        help='folder with campaigns in it, or a text file with a folder per line')
    parser.add_argument('--results', metavar='FOLDER', default='fleet_results',
                        help='where the answers are kept (default: fleet_results)')
    parser.add_argument('-o', '--output', metavar='PAGE.html', help='also write a page')
    parser.add_argument('--workers', metavar='N', type=int, default=0,
                        help='processes on this machine (default: one per core)')
    parser.add_argument('--scheduler', metavar='tcp://HOST:PORT', default='',
                        help='use the workers of this dask scheduler, which see the same folders')
    parser.add_argument('--again', action='store_true', help='also repeat those that failed')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Diagnose all campaigns and print the table."""
    from hst_drive.diagnose.document import as_json
    from hst_drive.fleet.campaigns import find_campaigns
    from hst_drive.fleet.run import run_fleet
    from hst_drive.fleet.store import Store
    from hst_drive.fleet.summary import summarise
    from hst_drive.fleet.task import diagnose_campaign

    if args.workers < 0:
        raise InputError(f'--workers {args.workers}: expected a positive number, or 0 for all')
    if args.output:
        from hst_drive.fleet.page import fleet_page

        check_target(args.output)
    campaigns = find_campaigns(args.place)
    began = time.monotonic()
    try:
        rows = run_fleet(campaigns, Store(Path(args.results)),
                         partial(diagnose_campaign, describe=as_json),
                         workers=args.workers, scheduler=args.scheduler, again=args.again,
                         progress=_progress(began))
    except KeyboardInterrupt:
        say(f'what is done is kept in {args.results}; the same command goes on from there')
        raise
    summary = summarise(rows)
    if args.json:
        write_json({'schema': 'hst_drive/fleet/1', 'rows': rows, **_json(summary)}, args.json)
    if args.output:
        write_text(fleet_page(f'Fleet: {args.place}', sentence(rows, summary), rows, summary,
                              [f'{len(rows)} campaigns', f'{len(summary.machines)} machines']),
                   args.output)
        say(f'wrote {args.output}')
    if args.json != '-':
        print(text(rows, summary))
    return 0


def _progress(began: float):
    tty = sys.stderr.isatty()

    def tell(progress: Progress) -> None:
        row = progress.row
        if row is None:
            if progress.done:
                say(f'{progress.done} of {progress.total} campaigns are done already')
            return
        if row['status'] == 'failed':
            say(f'{row["campaign"]}: failed: {row["reason"]}')
        if tty or progress.done == progress.total or progress.done % 50 == 0:
            line = f'{progress.done} of {progress.total}, {time.monotonic() - began:.0f} s'
            print(f'\r{line}' if tty and progress.done < progress.total else line,
                  end='' if tty and progress.done < progress.total else '\n', file=sys.stderr,
                  flush=True)

    return tell


def sentence(rows: list[dict], summary: Summary) -> str:
    """Say the most important of it."""
    lacking = [machine for machine in summary.machines if machine.effects]
    grow = [trend for trend in summary.trends if trend.direction == 'grows']
    parts = [f'{len(lacking)} of {len(summary.machines)} machines lack an effect']
    if grow:
        parts.append('it grows on ' + ', '.join(f'{trend.machine} ({trend.effect})'
                                                for trend in grow[:5])
                     + (f' and {len(grow) - 5} more' if len(grow) > 5 else ''))
    if summary.outliers:
        parts.append(f'{len(summary.outliers)} campaigns are unlike the others')
    if summary.failures:
        parts.append(f'{len(summary.failures)} of {len(rows)} campaigns failed')
    return '; '.join(parts) + '.'


def text(rows: list[dict], summary: Summary) -> str:
    """Return the fleet for a terminal."""
    lines = [sentence(rows, summary), '', table(
        ['machine', 'campaigns', 'failed', 'verdicts', 'lacks'],
        [[machine.name, machine.campaigns, machine.failed, _counts(machine.verdicts),
          _counts(machine.effects)] for machine in summary.machines[:_SHOWN]])]
    if len(summary.machines) > _SHOWN:
        lines.append(f'and {len(summary.machines) - _SHOWN} machines more: see --json or -o')
    moving = [trend for trend in summary.trends if trend.direction != 'steady']
    if moving:
        lines += ['', 'over time:', table(
            ['machine', 'effect', '', 'a year', '95 % interval', 'unit', 'campaigns'],
            [[trend.machine, f'{trend.effect}.{trend.parameter}', trend.direction,
              *_interval(trend), len(trend.points)] for trend in moving[:_SHOWN]])]
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


def _interval(trend) -> tuple[float, str, str]:
    (slope, unit), (low, _), (high, _) = (for_people(value, trend.unit)
                                          for value in (trend.slope, trend.low, trend.high))
    return slope, f'{low:.3g} to {high:.3g}', unit


def _json(summary: Summary) -> dict:
    return {
        'machines': [machine._asdict() for machine in summary.machines],
        'trends': [{**trend._asdict(), 'points': [point._asdict() for point in trend.points]}
                   for trend in summary.trends],
        'outliers': [{'median': entry.median, 'z': entry.z, **entry.point._asdict()}
                     for entry in summary.outliers],
        'failures': [{'campaign': name, 'reason': reason} for name, reason in summary.failures]}
