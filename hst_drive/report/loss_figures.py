# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of a motor bench: maps over torque and speed, the motor-loss paper's Figs. 6 to 27."""
from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from hst_drive.errors import InputError
from hst_drive.losses.selection import grid
from hst_drive.losses.study import Study
from hst_drive.losses.table import VARIABLES
from hst_drive.losses.trends import quantities_of
from hst_drive.report.drawing import COLOURS, new_figure, require_matplotlib
from hst_drive.units import from_si
import numpy as np

_COLOURS = (*COLOURS, '#999999')     # one per motor
MARKS = ('o', 's', '^', 'D', 'v', 'P', 'X', '*')
LINES = ('-', '--', '-.', ':')
_PER_RESISTANCE = from_si(1.0, 'bar/(L/min)')
# Rows of the page: quantity, title with unit, factor, log scale, first figure of the paper, the
# figure of its fourth column.
_ROWS = (('R_el', 'R_el [bar/(L/min)]', _PER_RESISTANCE, True, 6, 9),
         ('R_1', 'R_1 [bar/(L/min)]', _PER_RESISTANCE, True, 10, 13),
         ('R_2', 'R_2 [bar/(L/min)]', _PER_RESISTANCE, True, 14, 17),
         ('slip', 'slip [%]', 100.0, False, 18, 27),
         ('torque_loss', 'torque loss [%]', 100.0, False, 21, 27),
         ('efficiency', 'overall efficiency [%]', 100.0, False, 24, 27))
_MAPS = (('efficiency', 'overall efficiency [%]', 'viridis'), ('slip', 'slip [%]', 'magma_r'),
         ('torque_loss_share', 'torque loss [%]', 'cividis_r'))


def draw(study: Study, target: str | Path, say: Callable[[str], None]) -> list[Path]:
    """
    Draw all pictures.

    Parameters
    ----------
    study : Study
        The bench.
    target : str or path
        A name ending in .pdf: all pages into it. Else a folder that gets PNGs.
    say : callable
        Told the progress.

    Returns
    -------
    list of Path
        Files written.

    Raises
    ------
    InputError
        If matplotlib is missing or nothing can be written there.

    """
    require_matplotlib()
    target = Path(target)
    if target.suffix.lower() not in ('', '.pdf'):
        raise InputError(f'{target}: expected a folder for PNGs, or a name ending in .pdf')
    try:
        if target.suffix.lower() == '.pdf':
            from matplotlib.backends.backend_pdf import PdfPages

            with PdfPages(target) as pages:
                for name, figure in _pages(study):
                    say(f'drawing {name} ...')
                    pages.savefig(figure, bbox_inches='tight')
            return [target]
        target.mkdir(parents=True, exist_ok=True)
        out = []
        for name, figure in _pages(study):
            say(f'drawing {name} ...')
            out.append(target / f'{name}.png')
            figure.savefig(out[-1], dpi=110, bbox_inches='tight')
        return out
    except OSError as error:
        raise InputError(f'{target}: cannot be written ({error.strerror}); name a folder, or a '
                         '.pdf file in a folder that exists') from None


def _pages(study: Study) -> Iterator[tuple[str, object]]:
    yield 'figures_6_to_27', _paper_page(study)
    for size in study.scales.sizes:
        yield f'maps_{from_si(size, "cc/rev"):.4g}_cc', _map_page(study, size)


