# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Packages that only MCAP files and compressed bags need, imported on use.

ROS 2 for Ubuntu 24.04 has no package of the ``mcap`` library, but rosbag2_py (``storage``); the
nodes, CSV files and sqlite3 bags do without either.
"""
from __future__ import annotations

from importlib import import_module
from types import ModuleType

from hst_drive.errors import InputError

_VENV = ("where pip refuses make a venv first: 'python3 -m venv --system-site-packages VENV && . "
         "VENV/bin/activate'")


class MissingPackage(InputError):
    """What was asked for needs a package that is not installed."""


def on_use(name: str) -> ModuleType:
    """
    Import a module that may need such a package.

    Raises
    ------
    MissingPackage
        If the package is missing; one line that says what to do.

    """
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        package = error.name.partition('.')[0]
        if package == 'zstandard':
            advice = ("compressed bags need it: 'sudo apt install python3-zstandard' or 'pip "
                      "install zstandard'")
        elif package in ('mcap', 'lz4'):
            advice = ("MCAP files need it, or ROS 2's rosbag2_py: 'sudo apt install "
                      "ros-jazzy-rosbag2', or 'pip install mcap'; CSV files and sqlite3 bags "
                      'need neither')
        else:
            raise
        raise MissingPackage(
            f"the Python package '{package}' is missing; {advice} ({_VENV})") from None
