# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the answers say together: machine by machine what grows, since when and until when.

An outlier has a robust z beyond 3.5 (B. Iglewicz, D. Hoaglin, How to detect and handle outliers,
ASQC 1993).
"""
from __future__ import annotations

from collections import Counter
from datetime import date
import math
from typing import NamedTuple, Sequence

from hst_drive.fleet.events import Event, events
from hst_drive.fleet.growth import Growth, History, Remaining
from hst_drive.fleet.life import Lives
from hst_drive.fleet.limits import Limits
from hst_drive.fleet.track import OIL, one_way, POWERS
from hst_drive.identify.intervals import FORM
import numpy as np
from scipy.special import softmax

_FEWEST_MACHINES = 5
_FAR = 3.5
_SURE = 1.96
GROWING = ('grows', 'accelerates')
# States of a machine, the most urgent first.
REACHED, AHEAD, GROWS, ODD, THERE, SOUND, UNTOLD = (
    'limit reached', 'limit ahead', 'grows', 'not explained', 'fault', 'nothing found',
    'not judged')
STATES = (REACHED, AHEAD, GROWS, ODD, THERE, SOUND, UNTOLD)


class Followed(NamedTuple):
    """
    The size of an effect on one machine over its life, less what is neutral, SI.

    ``limit`` and ``remaining`` (days as ordinals) are None where no limit was given or too little
    is known.
    """

    effect: str
    parameter: str
    unit: str
    history: History
    growth: Growth
    limit: float | None
    remaining: Remaining | None

    @property
    def there(self) -> bool:
        """Whether its size differs from none on the last day."""
        low, _, high = self.growth.level
        return low > 0.0 or high < 0.0 and not one_way(self.effect)

    @property
    def grows(self) -> bool:
        """Whether it is there and grows."""
        return self.there and self.growth.kind in GROWING

    @property
    def due(self) -> float:
        """Day on which the limit is reached; infinite without one, or if growth is not clear."""
        return self.remaining.middle if self.remaining and (
            self.growth.kind != 'not clear' or self.remaining.reached > 0.5) else math.inf


class Machine(NamedTuple):
    """
    A machine: state, what is followed (the most urgent first), events, campaigns.

    ``unit`` is the file that it is judged by, or why it has none of its own; ``effects`` are the
    numbers of campaigns in which each effect was named, ``named`` those of the last one.
    """

    name: str
    state: str
    unit: str
    campaigns: int
    failed: int
    verdicts: dict[str, int]
    effects: dict[str, int]
    followed: tuple[Followed, ...]
    events: tuple[Event, ...]
    last: str
    sentence: str
    named: tuple[str, ...]


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


class Outlier(NamedTuple):
    """A machine whose effect is unlike in size to that of the others, by its last campaign."""

    point: Point
    median: float
    z: float


class Summary(NamedTuple):
    """All of it, the most urgent machine first."""

    machines: list[Machine]
    outliers: list[Outlier]
    failures: list[tuple[str, str]]
    undated: list[str]


def summarise(lives: Lives, limits: Limits | None = None) -> Summary:
    """Put together what is known of a fleet; ``limits`` by effect and parameter, SI."""
    machines = [_machine(name, lives, limits or {})
                for name in sorted({row['machine'] for row in lives.rows})]
    return Summary(sorted(machines, key=_urgency), outliers(lives.rows),
                   [(row['campaign'], row['reason']) for row in lives.rows
                    if row['status'] == 'failed'],
                   [row['campaign'] for row in lives.rows if not row['date']])


def points_of(row: dict) -> list[Point]:
    """Return the sizes that a row holds; of an effect with several parameters the first."""
    found = []
    for effect in (row.get('diagnosis') or {}).get('effects') or []:
        name, value = next(iter(effect['parameters'].items()))
        found.append(Point(
            row['campaign'], row['machine'], row['date'] or '', effect['id'], name,
            value['unit'], *(float(value[key]) for key in ('value', 'low', 'high'))))
    return found


def day_of(text: str) -> float:
    """Return the ordinal of a day as 'YYYY-MM-DD'."""
    return float(date.fromisoformat(text).toordinal())


def _machine(name: str, lives: Lives, limits: Limits) -> Machine:
    own = sorted((row for row in lives.rows if row['machine'] == name),
                 key=lambda row: (row['date'] or '', row['campaign']))
    judged = [row for row in own if row['diagnosis']]
    done = [row['diagnosis'] for row in judged]
    entries = sorted(_followed([row for row in lives.sizes if row['machine'] == name], limits),
                     key=_urgency_of)
    state = _state(entries, done[-1] if done else None)
    return Machine(
        name, state, lives.units.get(name, ''), len(own),
        sum(row['status'] == 'failed' for row in own),
        dict(Counter(entry['verdict'] for entry in done)),
        dict(Counter(effect['id'] for entry in done for effect in entry['effects'])),
        tuple(entries), tuple(events(entries)), (judged or own)[-1]['date'] or '',
        done[-1]['sentence'] if done else own[-1]['reason'] or '',
        tuple(effect['id'] for effect in done[-1]['effects']) if done else ())


def _state(entries: Sequence[Followed], last: dict | None) -> str:
    if any(entry.remaining and entry.remaining.reached > 0.5 for entry in entries):
        return REACHED
    if any(math.isfinite(entry.due) for entry in entries):
        return AHEAD
    if any(entry.grows for entry in entries):
        return GROWS
    if last is None:
        return UNTOLD
    if last['verdict'] == 'unknown':
        return ODD
    return THERE if last['effects'] else SOUND


def _followed(rows: Sequence[dict], limits: Limits) -> list[Followed]:
    found = []
    for effect in dict.fromkeys(name for row in rows for name in row['sizes']):
        # Of campaigns on one day the last counts.
        days = {day_of(row['date']): row for row in rows if effect in row['sizes']}
        own = [days[day] for day in sorted(days)]
        sizes = [row['sizes'][effect] for row in own]
        history = _history(sorted(days), sizes, own)
        growth = Growth(history, 0.0 if effect == OIL else FORM, one_way(effect))
        parameter = str(sizes[0]['parameter'])
        limit = limits.get((effect, parameter))
        found.append(Followed(effect, parameter, str(sizes[0]['unit']), history, growth, limit,
                              None if limit is None else growth.remaining(limit)))
    return found


def _history(days: Sequence[float], sizes: Sequence[dict], rows: Sequence[dict]) -> History:
    """Return the sizes that were measured, of a leak those in oil as it usually is."""
    values, sigmas, offsets = (np.array([size.get(key, 0.0) for size in sizes])
                               for key in ('value', 'sigma', 'offset'))
    warm = [row['oil_temperature'] for row in rows]
    if not all('by_power' in size for size in sizes):
        return History(np.array(days), values, sigmas,
                       np.empty(0) if None in warm else np.array(warm),
                       offset=float(np.median(offsets)))
    thin = -np.log([row['viscosity'] for row in rows])
    thin -= np.median(thin)
    power, sigma = _power(rows)
    usual = np.exp(-power * thin)
    bend, slope, level = np.polyfit(POWERS, np.exp(-np.outer(POWERS, thin)) * np.array(
        [size['by_power'] for size in sizes]).T, 2)
    return History(
        np.array(days), (bend * power + slope) * power + level, usual * sigmas,
        thinner=(2.0 * bend * power + slope) * sigma,
        offset=float(np.median(usual * offsets)))


def _power(rows: Sequence[dict]) -> tuple[float, float]:
    """
    Return the power of the viscosity that a machine's leakages follow, and one sigma of it.

    Any between those of orifices and of laminar gaps is as plausible, but for what the logs of
    all dates tell, and those that it was commissioned on: their oil warms up.
    """
    misfits = np.polyfit(POWERS, np.sum([row['misfits'] for row in rows], axis=0), 2)
    powers = np.linspace(POWERS[0], POWERS[-1], 101)
    known, sigma = rows[-1].get('law') or (0.0, np.inf)
    chances = softmax(-0.5 * (np.polyval(misfits, powers) + ((powers - known) / sigma)**2))
    power = float(chances @ powers)
    return power, float(np.sqrt(chances @ (powers - power)**2))


def _urgency_of(entry: Followed) -> tuple:
    return entry.due, not entry.grows, not entry.there, entry.effect


def _urgency(machine: Machine) -> tuple:
    first = min((_urgency_of(entry)[:2] for entry in machine.followed), default=(math.inf, True))
    return STATES.index(machine.state), first, machine.name


def outliers(rows: Sequence[dict]) -> list[Outlier]:
    """
    Return machines whose effect is unlike that of the others that have it, each by its last size.

    The scale is the median deviation, but no less than the sizes are sure.
    """
    last = {row['machine']: row for row in sorted(
        (row for row in rows if row['diagnosis']),
        key=lambda row: (row['date'] or '', row['campaign']))}
    groups: dict[tuple[str, str], list[Point]] = {}
    for row in last.values():
        for point in points_of(row):
            groups.setdefault((point.effect, point.parameter), []).append(point)
    found = []
    for group in groups.values():
        if len(group) < _FEWEST_MACHINES:
            continue
        each = np.array([point.value for point in group])
        middle = float(np.median(each))
        sure = np.median([(point.high - point.low) / (2 * _SURE) for point in group])
        scale = max(float(np.median(np.abs(each - middle))) / 0.6745, float(sure))
        if scale > 0:
            found += [Outlier(point, middle, (point.value - middle) / scale) for point in group
                      if abs(point.value - middle) > _FAR * scale]
    return sorted(found, key=lambda entry: -abs(entry.z))
