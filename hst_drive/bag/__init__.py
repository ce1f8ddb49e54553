# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings on disk: CSV files, rosbag2 folders and MCAP files; all of it works without ROS."""
from __future__ import annotations

import os
from pathlib import Path

from hst_drive.bag.channels import ChannelMap, load_channel_map
from hst_drive.bag.csv_log import read_csv, write_csv
from hst_drive.bag.mcap_bag import is_mcap
from hst_drive.bag.recovery import recover
from hst_drive.bag.signals import read_bag
from hst_drive.bag.writer import BagWriter, write_run
from hst_drive.errors import InputError
from hst_drive.measure.run import Run

__all__ = ['BagWriter', 'ChannelMap', 'load_channel_map', 'read_bag', 'read_csv', 'read_log',
           'recover', 'write_csv', 'write_run']


def read_log(path: str | os.PathLike[str],
             channel_map: ChannelMap | str | os.PathLike[str] | None = None) -> Run:
    """
    Read a recording, whatever its form.

    Parameters
    ----------
    path : path
        CSV file, rosbag2 folder, or lone .mcap (or .db3) file; told apart by content.
    channel_map : ChannelMap or path, optional
        What is not under our own names.

    Raises
    ------
    InputError
        If it cannot be used; one line that says why and what to do.

    """
    path = Path(path)
    if channel_map is None:
        channel_map = ChannelMap()
    elif not isinstance(channel_map, ChannelMap):
        channel_map = load_channel_map(channel_map)
    try:
        if path.is_dir() or path.suffix in ('.mcap', '.db3') and path.stat().st_size \
                or is_mcap(path):
            return read_bag(path, channel_map)
    except OSError as error:
        raise InputError(f'{path}: cannot be read: {error.strerror}') from None
    return read_csv(path, channel_map)
