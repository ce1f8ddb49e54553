# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``report``: a page to look at, in one file that opens without a network.

Measured against model, where it fails, what is missing and how far the error falls with it. The
numbers are those of 'compare' and 'diagnose'; of logs longer than ten minutes in all, 'diagnose'
is left out unless asked for (--diagnose), since it takes minutes. With --since the older logs
stand beside the new ones, both against the machine as it was then.
"""
from __future__ import annotations

import argparse
from pathlib import Path
import shlex
import sys
from typing import TYPE_CHECKING

from hst_drive.cli.common import (
    add_holdout_argument, add_log_arguments, add_since_argument, day_to_day_of, read_json,
    read_logs)
from hst_drive.cli.output import (
    add_json_argument, check_target, say, write_json, write_text)
from hst_drive.errors import InputError

if TYPE_CHECKING:
    from hst_drive.measure.run import Run
    from hst_drive.rig import Rig

HELP = 'write a page to look at: measured against model, where it fails, what is missing'
_LONG = 600.0   # s of logs; a diagnosis takes about a fifth of that


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_log_arguments(parser)
    parser.add_argument('-o', '--output', metavar='PAGE.html', default='report.html',
                        help='page to write (default: report.html)')
    add_holdout_argument(parser)
    add_since_argument(parser)
    add_model_arguments(parser)
    choice = parser.add_mutually_exclusive_group()
    choice.add_argument('--diagnosis', metavar='DIAGNOSIS.json',
                        help="take what 'diagnose --json' wrote for these logs")
    choice.add_argument('--diagnose', action='store_true',
                        help='say what is missing, however long the logs')
    choice.add_argument('--no-diagnosis', action='store_true', help='only compare')
    add_json_argument(parser)


def add_model_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what changes the rig's model: --effect and --factor."""
    parser.add_argument('--effect', metavar='ID.PARAMETER=VALUE', action='append', default=[],
                        help="add an effect to the rig's (repeatable; SI, or VALUE[unit]); "
                             'parameters of it that are not given have their typical values')
    parser.add_argument('--factor', metavar='QUANTITY=FACTOR', action='append', default=[],
                        help='factor of this unit on a quantity, e.g. motor.leakage=1.05')


def model_file(args: argparse.Namespace) -> dict:
    """Return the mapping of the rig file that was asked for, with --effect and --factor."""
    from hst_drive.nodes.settings import parse_effects
    from hst_drive.rig import default_rig_file
    from hst_drive.rig.yaml_file import read_yaml

    content = read_yaml(args.rig or str(default_rig_file()))
    added = parse_effects(args.effect)
    if added:
        content['effects'] = {**(content.get('effects') or {}), **{
            name: _whole_effect(name, values) for name, values in added.items()}}
    for text in args.factor:
        key, _, value = text.partition('=')
        try:
            factor = float(value)
        except ValueError:
            raise InputError(f'--factor {text}: expected QUANTITY=FACTOR, as motor.leakage=1.05'
                             ) from None
        calibration = dict(content.get('calibration') or {})
        calibration[key.strip()] = calibration.get(key.strip(), 1.0) * factor
        content['calibration'] = calibration
    return content


def _whole_effect(name: str, values: dict[str, float]) -> dict[str, float]:
    """Return all parameters of an effect; one that is not given has its typical value."""
    from hst_drive.effects import catalogue

    return {entry.name: values.get(entry.name, entry.typical)
            for entry in catalogue()[name].parameters}


