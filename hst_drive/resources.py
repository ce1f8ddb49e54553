# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the shipped files (config, launch) are, however the package was installed."""
from __future__ import annotations

from functools import cache
from pathlib import Path

from hst_drive.errors import InputError

_NAME = __package__


def share(*parts: str) -> Path:
    """
    Return the path of a shipped file.

    Parameters
    ----------
    parts : str
        Path below the share folder, such as ``'config', 'rig'``; none gives the folder itself.

    Returns
    -------
    Path
        Absolute; whether the file exists is for the caller to see.

    Raises
    ------
    InputError
        When the installation holds no shipped files.

    """
    return _root(Path(__file__).absolute().parent).joinpath(*parts)


@cache
def _root(package: Path) -> Path:
    """
    Return the share folder that belongs to the package in this folder.

    The files beside the running code come first, so that code and files are of one version even
    where the environment also knows another copy.
    """
    tree = package.parent
    if (tree / 'package.xml').is_file() and (tree / 'config').is_dir():
        return tree
    for prefix in package.parents:
        if (prefix / 'share' / _NAME / 'config').is_dir():
            return prefix / 'share' / _NAME
    # colcon build --symlink-install: the code lies in the build folder, the files do not.
    try:
        from ament_index_python.packages import get_package_share_path, PackageNotFoundError
    except ImportError:
        pass
    else:
        try:
            return get_package_share_path(_NAME)
        except (PackageNotFoundError, LookupError):
            pass
    raise InputError(f'{package}: the shipped files (config) are missing: expected them in a '
                     f'folder share/{_NAME} above the package; install {_NAME} again')
