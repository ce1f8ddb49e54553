# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Packages that only MCAP files and compressed bags need, imported on use.

ROS 2 for Ubuntu 24.04 has no package of the ``mcap`` library: the nodes, CSV files and sqlite3
bags do without it.
"""
from __future__ import annotations

from importlib import import_module
from types import ModuleType

from hst_drive.errors import InputError


def on_use(name: str) -> ModuleType:
    """
    Import a module that may need such a package.

    Raises
    ------
    InputError
        If the package is missing; one line that says what to do.

    """
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name.partition('.')[0] not in ('mcap', 'lz4', 'zstandard'):
            raise
        raise InputError(
            f"the Python package '{error.name}' is missing; MCAP files and compressed bags need "
            "it: 'pip install mcap', where pip refuses in a 'python3 -m venv "
            "--system-site-packages' (CSV files and sqlite3 bags work without)") from None
