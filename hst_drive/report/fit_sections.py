# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Sections of the page on the fit: errors by signal, curves, and where the model fails."""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.channels import CHANNELS
from hst_drive.measure.compare import Comparison, pooled
from hst_drive.measure.where import Region
from hst_drive.report.comparison import error_row, range_of
from hst_drive.report.markup import element, join, Markup, note, number, plot, section, table


class Variant(NamedTuple):
    """A model of the page: what it is called, and how it compares with the logs."""

    title: str
    comparison: Comparison


def errors_section(variants: list[Variant], before: int = 0) -> Markup:
    """
    Return the errors signal by signal, the numbers of the verb compare.

    The last ``before`` logs, from when the machine was commissioned, have a table of their own.
    """
    shown = [(entry.title, entry.comparison.signals) for entry in variants]
    if before:
        shown = [('when it was commissioned', pooled(variants[0].comparison.logs[-before:])),
                 *((entry.title, pooled(entry.comparison.logs[:-before])) for entry in variants)]
    tables = []
    for title, signals in shown:
        rows = []
        for name, entry in signals.items():
            row = error_row(name, entry)
            rows.append([*row[:6], _ratio(row[6]), *row[7:]])
        tables.append(table(['signal', 'rmse', 'bias', 'max', 'noise', 'floor', '× floor',
                             'fit %', 'Russell M %', 'P %', 'C %'], rows, title))
    return section('errors', 'How large the error is', *tables, note(
        'noise: the sensor’s, estimated from the record. floor: what a perfect model would still '
        'show, since the noise of the recorded inputs shakes the replay. × floor: rmse over '
        'floor; 1 is a perfect model. All logs, as compare judges them; Russell’s errors hide '
        'small errors on a large mean.'))


def _ratio(value: float) -> Markup:
    kind = 'good' if value <= 1.25 else 'fair' if value <= 2 else 'bad'
    word = {'good': 'at the floor', 'fair': 'above the floor', 'bad': 'far above the floor'}[kind]
    return element('span', number(value), class_=f'ratio {kind}', title=word)


def curves_section(variants: list[Variant]) -> Markup:
    """Return the place of the curves with their controls."""
    logs = variants[0].comparison.logs
    return section(
        'curves', 'Measured against model',
        element('div', _choice('log', 'Log', [log.run.name for log in logs]),
                _choice('variant', 'Model', [entry.title for entry in variants]),
                element('span', class_='buttons', id='view-buttons'), class_='controls'),
        plot('curve-plots', 'measured and model over time'),
        note('Above: measured (black) and model (orange). Below: model minus measured; the grey '
             'band is twice the floor; what is yellow is not judged. Drag across a plot to zoom, '
             'double-click or press 0 to see all; with the plots in focus ← → move the cursor, '
             '+ − zoom, page keys pan.'),
        element('p', '', class_='note', id='thinned'))


def _choice(identity: str, label: str, options: list[str]) -> Markup:
    return element('label', f'{label} ', element(
        'select', *(element('option', title, value=place) for place, title in enumerate(options)),
        id=identity), hidden='' if len(options) < 2 else None)


def where_section(variants: list[Variant]) -> Markup:
    """Return where the error sits: maps, strips and the regions of the verb compare."""
    parts: list[object] = [
        element('div', _choice('where-variant', 'Model', [entry.title for entry in variants]),
                _choice('where-signal', 'Error of', [
                    CHANNELS[name].title for name in variants[0].comparison.signals]),
                class_='controls'),
        element('div', plot('map', 'error over pressure and speed'),
                plot('strips', 'error over temperature, commands and torque'), class_='pair'),
        note('Left: rms error over the floor, by pressure and speed; empty where the drive never '
             'was. Right: mean error and its scatter; the grey band is the floor.')]
    for variant in variants:
        regions = variant.comparison.where
        if regions:
            parts.append(table(['error of', 'at', 'share of error', 'share of time',
                                'explained by it'], [_region(entry) for entry in regions],
                               f'Where the error sits: {variant.title}'))
        else:
            parts.append(note(f'{variant.title}: no region holds more error than its time.'))
    return section('where', 'Where it fails', *parts)


def _region(region: Region) -> list[str]:
    title, low, high, unit = range_of(region)
    return [CHANNELS[region.signal].title, f'{title} {number(low)} to {number(high)} {unit}',
            *(f'{100 * share:.0f} %' for share in (
                region.share_of_error, region.share_of_time, region.explained))]


def notes_section(comparison: Comparison) -> Markup:
    """Return what the readers of the logs remarked; nothing if there is nothing."""
    lines = [f'{log.run.name}: {entry}' for log in comparison.logs for entry in log.run.notes]
    lines += [f'{log.run.name}: not judged: {span.start:.2f} to {span.end:.2f} s ({span.why})'
              for log in comparison.logs for span in log.judged.left_out]
    lines += [f'{log.run.name}: the clocks of commands and readings differ by '
              f'{1e3 * log.shift:.0f} ms; the commands were moved'
              for log in comparison.logs if log.shift]
    if not lines:
        return Markup('')
    return element('ul', join(element('li', line) for line in lines), class_='remarks')
