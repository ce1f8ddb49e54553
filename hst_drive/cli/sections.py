# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Long logs on the command line: when to cut, reading in sections, and what to say about it."""
from __future__ import annotations

import argparse
from itertools import chain
import os
from pathlib import Path
import sys
from typing import Iterator, TYPE_CHECKING

from hst_drive.errors import InputError

if TYPE_CHECKING:
    from hst_drive.measure.compare import Comparison
    from hst_drive.measure.run import Run
    from hst_drive.rig import Rig

MINUTES = 10.0
LONG_FILE = 60e6    # bytes of CSV; some two or three hours at 100 Hz
LONG_BAG = 150e6    # bytes, packed as our recorder does; some three hours at 100 Hz


def asks_for_sections(args: argparse.Namespace) -> bool:
    """Tell whether the log is to be cut: because the user says so, or because it is too long."""
    if args.sections is not None and not 1.0 <= args.sections < float('inf'):
        raise InputError(f'--sections {args.sections:g}: expected at least 1 min')
    if args.sections is None and not any(map(_too_long, args.logs)):
        return False
    for path in args.logs:
        if len(args.logs) > 1 and (args.sections or _too_long(path)):
            raise InputError(f'{path}: is to be cut in sections; give it alone')
    if args.closed_loop:
        raise InputError(f'{args.logs[0]}: is to be cut in sections, through which --closed-loop '
                         'cannot run; leave it out, or give a shorter log')
    return True


def _too_long(path: str) -> bool:
    from hst_drive.bag import is_bag

    if not os.path.exists(path):
        return False
    if not is_bag(path):
        return os.path.getsize(path) > LONG_FILE
    from hst_drive.bag.long_bag import bag_size
    return bag_size(path) > LONG_BAG


def in_sections(rig: Rig, args: argparse.Namespace) -> Comparison:
    """Compare a log section by section."""
    from hst_drive.bag import cut_log, ChannelMap, load_channel_map
    from hst_drive.measure.balances import is_part
    from hst_drive.measure.compare import model_of
    from hst_drive.measure.run import refuse_impossible
    from hst_drive.measure.sections import AFTER, BEFORE, compare_sections

    path, seconds = args.logs[0], 60.0 * (args.sections or MINUTES)
    mapping = load_channel_map(args.channels) if args.channels else ChannelMap()
    cut, again = (cut_log(path, mapping, seconds, BEFORE, AFTER) for _ in range(2))
    first = next(cut, None)
    if first is None:
        raise InputError(f'{path}: holds too few rows to compare')
    run = first.run
    if rig.whole and is_part(run, rig):     # unless its commands begin later
        run = next((other.run for other in again if not is_part(other.run, rig)), run)

    def progress(done: float) -> None:
        if sys.stderr.isatty():
            print(f'\rcompared up to {done / 3600:.1f} h', end='', file=sys.stderr, flush=True)

    def sections() -> Iterator[tuple[Run, float, float]]:
        for section in chain([first], cut):
            refuse_impossible(section.run)
            yield section

    return compare_sections(model_of(rig, [run]), Path(path).stem, path, sections(),
                            seconds, all_seconds=args.all, progress=progress)
