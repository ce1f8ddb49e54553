# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings that a scenario plays again."""
from __future__ import annotations

from pathlib import Path

from hst_drive.load.recorded import Recording
from hst_drive.measure.run import refuse_impossible


def read_recording(path: Path, channels: Path | None) -> Recording:
    """
    Read a bag or a CSV log, with a channel map where its names are foreign.

    Raises
    ------
    InputError
        If it cannot be used.

    """
    from hst_drive.bag import read_log      # nodes without a recording need no MCAP

    run = read_log(path, channels)
    refuse_impossible(run)
    return Recording(run.source, run.time, run.channels)
