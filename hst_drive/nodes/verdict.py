# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the estimator says of the watch: on /diagnostics for people, on a topic for machines."""
from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
import shlex
from typing import Any, TYPE_CHECKING

from hst_drive.effects import catalogue
from hst_drive.nodes.endpoints import BILLION
from hst_drive.units import for_people

if TYPE_CHECKING:
    from hst_drive.model.circuits import Balance
    from hst_drive.watch.naming import Likely
    from hst_drive.watch.watch import Verdict

UNKNOWN = 'unknown'
"""Named where a balance fails and no effect of the catalogue explains it."""
RATE = '.rate'
"""Behind the name of an effect: the entry with its growth."""
_HOUR = 3600.0      # s


def named(stamp: int, verdict: Verdict) -> dict[str, list]:
    """
    Return the arrays of the message: names, sizes (SI), shares explained, seconds since.

    A JointState is the one stamped standard message with numbers by name; programs that read
    joints, and our channel map, pick an effect as they pick a joint. Behind all effects come
    their rates: growth in SI a second, and its 95 % interval. ``stamp`` (ns) is the end of the
    block that the watch judged last.
    """
    found = [(entry.effect, entry.size, entry.explains) for entry in verdict.effects]
    if verdict.failing and not found:
        found = [(UNKNOWN, 0.0, 0.0)]
    names, sizes, shares = (list(column) for column in zip(*found)) if found else ([], [], [])
    since = [(stamp - verdict.began) / BILLION] * len(names)
    for entry in verdict.effects:
        if entry.rate:
            for column, value in zip((names, sizes, shares, since),
                                     (f'{entry.effect}{RATE}', *entry.rate)):
                column.append(value)
    return {'name': names, 'position': sizes, 'velocity': shares, 'effort': since}


def _effect(entry: Likely) -> str:
    size, unit = for_people(entry.size, _unit(entry))
    return f'{entry.effect} ({entry.parameter} about {size:.3g} {unit})'


def _trend(entry: Likely) -> str:
    """Return the growth of an effect in an hour; '' where it is not known."""
    if not entry.rate:
        return ''
    (rate, unit), (low, _), (high, _) = (
        for_people(_HOUR * value, _unit(entry)) for value in entry.rate)
    told = 'grows' if low * entry.size > 0.0 and high * entry.size > 0.0 else \
        'shrinks' if low * entry.size < 0.0 and high * entry.size < 0.0 else 'no trend'
    return f'{entry.effect} {told}: {rate:+.3g} {unit} an hour ({low:.3g} to {high:.3g})'


def _unit(entry: Likely) -> str:
    return next(parameter.unit for parameter in catalogue()[entry.effect].parameters
                if parameter.name == entry.parameter)


def to_diagnose(settings: Mapping[str, Any]) -> str:
    """Return the command that diagnoses the bag of a node with these parameters."""
    return ' '.join(['hst-drive diagnose', shlex.quote(settings['bag'] or 'BAG'), *(
        f'--{key} {shlex.quote(settings[key])}' for key in ('rig', 'channels') if settings[key])])


def alarm(verdict: Verdict, origin: int, command: str, unseen: Sequence[str],
          watched: Mapping[str, Balance]) -> tuple[str, dict[str, str]]:
    """
    Return message and values of the status for a balance that fails.

    Parameters
    ----------
    verdict : Verdict
        With at least one balance that fails.
    origin : int
        Stamp of the first sample, ns; times are given from there as well.
    command : str
        That diagnoses the bag which is being recorded.
    unseen : sequence of str
        Effects that this watch cannot see.
    watched : mapping of str to Balance
        By id.

    """
    worst = verdict.failing[0]
    title, unit = watched[worst].name, watched[worst].unit
    innovation = verdict.innovations.get(worst)
    began = (verdict.began - origin) / BILLION
    size = ''
    if innovation is not None:
        value, shown = for_people(innovation.value, unit)
        size = f', now {value:+.3g} {shown}'
    names = [entry.effect for entry in verdict.effects]
    guess = f'; most likely {" or ".join(names)}' if names else '; no effect that shows here'
    values = {
        'balances': ', '.join(watched[name].name for name in verdict.failing),
        'effects': ', '.join(_effect(entry) for entry in verdict.effects) or 'unknown',
        'trend': ', '.join(filter(None, map(_trend, verdict.effects))) or 'not known yet',
        'explained': ', '.join(f'{100 * entry.explains:.0f} %' for entry in verdict.effects),
        'failing_since_s': f'{began:.1f}',
        'section_from': _stamp(verdict.since), 'section_to': _stamp(verdict.until),
        'section_s': f'{(verdict.since - origin) / BILLION:.1f} to '
                     f'{(verdict.until - origin) / BILLION:.1f} s of the run',
        'diagnose': command,
        'not_watched': ', '.join(unseen)}
    lasting = (verdict.until - verdict.began) / BILLION
    return (f'{title} fails since {began:.0f} s of the run, for {lasting:.0f} s{size}{guess}',
            values)


def _stamp(stamp: int) -> str:
    seconds, nanoseconds = divmod(stamp, BILLION)
    return f'{seconds}.{nanoseconds:09d}'


def fine(levels: Mapping[str, float], judged: Iterable[str], seconds: float,
         watched: Mapping[str, Balance]) -> dict[str, str]:
    """Return the values of the status while nothing fails."""
    return {'watched': ', '.join(watched[name].name for name in judged),
            'watched_for_s': f'{seconds:.0f}',
            **{f'evidence {watched[name].name}': f'{level:.2f}' for name, level in levels.items()}}
