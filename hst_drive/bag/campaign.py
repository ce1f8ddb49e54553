# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The recordings of one campaign: each counts once, has a name of its own and can be true."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
import os
from pathlib import Path

from hst_drive.bag import load_channel_map, read_log
from hst_drive.bag.rosbag2 import bag_files
from hst_drive.errors import InputError
from hst_drive.measure.run import refuse_impossible, Run, same_recording


def read_logs(paths: Sequence[str | os.PathLike[str]],
              channels: str | os.PathLike[str] | None = None) -> list[Run]:
    """
    Read the logs of one campaign.

    Parameters
    ----------
    paths : sequence of path
        As for ``read_log``.
    channels : path, optional
        Channel map for all of them.

    Raises
    ------
    InputError
        If one cannot be used, or comes twice.

    """
    mapping = load_channel_map(channels) if channels else None
    return together([read_log(path, mapping) for path in paths])


def file_of(source: str | os.PathLike[str]) -> Path | None:
    """Return the file or bag that a recording comes from; None where that is a mere name."""
    try:
        return Path(source).resolve() if source and bag_files(Path(source), []) else None
    except InputError:      # a recording in memory; a folder may be called as it is
        return None


def together(runs: Sequence[Run]) -> list[Run]:
    """
    Return recordings as one campaign; where two have one name, the folder tells them apart.

    Raises
    ------
    InputError
        If a recording comes twice or holds what no drive has.

    """
    for run in runs:
        refuse_impossible(run)
    files = [file_of(run.source) for run in runs]
    for place, run in enumerate(runs):
        if files[place] is not None and files[place] in files[:place]:
            raise InputError(f'{run.source}: is given twice; the same log must count only once')
        twin = next((other.source for other in runs[:place] if same_recording(other, run)), None)
        if twin is not None:
            raise InputError(f'{run.source}: holds the same recording as {twin}; a log must count '
                             'only once, and none can judge what was fitted to itself: leave one '
                             'out')
    names = [run.name for run in runs]
    found = []
    for place, (run, file) in enumerate(zip(runs, files)):
        if names.count(run.name) > 1:
            if file:
                run = replace(run, name=f'{file.parent.name}/{run.name}')
            else:       # in memory
                name = f'{run.name} {names[:place].count(run.name) + 1}'
                run = replace(run, name=name, source=name)
        found.append(run)
    return found
