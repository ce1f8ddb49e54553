# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A fleet in sentences: for the page, the terminal and whoever reads the JSON."""
from __future__ import annotations

from collections import Counter
from datetime import date
import math
from typing import Sequence

from hst_drive.effects import effect_of
from hst_drive.fleet.summary import (
    AHEAD, Followed, GROWS, Machine, REACHED, SOUND, STATES, Summary)
from hst_drive.fleet.track import OIL
from hst_drive.units import for_people

_FAR = 10.0         # years: what is further away is not told as a date
_YEAR = 365.25      # days
_MOST = 5           # names in the sentence


def day(ordinal: float) -> str:
    """Return a day as people write it."""
    return date.fromordinal(round(ordinal)).isoformat()


def title(effect: str) -> str:
    """Return what an effect is, for people."""
    if effect == OIL:
        return 'stiffness of the oil against then'
    return effect_of(effect).title


def amount(value: float, unit: str) -> str:
    """Return a size as people read it."""
    if unit == '1':
        return f'{100.0 * value:.3g} %'
    shown, unit = for_people(value, unit)
    return f'{shown:.3g} {unit}'


def size(entry: Followed) -> str:
    """Return the size now with its interval."""
    return _with_interval(entry.growth.level, entry.unit)


def rate(entry: Followed) -> str:
    """Return the growth a year with its interval."""
    return _with_interval([_YEAR * value for value in entry.growth.rate], entry.unit) + ' a year'


def _moves(entry: Followed) -> str:
    now = ', now' * (entry.growth.kind == 'accelerates')
    return f'{entry.growth.kind}{now} by {rate(entry)}'


def _with_interval(values: Sequence[float], unit: str) -> str:
    low, (middle, _, shown), high = (amount(value, unit).partition(' ') for value in values)
    return f'{middle} ({low[0]} to {high[0]}) {shown}'


def since(entry: Followed) -> str:
    """Return from when it grows."""
    growth = entry.growth
    if growth.since is None:
        return ''
    first = growth.history.days[0]
    return f'since {day(growth.since)}' if growth.since > first + 1.0 else \
        f'since {day(first)} (the first log) or before'


def trend(entry: Followed) -> str:
    """Say how it goes."""
    growth = entry.growth
    if growth.kind == 'too few dates':
        count = len(growth.history.days)
        return f'too few dates to say whether it grows ({count}; three at least)'
    if growth.kind == 'steady':
        told = 'steady' if entry.there else 'not there now'
    elif growth.kind == 'not clear':
        told = 'not clear whether it grows: more dates will tell'
    else:
        told = f'{_moves(entry)} {since(entry)}'
    return told + ('; goes with the oil temperature' if growth.season > 0.5 else '')


def until(entry: Followed) -> str:
    """Say when the limit is reached; empty without a limit, or with too few dates to say."""
    when = due(entry)
    if not when:
        return ''
    far_off = ' as it goes now' if when.startswith('not within') else ''
    return f'limit of {amount(entry.limit or 0.0, entry.unit)}: {when}{far_off}'


def due(entry: Followed) -> str:
    """Return when the limit is reached, with its interval, as a manager notes it down."""
    if entry.remaining is None:
        return ''
    low, middle, high, reached = entry.remaining
    end = entry.growth.now + _FAR * _YEAR
    if reached > 0.5:
        return 'reached already'
    if low > end:
        return f'not within {_FAR:g} years'
    if entry.due > end:
        return f'not before {day(low)}'
    if high > end:
        return f'about {day(middle)} (not before {day(low)}; perhaps much later)'
    return f'about {day(middle)} ({day(low)} to {day(high)})'


def goes(entry: Followed) -> str:
    """Say what a size does, and how fast it grows now."""
    if entry.grows:
        return _moves(entry)
    return {'not clear': 'growth not clear', 'too few dates': 'too few dates to say'}.get(
        entry.growth.kind, entry.growth.kind)


def of_machine(machine: Machine) -> list[str]:
    """Return what is to be said of a machine, the most urgent first."""
    told = []
    for entry in machine.followed:
        if entry.effect == OIL and not entry.grows and math.isinf(entry.due):
            continue
        if entry.there or entry.growth.kind != 'steady':
            told.append(f'{entry.effect} ({title(entry.effect)}): now {size(entry)}; '
                        f'{trend(entry)}.' + (f' Its {until(entry)}.' if until(entry) else ''))
    told += [f'Between {day(event.after)} and {day(event.before)}: {event.what}.' + (
        ' Commission the machine anew for this oil.' if OIL in event.effects else '')
        for event in machine.events]
    if not told:
        told.append('Nothing found: what each campaign says stands at the end.'
                    if machine.state == SOUND else
                    machine.sentence or 'No campaign of it could be judged.')
    return told


def sentence(summary: Summary) -> str:
    """Say the most important of a fleet."""
    count = Counter(machine.state for machine in summary.machines)
    parts = [f'{count[state]} {state}' for state in STATES if count[state]]
    text = f'{many(len(summary.machines), "machine")}: {", ".join(parts)}.'
    for machine in summary.machines:
        if machine.state in (REACHED, AHEAD, GROWS) and machine.followed:
            entry = machine.followed[0]
            why = goes(entry) if machine.state == GROWS else until(entry)
            text += f' First to see to: {machine.name} ({entry.effect}, {why}).'
            break
    if summary.outliers:
        text += ' Unlike the others: ' + ', '.join(dict.fromkeys(
            entry.point.machine for entry in summary.outliers[:_MOST])) + '.'
    if summary.failures:
        text += f' {many(len(summary.failures), "campaign")} could not be judged.'
    if summary.undated:
        more = ' and more' if len(summary.undated) > _MOST else ''
        text += (f' {many(len(summary.undated), "campaign")} in no trend, without a date '
                 '(YYYY-MM-DD) in the name of the folder or of a log: '
                 f'{", ".join(summary.undated[:_MOST])}{more}.')
    return text


def many(count: int, what: str) -> str:
    """Return so many of something in words."""
    return f'{count} {what}{"" if count == 1 else "s"}'


def far(ordinal: float, now: float) -> bool:
    """Tell whether a day is too far away to be told as a date."""
    return not math.isfinite(ordinal) or ordinal > now + _FAR * _YEAR
