# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Arguments that several verbs share."""
from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

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
                        help='judge on this log (repeatable; default: a third of each LOG)')


def add_rig_argument(parser: argparse.ArgumentParser) -> None:
    """Declare --rig."""
    parser.add_argument('--rig', metavar='RIG.yaml',
                        help='the rig the model stands for (default: the shipped test rig)')


def rig_of(args: argparse.Namespace) -> Rig:
    """Return the rig that was asked for."""
    from hst_drive.rig import default_rig, load_rig

    return load_rig(args.rig) if args.rig else default_rig()


def read_logs(paths: list[str], channels: str | None) -> list[Run]:
    """Read the logs of one campaign."""
    from hst_drive.bag import campaign

    return campaign.read_logs(paths, channels)
