# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the answers say together: which machine lacks what, what grows, and who is unlike the others.

A trend is Theil's and Sen's median slope with its 95 % interval (P. K. Sen, Estimates of the
regression coefficient based on Kendall's tau, JASA 63, 1968); an outlier has a robust z beyond
3.5 (B. Iglewicz, D. Hoaglin, How to detect and handle outliers, ASQC 1993).
"""
from __future__ import annotations

from collections import Counter
from datetime import date
from typing import NamedTuple, Sequence

import numpy as np

_FEWEST_DATES = 4
_FEWEST_MACHINES = 5
_FAR = 3.5
_YEAR = 365.25      # days


class Machine(NamedTuple):
    """A machine: how many campaigns, verdicts, and in how many each effect was found."""

    name: str
    campaigns: int
    failed: int
    verdicts: dict[str, int]
    effects: dict[str, int]


class Point(NamedTuple):
    """The size of an effect in a campaign, SI, with its interval."""

    campaign: str
    machine: str
    date: str
    effect: str
    parameter: str
    unit: str
    value: float
    low: float
    high: float


class Trend(NamedTuple):
    """
    How the size of an effect changes on a machine, SI per year, with a 95 % interval.

    ``direction`` is 'grows', 'falls' or 'steady' (the interval holds zero); ``points`` are in
    the order of time.
    """

    machine: str
    effect: str
    parameter: str
    unit: str
    slope: float
    low: float
    high: float
    direction: str
    points: tuple[Point, ...]


class Outlier(NamedTuple):
    """A campaign whose effect is unlike in size to that of the other machines."""

    point: Point
    median: float
    z: float


class Summary(NamedTuple):
    """All of it."""

    machines: list[Machine]
    trends: list[Trend]
    outliers: list[Outlier]
    failures: list[tuple[str, str]]


def summarise(rows: Sequence[dict]) -> Summary:
    """Put rows together (``task.row_of``)."""
    points = [point for row in rows for point in points_of(row)]
    return Summary(_machines(rows), trends(points), outliers(points),
                   [(row['campaign'], row['reason']) for row in rows
                    if row['status'] == 'failed'])


def points_of(row: dict) -> list[Point]:
    """Return the sizes that a row holds; of an effect with several parameters the first."""
    found = []
    for effect in (row.get('diagnosis') or {}).get('effects') or []:
        name, value = next(iter(effect['parameters'].items()))
        found.append(Point(
            row['campaign'], row['machine'], row['date'] or '', effect['id'], name,
            value['unit'], *(float(value[key]) for key in ('value', 'low', 'high'))))
    return found


def _machines(rows: Sequence[dict]) -> list[Machine]:
    found = []
    for name in sorted({row['machine'] for row in rows}):
        own = [row for row in rows if row['machine'] == name]
        done = [row['diagnosis'] for row in own if row['status'] == 'done']
        found.append(Machine(
            name, len(own), len(own) - len(done),
            dict(Counter(entry['verdict'] for entry in done)),
            dict(Counter(effect['id'] for entry in done for effect in entry['effects']))))
    return found


def _grouped(points: Sequence[Point], keys) -> dict[tuple, list[Point]]:
    groups: dict[tuple, list[Point]] = {}
    for point in points:
        groups.setdefault(keys(point), []).append(point)
    return groups


def trends(points: Sequence[Point]) -> list[Trend]:
    """Return how sizes change where a machine has at least four campaigns of different dates."""
    from scipy.stats import theilslopes

    found = []
    groups = _grouped([point for point in points if point.date],
                      lambda point: (point.machine, point.effect, point.parameter, point.unit))
    for key, group in sorted(groups.items()):
        group = sorted(group, key=lambda point: point.date)
        days = np.array([date.fromisoformat(point.date).toordinal() for point in group], float)
        if len(set(days)) < _FEWEST_DATES:
            continue
        slope, _, low, high = theilslopes([point.value for point in group],
                                          (days - days[0]) / _YEAR)
        direction = 'grows' if low > 0 else 'falls' if high < 0 else 'steady'
        found.append(Trend(*key, float(slope), float(low), float(high), direction, tuple(group)))
    return found


def outliers(points: Sequence[Point]) -> list[Outlier]:
    """
    Return campaigns whose effect is unlike that of the other machines that have it.

    The scale is the median deviation, but no less than the sizes are sure.
    """
    found = []
    for group in _grouped(points, lambda point: (point.effect, point.parameter)).values():
        if len({point.machine for point in group}) < _FEWEST_MACHINES:
            continue
        # A machine counts once, however often it was measured.
        each = [np.median([point.value for point in own])
                for own in _grouped(group, lambda point: point.machine).values()]
        middle = float(np.median(each))
        sure = np.median([(point.high - point.low) / 3.92 for point in group])
        scale = max(float(np.median(np.abs(np.array(each) - middle))) / 0.6745, float(sure))
        if scale > 0:
            found += [Outlier(point, middle, (point.value - middle) / scale) for point in group
                      if abs(point.value - middle) > _FAR * scale]
    return sorted(found, key=lambda entry: -abs(entry.z))
