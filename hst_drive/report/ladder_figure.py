# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The ladder as a figure: how the error falls with each effect that is added."""
from __future__ import annotations

from pathlib import Path
from typing import Sequence

from hst_drive.channels import CHANNELS
from hst_drive.diagnose.result import Step
from hst_drive.report.drawing import COLOURS, new_figure, save
import numpy as np

_MARKS = 'osDv^P<>'     # one more than colours, so that a pair comes again late
_TICKS = (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)


def ladder_figure(steps: Sequence[Step], path: str | Path, title: str = '') -> None:
    """
    Draw the error over the noise floor after each step into a PNG, PDF or SVG.

    Parameters
    ----------
    steps : sequence of Step
        Of a diagnosis: datasheet, calibrated unit, then one step per effect.
    path : str or Path
        File to write.
    title : str
        Heading; none by default.

    Raises
    ------
    InputError
        If matplotlib is missing or the file cannot be written.

    """
    names = list(steps[0].holdout)
    figure = new_figure(max(5.0, 1.5 + 1.3 * len(steps)), 3.6)
    axis = figure.subplots()
    places = np.arange(len(steps))
    width = min(0.5 / max(len(names), 1), 0.09)
    for count, name in enumerate(names):
        colour, mark = COLOURS[count % len(COLOURS)], _MARKS[count % len(_MARKS)]
        shifted = places + (count - (len(names) - 1) / 2) * width
        for part, style, face in (('training', ':', 'white'), ('holdout', '-', colour)):
            values = [getattr(step, part).get(name, np.nan) for step in steps]
            axis.plot(shifted, values, style, marker=mark, color=colour, mfc=face, ms=5, lw=1.3,
                      label=CHANNELS[name].title if part == 'holdout' else None)
    axis.axhline(1.0, color='0.2', lw=1.0, ls='--', zorder=1, label='noise floor')
    axis.plot([], [], 'o-', color='0.4', ms=5, label='held-out data')
    axis.plot([], [], 'o:', color='0.4', mfc='white', ms=5, label='training data')
    axis.set_yscale('log')
    low, high = axis.get_ylim()
    shown = [tick for tick in _TICKS if low <= tick <= high]
    axis.set_yticks(shown, [f'{tick:g}' for tick in shown])
    axis.minorticks_off()
    axis.set_ylabel('error over the noise floor [1]')
    axis.set_xlim(-0.5, len(steps) - 0.5)
    axis.set_xticks(places, [('+ ' if place > 1 else '') + _wrapped(step.added)
                             for place, step in enumerate(steps)])
    axis.grid(axis='y', alpha=0.3, lw=0.5)
    axis.spines[['top', 'right']].set_visible(False)
    axis.legend(loc='upper left', bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize=8,
                borderaxespad=0.0)
    if title:
        axis.set_title(title, fontsize=9, loc='left')
    save(figure, path)


def _wrapped(name: str) -> str:
    """Return a name on several lines where it is longer than 14 characters."""
    lines = ['']
    for word in name.replace('_', '_ ').split(' '):
        if lines[-1] and len(lines[-1]) + len(word) > 14:
            lines.append('')
        lines[-1] += word if lines[-1].endswith('_') or not lines[-1] else f' {word}'
    return '\n'.join(lines)
