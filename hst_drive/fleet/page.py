# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a fleet: one file without scripts that opens offline and prints."""
from __future__ import annotations

from datetime import date
from typing import Sequence

from hst_drive.fleet.summary import Summary, Trend
from hst_drive.report.markup import element, join, Markup, note, section, table
from hst_drive.report.page import asset
from hst_drive.units import for_people

_POLICY = "default-src 'none'; style-src 'unsafe-inline'"
_WIDTH, _HEIGHT, _EDGE = 320, 130, 14
_MOST_FIGURES = 60


def fleet_page(title: str, sentence: str, rows: Sequence[dict], summary: Summary,
               facts: Sequence[str]) -> str:
    """Return the page as HTML: rows as ``run_fleet`` returns them, and what they say together."""
    blocks = [
        element('header', element('h1', title), element('p', sentence, class_='sentence'),
                element('p', ' · '.join(facts), class_='facts')),
        _machines(summary), _trends(summary), _outliers(summary), _rows(rows)]
    links = [element('a', text, href=f'#{identity}') for identity, text in (
        ('machines', 'Machines'), ('trends', 'Over time'), ('outliers', 'Outliers'),
        ('campaigns', 'Campaigns'))]
    return '\n'.join([
        '<!DOCTYPE html>', '<html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        str(element('title', title)), f'<style>{asset("page.css")}</style></head><body>',
        '<a class="skip" href="#main">Skip to the content</a>',
        str(element('nav', join(links), aria_label='Sections')),
        '<main id="main">', *map(str, blocks), '</main></body></html>', ''])


def _machines(summary: Summary) -> Markup:
    effects = sorted({name for machine in summary.machines for name in machine.effects})
    verdicts = ('none', 'missing_effect', 'ambiguous', 'unknown')
    rows = [[machine.name, machine.campaigns, machine.failed,
             *(machine.verdicts.get(name, 0) for name in verdicts),
             *(machine.effects.get(name, 0) for name in effects)] for machine in summary.machines]
    return section(
        'machines', 'Which machine lacks what',
        note('Campaigns, verdicts, and in how many campaigns each effect was found.'),
        table(['machine', 'campaigns', 'failed', *verdicts, *effects], rows, 'Machines'))


def _trends(summary: Summary) -> Markup:
    if not summary.trends:
        return section('trends', 'Over time', note(
            'No machine shows an effect on four dates or more: no trend can be told.'))
    order = {'grows': 0, 'falls': 1, 'steady': 2}
    listed = sorted(summary.trends, key=lambda trend: order[trend.direction])
    rows = []
    for trend in listed:
        slope, unit = for_people(trend.slope, trend.unit)
        low, high = (for_people(value, trend.unit)[0] for value in (trend.low, trend.high))
        rows.append([trend.machine, f'{trend.effect}.{trend.parameter}', trend.direction, slope,
                     f'{low:.3g} to {high:.3g}', f'{unit} a year', len(trend.points)])
    figures = [element('figure', element('figcaption', f'{trend.machine}: {trend.effect} '
                                         f'{trend.direction}'), _figure(trend),
                       style='margin: 0 1rem 1rem 0')
               for trend in listed[:_MOST_FIGURES]]
    return section(
        'trends', 'Over time',
        note('Median slope of all pairs (Theil and Sen) with its 95 % interval; steady: the '
             'interval holds zero.'),
        table(['machine', 'effect', '', 'slope', '95 % interval', 'unit', 'campaigns'], rows,
              'Trends'),
        element('div', *figures, style='display: flex; flex-wrap: wrap'))


def _figure(trend: Trend) -> Markup:
    """Return a small picture: size with its interval over time, from zero."""
    shown = [[for_people(value, trend.unit)[0] for value in point[6:9]] for point in trend.points]
    unit = for_people(trend.points[0].value, trend.unit)[1]
    days = [date.fromisoformat(point.date).toordinal() for point in trend.points]
    top = max(max(values) for values in shown)
    bottom = min(0.0, min(min(values) for values in shown))
    span = (top - bottom) or 1.0

    def x(day: int) -> str:
        return f'{_EDGE + (day - days[0]) / (days[-1] - days[0]) * (_WIDTH - 2 * _EDGE):.1f}'

    def y(value: float) -> str:
        return f'{_HEIGHT - 2 * _EDGE - (value - bottom) / span * (_HEIGHT - 4 * _EDGE):.1f}'

    marks = []
    for day, (value, low, high) in zip(days, shown):
        marks += [element('line', x1=x(day), x2=x(day), y1=y(low), y2=y(high), stroke='#57606a'),
                  element('circle', cx=x(day), cy=y(value), r=3, fill='#0072b2')]
    texts = [
        element('text', trend.points[0].date, x=_EDGE, y=_HEIGHT - 4, font_size=11),
        element('text', trend.points[-1].date, x=_WIDTH - _EDGE, y=_HEIGHT - 4, font_size=11,
                text_anchor='end'),
        element('text', f'{top:.3g} {unit}', x=_EDGE, y=_EDGE - 2, font_size=11)]
    axis = element('line', x1=_EDGE, x2=_WIDTH - _EDGE, y1=y(bottom), y2=y(bottom),
                   stroke='#d0d7de')
    return element('svg', axis, *marks, *texts, viewBox=f'0 0 {_WIDTH} {_HEIGHT}', width=_WIDTH,
                   height=_HEIGHT, role='img',
                   aria_label=f'{trend.machine}: {trend.effect} over time')


def _outliers(summary: Summary) -> Markup:
    rows = []
    for entry in summary.outliers:
        value, unit = for_people(entry.point.value, entry.point.unit)
        rows.append([entry.point.campaign, f'{entry.point.effect}.{entry.point.parameter}', value,
                     for_people(entry.median, entry.point.unit)[0], unit, f'{entry.z:+.1f}'])
    return section('outliers', 'Unlike the others', note(
        'Robust z beyond 3.5 among the machines that show the effect (five at least).'),
        table(['campaign', 'effect', 'size', "machines' median", 'unit', 'z'], rows, 'Outliers')
        if rows else note('None.'))


def _rows(rows: Sequence[dict]) -> Markup:
    listed = [[row['campaign'], row['date'] or '', (row['diagnosis'] or {}).get('verdict') or
               'failed', row['reason'] or row['diagnosis']['sentence']] for row in rows]
    return section('campaigns', 'All campaigns',
                   table(['campaign', 'date', 'verdict', 'answer, or why there is none'], listed,
                         'Campaigns'))
