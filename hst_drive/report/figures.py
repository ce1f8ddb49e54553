# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Measured and modelled signals of a log as a figure for papers and screens."""
from __future__ import annotations

from pathlib import Path

from hst_drive.channels import CHANNELS
from hst_drive.measure.compare import LogComparison
from hst_drive.report.drawing import BLACK, BLUE, new_figure, save, VERMILION
from hst_drive.units import difference_from_si, from_si
import numpy as np

MEASURED, MODEL, RESIDUAL = BLACK, VERMILION, BLUE
LEFT_OUT = '#F7F3C8'


def comparison_figure(log: LogComparison, path: str | Path) -> None:
    """
    Draw measured and modelled signals of one log, the error under each, into a PNG or PDF.

    With the pump command below this is what Fig. 5 of the drill-drive paper shows.

    Raises
    ------
    InputError
        If matplotlib is missing or the file cannot be written.

    """
    names = list(log.signals)
    commanded = 'pump_command' in log.run
    heights = [height for _ in names for height in (2.0, 1.0)] + [1.3] * commanded
    figure = new_figure(9.0, 1.1 + 1.8 * len(names) + 0.8 * commanded)
    axes = figure.subplots(len(heights), 1, sharex=True, squeeze=False,
                           gridspec_kw={'height_ratios': heights, 'hspace': 0.12})
    for index, name in enumerate(names):
        channel, errors = CHANNELS[name], log.signals[name]
        top, bottom = axes[2 * index, 0], axes[2 * index + 1, 0]
        model, measured = log.model[name], log.run[name]
        top.plot(log.run.time, from_si(measured, channel.display), color=MEASURED, lw=0.7,
                 label='measured')
        top.plot(log.run.time, from_si(model, channel.display), color=MODEL, lw=0.9,
                 label='model')
        top.set_ylabel(f'{channel.title}\n[{channel.display}]', fontsize=6.5)
        top.text(0.995, 0.06, f'rmse {errors.noise_ratio:.2f} x floor', fontsize=7, ha='right',
                 transform=top.transAxes, bbox={'fc': 'white', 'ec': 'none', 'pad': 1.5})
        bottom.plot(log.run.time, difference_from_si(model - measured, channel.display),
                    color=RESIDUAL, lw=0.5)
        floor = difference_from_si(errors.floor, channel.display)
        bottom.axhspan(-2 * floor, 2 * floor, color='0.85', zorder=0)
        spread = np.nanmax(np.abs(difference_from_si(model - measured, channel.display)))
        bottom.set_ylim(-1.05 * max(spread, 2 * floor), 1.05 * max(spread, 2 * floor))
        bottom.set_ylabel(f'error\n[{channel.display}]', fontsize=6.5)
    if commanded:
        unit = CHANNELS['pump_command'].display
        axes[-1, 0].plot(log.run.time, from_si(log.run['pump_command'], unit), color=MEASURED,
                         lw=0.7)
        axes[-1, 0].set_ylabel(f'pump command\n[{unit}]', fontsize=6.5)
    for axis in axes[:, 0]:
        for span in log.judged.left_out:
            axis.axvspan(span.start, span.end, color=LEFT_OUT, zorder=0, lw=0)
        axis.tick_params(labelsize=7)
        axis.grid(alpha=0.25, lw=0.4)
    shaded = 'grey: twice the floor' + ('; yellow: left out' if log.judged.left_out else '')
    axes[0, 0].set_title(f'{log.run.name}: measured and model ({shaded})', fontsize=9, loc='left')
    axes[0, 0].legend(loc='lower right', bbox_to_anchor=(1, 1.0), ncol=2, fontsize=7,
                      frameon=False, borderpad=0.1)
    axes[-1, 0].set_xlabel('time [s]', fontsize=8)
    figure.align_ylabels()
    save(figure, path)
