# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What all figures share: matplotlib, which is optional and imported on use, and the file."""
from __future__ import annotations

from pathlib import Path

from hst_drive.errors import InputError

# Okabe and Ito's colours, told apart by colour-blind readers, without yellow, which is too light
# for lines.
BLUE, VERMILION, BLACK = '#0072B2', '#D55E00', '#000000'
COLOURS = (BLUE, VERMILION, '#009E73', '#CC79A7', BLACK, '#56B4E9', '#E69F00')


def require_matplotlib() -> None:
    """Raise InputError where matplotlib is missing: better before the work than after."""
    try:
        import matplotlib.figure    # noqa: F401
    except ImportError:
        raise InputError('matplotlib is not installed; plots need it: '
                         "'pip install matplotlib' or 'apt install python3-matplotlib'") from None


def new_figure(width: float, height: float, **options):
    """
    Return an empty figure [inch], apart from what a caller may have drawn with pyplot.

    Raises
    ------
    InputError
        If matplotlib is not installed.

    """
    require_matplotlib()
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), **options)


def save(figure, path: str | Path) -> None:
    """
    Write a figure into the format that the file's name asks for.

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
