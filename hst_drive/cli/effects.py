# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``effects``: what a baseline drive model may lack.

Without an id, lists all effects by the balance that they enter; with one, explains it. With --rig
only those that have a place in the equations of the rig's circuit, with the sizes and bounds of
its machine. Effects of other packages (entry-point group hst_drive.effects) are listed with the
package's name. Numbers are in SI. The ids are those of rig files, of diagnoses and of the plant
node's parameter ``effects``.
"""
from __future__ import annotations

import argparse

from hst_drive.cli.common import rig_of
from hst_drive.cli.output import add_json_argument, say, write_json

HELP = 'physical effects that the model can add: list, or explain one'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('id', nargs='?', metavar='ID',
                        help='effect to explain (default: list all)')
    parser.add_argument('--rig', metavar='RIG.yaml',
                        help="only what its circuit has a place for (default: all circuits')")
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the list or the explanation."""
    from hst_drive.effects import left_out
    from hst_drive.report.effects import as_json, chosen, text

    for line in left_out():
        say(line)
    effects = chosen(args.id, rig_of(args) if args.rig else None)
    if args.json != '-':
        print(text(effects, args.id))
    if args.json:
        write_json(as_json(effects), args.json)
    return 0
