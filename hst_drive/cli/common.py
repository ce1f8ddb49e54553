# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Arguments that several verbs share."""
from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from hst_drive.errors import InputError
from hst_drive.report.files import read_json

if TYPE_CHECKING:
    from hst_drive.measure.run import Run
    from hst_drive.rig import Rig

__all__ = ['add_holdout_argument', 'add_log_arguments', 'add_rig_argument', 'read_json',
           'read_logs', 'rig_of']


def add_log_arguments(parser: argparse.ArgumentParser, *, default: str = '') -> None:
    """Declare LOG..., --rig and --channels; with a default, LOG may be left out."""
    parser.add_argument('logs', metavar='LOG', nargs='*' if default else '+',
                        help='CSV file, rosbag2 folder or .mcap file'
                        + (f' (default: {default})' if default else ''))
    add_rig_argument(parser)
    parser.add_argument('--channels', metavar='MAP.yaml',
                        help='foreign column or topic names, and units, to ours')


def add_holdout_argument(parser: argparse.ArgumentParser) -> None:
    """Declare --holdout."""
    parser.add_argument('--holdout', metavar='LOG', action='append', default=[],
                        help='judge on this other log (repeatable; default: a third of each LOG)')


def add_since_argument(parser: argparse.ArgumentParser) -> None:
    """Declare --since and what goes with it."""
    parser.add_argument('--since', metavar='OLD', nargs='+', default=[],
                        help='say what has changed since these logs of the same machine, which '
                             'must be healthy (as commission and --rig UNIT.yaml, in one step)')
    add_day_to_day_argument(parser)


def add_day_to_day_argument(parser: argparse.ArgumentParser) -> None:
    """Declare --day-to-day."""
    parser.add_argument(
        '--day-to-day', metavar='SHARE', type=float, help='by how much the machine differs from '
        'one day to the next, one sigma, in tolerances of the make (default: from the logs, if '
        'there are several, else 0.1)')


def day_to_day_of(args: argparse.Namespace) -> float | None:
    """Return the repeatability that was asked for."""
    if args.day_to_day is not None and not getattr(args, 'since', True):
        raise InputError('--day-to-day: goes with --since, or with commission: it says what is '
                         'learnt from healthy logs')
    from hst_drive.rig.fingerprint import day_to_day_share

    return None if args.day_to_day is None else day_to_day_share(args.day_to_day, '--day-to-day')


def add_rig_argument(parser: argparse.ArgumentParser) -> None:
    """Declare --rig."""
    parser.add_argument('--rig', metavar='RIG.yaml',
                        help='the rig the model stands for (default: the shipped test rig)')


def rig_file_of(args: argparse.Namespace) -> str:
    """Return the file of the rig that was asked for."""
    from hst_drive.rig import default_rig_file

    return args.rig or str(default_rig_file())


def rig_of(args: argparse.Namespace) -> Rig:
    """Return the rig that was asked for."""
    from hst_drive.rig import load_rig

    return load_rig(args.rig)


def read_logs(paths: list[str], channels: str | None) -> list[Run]:
    """Read the logs of one campaign."""
    from hst_drive.bag import campaign

    return campaign.read_logs(paths, channels)
