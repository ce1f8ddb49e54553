# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Arguments that several verbs share."""
from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from hst_drive.errors import InputError

if TYPE_CHECKING:
    from hst_drive.measure.run import Run
    from hst_drive.rig import Rig


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


def add_day_to_day_argument(parser: argparse.ArgumentParser) -> None:
    """Declare --day-to-day."""
    parser.add_argument(
        '--day-to-day', metavar='SHARE', type=float, help='by how much the machine differs from '
        'one day to the next, one sigma, in tolerances of the make (default: from the logs, if '
        'there are several, else 0.1)')


def day_to_day_of(args: argparse.Namespace) -> float | None:
    """Return the repeatability that was asked for."""
    if args.day_to_day is not None and not 0.0 <= args.day_to_day <= 10.0:
        raise InputError(f'--day-to-day {args.day_to_day:g}: expected a share of the tolerance '
                         'from 0 to 10, 0.1 say')
    return args.day_to_day


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
    from hst_drive.rig import default_rig, load_rig

    return load_rig(args.rig) if args.rig else default_rig()


def read_logs(paths: list[str], channels: str | None) -> list[Run]:
    """Read logs; where two have one name, the folder tells them apart."""
    from dataclasses import replace

    from hst_drive.bag import load_channel_map, read_log
    from hst_drive.measure.run import refuse_impossible, same_recording

    mapping = load_channel_map(channels) if channels else None
    runs = [read_log(path, mapping) for path in paths]
    for run in runs:
        refuse_impossible(run)
    places = [Path(path).resolve() for path in paths]
    for place, path in enumerate(paths):
        if places[place] in places[:place]:
            raise InputError(f'{path}: is given twice; the same log must count only once')
        twin = next((paths[k] for k in range(place) if same_recording(runs[k], runs[place])), None)
        if twin:
            raise InputError(f'{path}: holds the same recording as {twin}; a log must count only '
                             'once, and none can judge what was fitted to itself: leave one out')
    names = [run.name for run in runs]
    return [replace(run, name=f'{Path(path).resolve().parent.name}/{run.name}')
            if names.count(run.name) > 1 else run for run, path in zip(runs, paths)]


def read_json(path: str) -> dict:
    """Read a JSON file; one line says what is wrong with it."""
    try:
        return json.loads(Path(path).read_text(encoding='utf-8'))
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror}); check the path') from None
    except ValueError as error:
        raise InputError(f'{path}: is not JSON ({error}); expected what '
                         "'hst-drive diagnose --json' wrote") from None
