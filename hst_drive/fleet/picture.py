# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The picture of a size over a machine's life, and on: SVG that needs no script."""
from __future__ import annotations

from datetime import date
import math
from typing import Callable

from hst_drive.fleet.summary import Followed
from hst_drive.fleet.words import amount, day, far, until
from hst_drive.report.markup import element, Markup
from hst_drive.units import for_people
import numpy as np

_WIDTH, _HEIGHT = 420, 230     # as wide as a telephone: there letters keep their size
_LEFT, _RIGHT, _TOP, _BOTTOM = 52, 12, 22, 30
_UNIT = 80              # so much room has the axis's unit
_LABELS = 5             # most dates at the axis
_AHEAD = 0.5            # of the history, that is shown of what comes
_STEPS = 40             # of the band
_PROMINENT = 3.0        # times the largest size: a limit further off is told, not drawn
INK, SOFT, BLUE, RED, ORANGE = '#1b1f24', '#57606a', '#0072b2', '#b03a00', '#d55e00'


def picture(entry: Followed, label: str) -> Markup:
    """Return sizes with their intervals, what they follow and where that leads."""
    growth, history = entry.growth, entry.growth.usual
    scale, unit = _display(entry.unit)
    values, wide = history.values * scale, 1.96 * history.sigmas * scale
    first, now = float(history.days[0]), growth.now
    end = now + _AHEAD * max(now - first, 60.0)
    if entry.remaining and not far(entry.remaining.middle, now):
        end = min(max(end, entry.remaining.middle + 0.1 * (now - first)),
                  now + 1.5 * max(now - first, 60.0))
    # What does not grow leads nowhere.
    leads = entry.grows or entry.remaining and not far(entry.remaining.middle, now)
    last = end if leads else now
    start = max((jump.before for jump in growth.jumps), default=first)
    days = np.linspace(start, last, _STEPS)
    band = np.array([growth.band(at) for at in days]) * scale if growth.kind != 'too few dates' \
        else np.empty((0, 3))
    if values.min() >= 0.0:
        band = band.clip(min=0.0)       # a leak that is closed goes no further
    reach = max(np.abs(values).max() + wide.max(), *np.abs(band[days <= now][:, 1]), 1e-300) \
        if len(band) else np.abs(values).max() + wide.max()
    limit = None if entry.limit is None else entry.limit * scale
    drawn = limit is not None and abs(limit) < _PROMINENT * reach
    marks = np.concatenate([values + wide, values - wide, [0.0], [limit] if drawn else [],
                            band[:, 1].clip(-2.0 * reach, 2.0 * reach)])
    low, high = float(marks.min()), float(marks.max())
    low, high = low - 0.05 * (high - low), high + 0.08 * (high - low)

    def x(at: float) -> float:
        return _LEFT + (at - first) / (end - first) * (_WIDTH - _LEFT - _RIGHT)

    def y(value: float) -> float:
        share = (min(max(value, low), high) - low) / (high - low)
        return _HEIGHT - _BOTTOM - share * (_HEIGHT - _TOP - _BOTTOM)

    parts = [*_axes(x, y, low, high, first, end, unit)]
    if len(band):
        past = days <= now
        for part, fill in ((past, '#0072b226'), (~past, '#d55e0022')):
            edge = np.flatnonzero(part)
            if not len(edge):
                continue
            part = slice(max(edge[0] - 1, 0), edge[-1] + 1)
            ring = [*zip(days[part], band[part, 0]), *zip(days[part][::-1], band[part, 2][::-1])]
            parts.append(element('polygon', points=_points(ring, x, y), fill=fill))
        shown = (band[:, 1] >= low) & (band[:, 1] <= high)     # beyond, it leaves the picture
        parts.append(element('polyline', points=_points([*zip(days[shown], band[shown, 1])], x, y),
                             fill='none', stroke=BLUE, stroke_width=1.5))
    for jump in growth.jumps:
        middle = x(0.5 * (jump.after + jump.before))
        parts.append(element('rect', x=f'{x(jump.after):.1f}', y=_TOP,
                             width=f'{x(jump.before) - x(jump.after):.1f}',
                             height=_HEIGHT - _TOP - _BOTTOM, fill='#57606a1f'))
        parts.append(element('text', 'changed', x=f'{middle:.1f}', y=_TOP + 11, font_size=11,
                             text_anchor='middle', fill=SOFT))
    parts.append(element('line', x1=f'{x(now):.1f}', x2=f'{x(now):.1f}', y1=_TOP,
                         y2=_HEIGHT - _BOTTOM, stroke='#8c959f', stroke_dasharray='2 3'))
    # Beside the axis's unit, also where there is one date only.
    parts.append(element('text', 'last log', x=f'{max(x(now), _LEFT + _UNIT):.1f}', y=_TOP - 8,
                         font_size=11, text_anchor='middle', fill=SOFT))
    if drawn:
        parts += [element('line', x1=_LEFT, x2=_WIDTH - _RIGHT, y1=f'{y(limit):.1f}',
                          y2=f'{y(limit):.1f}', stroke=RED, stroke_width=1.5,
                          stroke_dasharray='7 4'),
                  element('text', f'limit {amount(entry.limit, entry.unit)}', x=_LEFT + 4,
                          y=f'{y(limit) - 4:.1f}', font_size=12, fill=RED)]
    for at, value, spread in zip(history.days, values, wide):
        parts += [element('line', x1=f'{x(at):.1f}', x2=f'{x(at):.1f}',
                          y1=f'{y(value - spread):.1f}', y2=f'{y(value + spread):.1f}',
                          stroke=SOFT),
                  element('circle', cx=f'{x(at):.1f}', cy=f'{y(value):.1f}', r=3.2, fill=BLUE)]
    return element('svg', *parts, viewBox=f'0 0 {_WIDTH} {_HEIGHT}', role='img',
                   style='width: 100%; height: auto; max-width: 34rem',
                   aria_label=f'{label}. {until(entry)}')


