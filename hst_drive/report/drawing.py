# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What all figures share: matplotlib, which is optional and imported on use, and the file."""
from __future__ import annotations

from pathlib import Path

from hst_drive.errors import InputError


def load_pyplot():
    """
    Return matplotlib's pyplot, drawing into files.

    Raises
    ------
    InputError
        If matplotlib is not installed.

    """
    try:
        import matplotlib
    except ImportError:
        raise InputError('matplotlib is not installed; plots need it: '
                         "'pip install matplotlib' or 'apt install python3-matplotlib'") from None
    matplotlib.use('Agg')
    from matplotlib import pyplot
    return pyplot


def save(figure, path: str | Path) -> None:
    """
    Write a figure into the format that the file's name asks for, and close it.

    Raises
    ------
    InputError
        If the file cannot be written.

    """
    try:
        figure.savefig(path, dpi=150, bbox_inches='tight')
    except (OSError, ValueError) as error:
        raise InputError(f'{path}: cannot be written ({error}); use a name ending in .png or '
                         '.pdf in a folder that exists') from None
    finally:
        load_pyplot().close(figure)
