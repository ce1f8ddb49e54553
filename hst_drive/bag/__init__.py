# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Recordings on disk: CSV files, rosbag2 folders and MCAP files; all of it works without ROS.

What handles bags is imported on use (``packages``).
"""
from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path

from hst_drive.bag.channels import ChannelMap, load_channel_map
from hst_drive.bag.csv_log import read_csv, write_csv
from hst_drive.bag.csv_sections import csv_sections, Section
from hst_drive.bag.kinds import is_mcap
from hst_drive.bag.packages import on_use
from hst_drive.errors import InputError
from hst_drive.measure.run import Run

__all__ = ['BagWriter', 'ChannelMap', 'Section', 'bag_sections', 'csv_sections', 'cut_log',
           'find_storage', 'is_bag', 'load_channel_map', 'read_bag', 'read_csv', 'read_log',
           'recover', 'recover_command', 'write_csv', 'write_run']
_ON_USE = {'BagWriter': 'writer', 'write_run': 'writer', 'read_bag': 'signals',
           'bag_sections': 'long_bag', 'recover': 'recovery', 'recover_command': 'mcap_bag',
           'find_storage': 'storage'}


def __getattr__(name: str):
    if name not in _ON_USE:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    return getattr(on_use(f'{__name__}.{_ON_USE[name]}'), name)


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
    if channel_map is None:
        channel_map = ChannelMap()
    elif not isinstance(channel_map, ChannelMap):
        channel_map = load_channel_map(channel_map)
    if is_bag(path):
        return __getattr__('read_bag')(Path(path), channel_map)
    return read_csv(path, channel_map)


def cut_log(path: str | os.PathLike[str], channel_map: ChannelMap, seconds: float, before: float,
            after: float) -> Iterator[Section]:
    """Yield a recording in sections, whatever its form; ``csv_sections`` says more."""
    cut = __getattr__('bag_sections') if is_bag(path) else csv_sections
    return cut(path, channel_map, seconds, before, after)


def is_bag(path: str | os.PathLike[str]) -> bool:
    """
    Tell a bag from a CSV file.

    Raises
    ------
    InputError
        If there is nothing to read.

    """
    path = Path(path)
    try:
        return (path.is_dir() or is_mcap(path)
                or path.suffix in ('.mcap', '.db3', '.zstd') and path.stat().st_size > 0)
    except OSError as error:
        raise InputError(f'{path}: cannot be read: {error.strerror}; check the path') from None
