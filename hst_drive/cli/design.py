# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``design``: the next test, for effects that the logs cannot tell apart.

Takes the rivals from a diagnosis, or from --effects, and writes a load and command profile of at
most two minutes within the rig's limits, for 'hst-drive run' or the nodes load_profile and
controller. Chosen is the test in which the rivals come out furthest apart after each has been
fitted to the other, the unit's tolerances included. Where no test will do, it names the sensor.
"""
from __future__ import annotations

import argparse

from hst_drive.cli.common import add_rig_argument, read_json, rig_of
from hst_drive.cli.output import (
    add_force_argument, add_json_argument, refuse_to_replace, write_json, write_yaml)
from hst_drive.errors import InputError

HELP = 'write the test that separates effects which the logs cannot'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('diagnosis', metavar='DIAGNOSIS.json', nargs='?',
                        help="what 'diagnose --json' wrote")
    parser.add_argument('-o', '--output', metavar='SCENARIO.yaml',
                        help='scenario file to write (default: show the advice only)')
    add_force_argument(parser, 'SCENARIO.yaml')
    add_rig_argument(parser)
    parser.add_argument('--effects', metavar='A,B',
                        help='tell these apart (default: what the diagnosis could not)')
    parser.add_argument('--duration', metavar='S', type=float, default=120.0,
                        help='longest test, 20 to 120 s (default: 120)')
    parser.add_argument('--closed-loop', action='store_true',
                        help='let the controller hold the speed (default: give its commands)')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Design and say what to expect."""
    from hst_drive.cli.diagnose import progress_line
    from hst_drive.diagnose.next_test import next_test
    from hst_drive.report.design import as_json, open_nothing, text

    wanted = [name.strip() for name in args.effects.split(',') if name.strip()] \
        if args.effects is not None else None
    if args.diagnosis is None and wanted is None:
        raise InputError('DIAGNOSIS.json or --effects: expected at least one of the two')
    if args.output:
        refuse_to_replace(args.output, args.force)
    diagnosis = read_json(args.diagnosis) if args.diagnosis is not None else None
    result = next_test(rig_of(args), diagnosis, args.diagnosis, wanted, duration=args.duration,
                       closed_loop=args.closed_loop, progress=progress_line())
    if result is None:
        print(open_nothing(diagnosis, args.diagnosis)
              + ' (--effects A,B asks for a test that tells two apart)')
        return 0
    if args.output:
        write_yaml(result.content, args.output)
    if args.json:
        write_json(as_json(result, args.output), args.json)
    if args.json != '-':
        print(text(result, args.output, args.rig))
    return 0