def run(args: argparse.Namespace) -> int:
    """Compare, diagnose, and write the page."""
    from hst_drive.measure.compare import compare, model_of
    from hst_drive.report import comparison as told
    from hst_drive.report.page import page
    from hst_drive.report.provenance import BEFORE, HELD_OUT, provenance, TRAINING
    from hst_drive.report.variants import variants_of
    from hst_drive.rig import default_rig_file, parse_rig

    check_target(args.output)
    day_to_day = day_to_day_of(args)
    if args.since and args.diagnosis:
        raise InputError('--since: goes with a diagnosis of its own; leave --diagnosis out, or '
                         'commission, and give the rig that it was made with: --rig UNIT.yaml')
    content = model_file(args)
    rig_file = args.rig or str(default_rig_file())
    paths = [*args.logs, *args.holdout, *args.since]
    roles = [role for role, given in ((TRAINING, args.logs), (HELD_OUT, args.holdout),
                                      (BEFORE, args.since)) for _ in given]
    runs = read_logs(paths, args.channels)
    present = runs[:len(runs) - len(args.since)]
    if args.since:
        from hst_drive.cli.diagnose import progress_line
        from hst_drive.diagnose.commission import commission

        content = commission(content, rig_file, runs[len(present):], day_to_day,
                             progress=progress_line()).rig
    rig = parse_rig(content, rig_file)
    say('comparing')
    comparison = compare(model_of(rig, runs), runs)
    diagnosis, remark = _diagnosis(args, rig, present)
    variants = variants_of(content, rig, runs, comparison, diagnosis,
                           args.diagnosis or 'diagnosis', say, len(args.since))
    names = ', '.join(entry.name for entry in present[:3]) + (', …' if len(present) > 3 else '')
    source = provenance(rig, runs, paths, roles, f'hst-drive {shlex.join(sys.argv[1:])}')
    sentence = (diagnosis.get('sentence') if diagnosis
                else told.sentence(comparison))
    text = page(f'{names} against {rig.name}', sentence, variants, source, diagnosis, remark)
    write_text(text, args.output)
    tell = say if '-' in (args.output, args.json) else print
    tell(f'wrote {args.output} ({len(text.encode()) / 1e6:.1f} MB)')
    if args.json:
        write_json({'schema': 'hst_drive/report/1', 'page': args.output,
                    'comparison': told.as_json(variants[0].comparison, rig.source),
                    'with_found': [{'title': entry.title, 'comparison': told.as_json(
                        entry.comparison, rig.source)} for entry in variants[1:]],
                    'diagnosis': diagnosis, 'provenance': {
                        **source._asdict(),
                        'sources': [entry._asdict() for entry in source.sources]}}, args.json)
    return 0


def _diagnosis(args: argparse.Namespace, rig: Rig, runs: list[Run]) -> tuple[dict | None, str]:
    """Return the diagnosis as JSON knows it, and what to remark if there is none."""
    from hst_drive.cli.diagnose import progress_line

    if args.diagnosis:
        found = read_json(args.diagnosis)
        _check(found, args.diagnosis)
        given = sorted(str(Path(entry.source).resolve()) for entry in runs)
        other = sorted(str(Path(str(name)).resolve()) for name in found.get('logs') or ()) != given
        return found, ('The diagnosis was made of other logs than those shown here: '
                       f'{", ".join(map(str, found.get("logs") or []))}.' if other else '')
    seconds = sum(float(entry.time[-1] - entry.time[0]) for entry in runs)
    if args.no_diagnosis:
        return None, ''
    if seconds > _LONG and not args.diagnose:
        remark = (f'Not diagnosed: the logs last {seconds / 60:.0f} min in all. Add --diagnose to '
                  'find out what is missing.')
        say(remark)
        return None, remark
    from hst_drive.diagnose.decide import diagnose
    from hst_drive.diagnose.result import as_json

    training = runs[:len(args.logs)]
    result = diagnose(rig, training, runs[len(args.logs):],
                      progress=progress_line())
    return as_json(result), ''


def _check(found: object, source: str) -> None:
    from hst_drive.diagnose.result import SCHEMA

    lacking = [key for key in ('verdict', 'sentence', 'effects', 'ladder', 'calibration')
               if not isinstance(found, dict) or key not in found]
    if lacking or found.get('schema') != SCHEMA or not found['ladder']:
        raise InputError(f"{source}: is not a diagnosis (schema '{SCHEMA}'); give the file that "
                         "'hst-drive diagnose --json' wrote")
