# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a page rests on: the files with their hashes, the rig, the versions, the date."""
from __future__ import annotations

from datetime import datetime, timezone
import hashlib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
import platform
from typing import NamedTuple, Sequence

import hst_drive
from hst_drive.bag.campaign import file_of
from hst_drive.measure.run import Run
from hst_drive.rig import Rig

TRAINING, HELD_OUT, BEFORE = 'training', 'held out', 'commissioning'
_CHUNK = 1 << 20


class Source(NamedTuple):
    """A log: where it is, what it holds and the SHA-256 of its files."""

    path: str
    role: str
    bytes: int
    sha256: str
    samples: int
    seconds: float
    rate: float
    notes: tuple[str, ...]


class Provenance(NamedTuple):
    """What a result rests on."""

    date: str
    command: str
    rig: str
    rig_file: str
    rig_digest: str
    sources: tuple[Source, ...]
    versions: dict[str, str]


def provenance(rig: Rig, runs: Sequence[Run], paths: Sequence[str], roles: Sequence[str],
               command: str) -> Provenance:
    """
    Collect what a page rests on.

    Parameters
    ----------
    rig : Rig
        What the model stands for.
    runs, paths, roles : sequence
        Logs, their files, and what they are used for: ``TRAINING``,
        ``HELD_OUT`` or ``BEFORE``.
    command : str
        As the user called it.

    """
    sources = tuple(_source(run, Path(path), role)
                    for run, path, role in zip(runs, paths, roles))
    now = datetime.now(timezone.utc).strftime('%Y-%m-%d %H:%M UTC')
    return Provenance(now, command, rig.name, rig.source, rig.digest, sources, versions())


def versions() -> dict[str, str]:
    """Return the versions of what computes."""
    found = {'hst_drive': hst_drive.__version__, 'Python': platform.python_version()}
    for name in ('numpy', 'scipy', 'numba'):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = 'not installed'
    return found


def _source(run: Run, path: Path, role: str) -> Source:
    files = [] if file_of(path) is None else [path] if path.is_file() else sorted(
        entry for entry in path.rglob('*') if entry.is_file())
    digest, size = hashlib.sha256(), 0
    for entry in files:
        with open(entry, 'rb') as stream:
            while chunk := stream.read(_CHUNK):
                digest.update(chunk)
                size += len(chunk)
    if not files:           # a log in memory: its numbers are its file
        for values in (run.time, *run.channels.values()):
            digest.update(values.tobytes())
            size += values.nbytes
    seconds = float(run.time[-1] - run.time[0])
    return Source(str(path), role, size, digest.hexdigest(), len(run), seconds,
                  1.0 / run.sample_time, run.notes)
