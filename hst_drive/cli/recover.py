# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The verb ``recover``: save what is readable of a cut or damaged bag."""
from __future__ import annotations

import argparse

HELP = 'save what is readable of a bag whose recorder was killed'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bag', metavar='BAG', help='rosbag2 folder or .mcap file')
    parser.add_argument('-o', '--output', metavar='FOLDER', required=True,
                        help='rosbag2 folder to create')


def run(args: argparse.Namespace) -> int:
    """Recover the bag and say how much there was."""
    from hst_drive.bag import recover

    found = recover(args.bag, args.output)
    lost = f'; {found.damaged} damaged records left out' if found.damaged else ''
    print(f'{args.output}: {found.messages} messages of {found.topics} topics, '
          f'{found.seconds:.1f} s{lost}')
    return 0