def _display(unit: str) -> tuple[float, str]:
    """Return the factor to what people read, and its unit."""
    if unit == '1':
        return 100.0, '%'
    return for_people(1.0, unit)


def _points(ring: list[tuple[float, float]], x: Callable[[float], float],
            y: Callable[[float], float]) -> str:
    return ' '.join(f'{x(at):.1f},{y(value):.1f}' for at, value in ring)


def _axes(x: Callable[[float], float], y: Callable[[float], float], low: float, high: float,
          first: float, end: float, unit: str):
    for value in _ticks(low, high):
        yield element('line', x1=_LEFT, x2=_WIDTH - _RIGHT, y1=f'{y(value):.1f}',
                      y2=f'{y(value):.1f}', stroke='#8c959f' if value == 0.0 else '#e7ebef')
        yield element('text', f'{value:.4g}', x=_LEFT - 6, y=f'{y(value) + 4:.1f}', font_size=11,
                      text_anchor='end', fill=SOFT)
    yield element('text', unit, x=_LEFT, y=_TOP - 8, font_size=12, fill=INK)
    for at, text in _days(first, end):
        yield element('line', x1=f'{x(at):.1f}', x2=f'{x(at):.1f}', y1=_HEIGHT - _BOTTOM,
                      y2=_HEIGHT - _BOTTOM + 4, stroke='#8c959f')
        yield element('text', text, x=f'{x(at):.1f}', y=_HEIGHT - _BOTTOM + 17, font_size=11,
                      text_anchor='middle', fill=SOFT)


def _ticks(low: float, high: float) -> list[float]:
    rough = (high - low) / 4.0
    step = 10.0**math.floor(math.log10(rough))
    step *= next(factor for factor in (1.0, 2.0, 5.0, 10.0) if factor * step >= rough)
    first = math.ceil(low / step)
    return [place * step for place in range(first, math.floor(high / step) + 1)]


def _days(first: float, end: float) -> list[tuple[float, str]]:
    """Return the days to write at the axis: days of a month, months or years."""
    if end - first < 120.0:
        return [(at, day(at)[5:]) for at in np.linspace(first, end, _LABELS)[:-1]]
    months = next((step for step in (1, 3, 6, 12, 24, 60, 120)
                   if (end - first) / 30.4 / step <= _LABELS), 240)
    begin, last = date.fromordinal(round(first)), date.fromordinal(round(end))
    found = []
    for number in range(begin.year * 12, last.year * 12 + 12, months):
        at = date(number // 12, number % 12 + 1, 1)
        if begin <= at <= last:
            found.append((float(at.toordinal()),
                          f'{at:%Y}' if months >= 12 else f'{at:%Y-%m}'))
    return found
