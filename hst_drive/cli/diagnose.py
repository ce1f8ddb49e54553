# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``diagnose``: which physical effect the model lacks.

The logs are one campaign of one drive. The unit is calibrated within its tolerances, every
effect of the catalogue is fitted, and all are judged on data that was not used for fitting.
With --since it says what has changed since older logs of the same machine: by how much, and what
the older ones never visited.
"""
from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from hst_drive.cli.common import (
    add_day_to_day_argument, add_holdout_argument, add_log_arguments, day_to_day_of, read_logs,
    rig_file_of, rig_of)
from hst_drive.cli.output import add_json_argument, MISSING, say, size, table, write_json

if TYPE_CHECKING:
    from hst_drive.diagnose.result import Diagnosis, Unknown

HELP = 'say which physical effect the model lacks, how large it is and how sure that is'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_log_arguments(parser)
    add_holdout_argument(parser)
    parser.add_argument('--since', metavar='OLD', nargs='+', default=[],
                        help='say what has changed since these logs of the same machine, which '
                             'must be healthy (as commission and --rig UNIT.yaml, in one step)')
    add_day_to_day_argument(parser)
    parser.add_argument('--plot', metavar='FILE.png',
                        help='draw how the error falls with each effect (.png, .pdf or .svg)')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Diagnose and print."""
    from hst_drive.diagnose.commission import commission
    from hst_drive.diagnose.decide import diagnose
    from hst_drive.diagnose.document import as_json
    from hst_drive.rig import parse_rig
    from hst_drive.rig.yaml_file import read_yaml

    if args.plot:
        from hst_drive.cli.compare import check_plot
        from hst_drive.report.ladder_figure import ladder_figure, require_matplotlib

        check_plot(args.plot)
        require_matplotlib()
    day_to_day = day_to_day_of(args)
    rig = rig_of(args)
    runs = read_logs([*args.logs, *args.holdout, *args.since], args.channels)
    for entry in runs:
        for note in entry.notes:
            say(f'{entry.name}: {note}')
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


def text(result: Diagnosis, short: bool = False) -> str:
    """Return the diagnosis for a terminal; the short form stops after what was found."""
    lines = [result.sentence.strip(), '']
    if result.effects:
        lines += [_effects(result), '']
    lines += ['error over the noise floor, held-out data (training data in brackets):',
              _ladder(result)]
    if result.unknown and result.unknown.expression:
        unknown = result.unknown
        lines += ['', f'the unknown enters at: {unknown.enters.replace("_", " ")}, seen in '
                  f'{unknown.signal}', *_described(unknown)]
    if short:
        return '\n'.join(lines)
    if result.rivals:
        lines += ['', 'the next best, alone, and why they are not it:',
                  *(f'  {name}: {reason}' for name, reason in result.rivals.items())]
    if result.next_test:
        lines += ['', f'to tell {", ".join(result.next_test.separates)} apart: '
                  f'{result.next_test.what}']
    moved = [entry for entry in result.calibration if abs(entry.sigmas) >= 0.5]
    if moved:
        against = 'what it was when commissioned' if result.since else 'its datasheet'
        lines += ['', f'this unit against {against} (what moved by half a tolerance or more):',
                  _calibration(moved)]
    if result.smallest and result.verdict in ('none', 'missing_effect', 'ambiguous'):
        lines += ['', 'the smallest size of each other effect that these logs would have shown:',
                  _smallest(result)]
    if result.not_observable:
        lines += ['', 'not observable in these logs:',
                  *(f'  {name}: {reason}' for name, reason in result.not_observable.items())]
    return '\n'.join(lines)


def _effects(result: Diagnosis) -> str:
    from hst_drive.diagnose.result import not_known
    from hst_drive.effects import catalogue

    rows = []
    for entry in result.effects:
        parameters = catalogue()[entry.id].parameters
        for place, parameter in enumerate(parameters):
            value = entry.parameters[parameter.name]
            (middle, unit), (low, _), (high, _) = (size(each, value.unit) for each in value[:3])
            rows.append([entry.id if place == 0 else '', parameter.name, middle,
                         not_known(value.low, value.high, parameter) or f'{low} to {high}', unit,
                         f'{100 * entry.error_removed:.0f} %' if place == 0 else ''])
    return table(['effect', 'parameter', 'value', '95 % interval', 'unit', 'error removed'], rows)


def _ladder(result: Diagnosis) -> str:
    signals = list(result.ladder[0].holdout)
    rows = [[('+ ' if place > 1 else '') + step.added,
             *(f'{step.holdout[name]:.2f} ({_ratio(step.training.get(name))})'
               for name in signals)] for place, step in enumerate(result.ladder)]
    return table(['model', *signals], rows)


def _ratio(value: float | None) -> str:
    return MISSING if value is None else f'{value:.2f}'


def _calibration(moved) -> str:
    return table(['quantity', 'factor', 'tolerances', ''],
                 [[entry.quantity, f'{entry.factor:.4f}', f'{entry.sigmas:+.1f}',
                   'at its limit' if entry.at_limit else ''] for entry in moved])


def _smallest(result: Diagnosis) -> str:
    from hst_drive.effects import catalogue

    rows = []
    for name, smallest in sorted(result.smallest.items()):
        parameter = catalogue()[name].parameters[0]
        rows.append([name, parameter.name, *size(smallest, parameter.unit, 3)])
    return table(['effect', 'parameter', 'size', 'unit'], rows)


def _described(unknown: Unknown) -> list[str]:
    """Say on what the unknown depends and what formula holds, as far as that is known."""
    on = [f'depends on: {", ".join(unknown.depends_on)}'] if unknown.depends_on else []
    if not unknown.terms and not unknown.formula:
        return [*on, f'what it is: {unknown.expression}']
    return [*on, f'formula: {unknown.expression}',
            *([f'it explains {100 * unknown.explained:.0f} % of what is left there']
              if unknown.terms else []), _worth(unknown)]


def _worth(unknown: Unknown) -> str:
    """Say what the formula does to the error when it becomes part of the model."""
    formula = unknown.formula
    if formula is None:
        return 'in the model no formula of these variables lowers the error: nothing to adopt'
    falls = ', '.join(f'{name} {formula.before[name]:.2f} to {formula.after[name]:.2f}'
                      for name in formula.before
                      if abs(formula.before[name] - formula.after[name]) >= 0.05)
    return (f"in the model ('adopt --formula', {formula.id}) it brings held-out error over the "
            f'noise down: {falls}')