def _map_page(study: Study, size: float):
    """Draw efficiency, slip and torque loss over torque and speed, a row per temperature."""
    bench = study.bench
    warmth, degrees = bench.levels('temperature')
    figure = new_figure(12.5, 0.7 + 3.2 * len(degrees), layout='constrained')
    axes = figure.subplots(len(degrees), 3, squeeze=False)
    for j, degree in enumerate(degrees):
        rows = (warmth == j) & bench.of_motor(size)
        if not rows.any():
            for axis in axes[j]:
                axis.set_axis_off()
            continue
        field = grid(study, size, float(np.median(bench.viscosity[rows])), 31)
        x, y = from_si(field['motor_speed'], 'rpm'), field['load_torque']
        for axis, (name, title, colours) in zip(axes[j], _MAPS):
            values = 100.0 * field[name]
            filled = axis.contourf(x, y, values, levels=14, cmap=colours)
            lines = axis.contour(x, y, values, levels=filled.levels[::2], colors='white',
                                 linewidths=0.6)
            axis.clabel(lines, fmt='%.3g', fontsize=7)
            axis.plot(from_si(bench.speed[rows], 'rpm'), bench.load_torque[rows], '.', ms=2.5,
                      color='0.25')
            axis.set_title(f'{title}, {from_si(degree, "degC"):.0f} degC', fontsize=9)
            axis.set_xlabel('motor speed [rpm]', fontsize=8)
            axis.set_ylabel('load torque [N.m]', fontsize=8)
            axis.tick_params(labelsize=7)
            figure.colorbar(filled, ax=axis, pad=0.02).ax.tick_params(labelsize=7)
    figure.suptitle(f'Motor of {from_si(size, "cc/rev"):.4g} cc/rev: fitted maps; dots: measured '
                    'points', fontsize=10)
    return figure


def _paper_page(study: Study):
    """Draw the paper's Figs. 6 to 27 from a table: rows of quantities, columns of temperatures."""
    bench = study.bench
    labels = {name: bench.levels(name) for name in VARIABLES}
    measured, fitted = quantities_of(bench, study.found), _fitted(study)
    _, degrees = labels['temperature']
    columns = len(degrees) + 1
    figure = new_figure(4.3 * columns, 3.1 * len(_ROWS) + 1.2, layout='constrained')
    axes = figure.subplots(len(_ROWS), columns, squeeze=False)
    for row, (name, title, factor, log, number, last) in zip(axes, _ROWS):
        if not np.isfinite(measured[name]).any():
            for axis in row:
                axis.set_axis_off()
            row[0].text(0.0, 0.5, f'{title}: needs the case drain flow, Eq. (2)', fontsize=10)
            continue
        for j, degree in enumerate(degrees):
            _curves(row[j], bench, labels, j, measured[name] * factor, fitted[name] * factor)
            figure_number = f'Fig. {number + j}: ' if len(degrees) == 3 else ''
            row[j].set_title(f'{figure_number}{title}, {from_si(degree, "degC"):.0f} degC',
                             fontsize=9)
            row[j].set_xlabel('motor speed [rpm]', fontsize=8)
        if last == 27:
            _by_temperature(row[-1], study, labels, name, title, factor)
        else:
            _compared(row[-1], bench, labels, measured[name] * factor, fitted[name] * factor)
            row[-1].set_title(f'Fig. {last}: {title}, measured and fitted', fontsize=9)
        for axis in row:
            axis.set_ylabel(title, fontsize=8)
            axis.tick_params(labelsize=7)
            axis.grid(alpha=0.25, lw=0.4, which='both')
            if log:
                axis.set_yscale('log')
                for formatter in (axis.yaxis.set_major_formatter, axis.yaxis.set_minor_formatter):
                    formatter(lambda value, _: f'{value:g}')
                axis.tick_params(axis='y', which='minor', labelsize=6)
    _legend(figure, labels)
    return figure


def _fitted(study: Study) -> dict[str, np.ndarray]:
    bench, lost = study.bench, study.at_rows
    ideal = bench.pressure * bench.displacement
    return {'R_el': study.fitted.external, 'R_1': study.fitted.inlet,
            'R_2': study.fitted.internal, 'slip': lost.leakage / bench.flow,
            'torque_loss': lost.torque_loss / ideal, 'efficiency': study.predicted.efficiency}


def _curves(axis, bench, labels, level: int, measured: np.ndarray, fitted: np.ndarray) -> None:
    """Draw a quantity over speed: colour per motor, mark and line per load."""
    motor, load = labels['size'][0], labels['load'][0]
    for k in range(motor.max() + 1):
        for m in range(load.max() + 1):
            rows = np.flatnonzero((motor == k) & (load == m)
                                  & (labels['temperature'][0] == level))
            rows = rows[np.argsort(bench.speed[rows])]
            if not len(rows):
                continue
            colour = _COLOURS[k % len(_COLOURS)]
            rpm = from_si(bench.speed[rows], 'rpm')
            axis.plot(rpm, _positive(measured[rows]), MARKS[m % len(MARKS)], color=colour, ms=2.6,
                      mew=0.0, alpha=0.75)
            axis.plot(rpm, _positive(fitted[rows]), LINES[m % len(LINES)], color=colour, lw=0.9)


def _positive(values: np.ndarray) -> np.ndarray:
    return np.where(values > 0, values, np.nan)


def _compared(axis, bench, labels, measured: np.ndarray, fitted: np.ndarray) -> None:
    """Draw the largest motor at the lowest temperature alone, with 2.5 % about the fit."""
    rows = (labels['size'][0] == labels['size'][0].max()) & (labels['temperature'][0] == 0)
    colour = _COLOURS[int(labels['size'][0].max()) % len(_COLOURS)]
    for m in range(labels['load'][0].max() + 1):
        own = np.flatnonzero(rows & (labels['load'][0] == m))
        own = own[np.argsort(bench.speed[own])]
        rpm = from_si(bench.speed[own], 'rpm')
        axis.fill_between(rpm, 0.975 * fitted[own], 1.025 * fitted[own], color='0.85')
        axis.plot(rpm, fitted[own], LINES[m % len(LINES)], color=colour, lw=0.9)
        axis.plot(rpm, _positive(measured[own]), MARKS[m % len(MARKS)], color=colour, ms=3,
                  mew=0.0)
    axis.set_xlabel('motor speed [rpm]; grey: +-2.5 %', fontsize=8)


def _by_temperature(axis, study: Study, labels, name: str, title: str, factor: float) -> None:
    """Draw a quantity over temperature per motor, at the middle load and speed (Fig. 27)."""
    bench = study.bench
    load = float(labels['load'][1][len(labels['load'][1]) // 2])
    speed = float(labels['speed'][1][len(labels['speed'][1]) // 2])
    order = np.argsort(bench.temperature)
    # The table's own oil, by interpolation: viscosity falls smoothly with temperature.
    degrees = np.linspace(bench.temperature.min(), bench.temperature.max(), 15)
    viscosity = np.exp(np.interp(degrees, bench.temperature[order],
                                 np.log(bench.viscosity[order])))
    key = 'torque_loss_share' if name == 'torque_loss' else name
    for k, size in enumerate(study.scales.sizes):
        at = study.operate(speed, load, viscosity, size)
        axis.plot(from_si(degrees, 'degC'), factor * at[key], color=_COLOURS[k % len(_COLOURS)],
                  lw=1.2)
    axis.set_title(f'Fig. 27: {title}, {load:.3g} N.m, {from_si(speed, "rpm"):.0f} rpm',
                   fontsize=9)
    axis.set_xlabel('oil temperature [degC]', fontsize=8)


def _legend(figure, labels) -> None:
    from matplotlib.lines import Line2D

    motors = [Line2D([], [], color=_COLOURS[k % len(_COLOURS)], lw=2,
                     label=f'{from_si(size, "cc/rev"):.4g} cc/rev')
              for k, size in enumerate(labels['size'][1])]
    loads = [Line2D([], [], color='0.3', marker=MARKS[m % len(MARKS)], ms=4,
                    ls=LINES[m % len(LINES)], lw=1, label=f'{load:.3g} N.m')
             for m, load in enumerate(labels['load'][1])]
    figure.legend(handles=[*motors, *loads], loc='outside upper center', fontsize=9,
                  ncol=max(len(motors) + len(loads), 1), frameon=False,
                  title='marks: from the measured rows; lines: fitted', title_fontsize=9)
