# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Sudden changes of a machine, in the words of who maintains it."""
from __future__ import annotations

from typing import NamedTuple, Sequence, TYPE_CHECKING

from hst_drive.effects import effect_of
from hst_drive.fleet.track import leaks, OIL, one_way

if TYPE_CHECKING:
    from hst_drive.fleet.jumps import Jump
    from hst_drive.fleet.summary import Followed

_BACK = 0.5     # of a size, that a repair leaves at most


class Event(NamedTuple):
    """A sudden change between two days (ordinals): what it looks like, and of which effects."""

    after: float
    before: float
    what: str
    effects: tuple[str, ...]


def events(followed: Sequence[Followed]) -> list[Event]:
    """Return the events of a machine in the order of time; what changed at once is one."""
    jumps = sorted(((jump, entry) for entry in followed for jump in entry.growth.jumps),
                   key=lambda pair: pair[0])
    groups: list[list[tuple[Jump, Followed]]] = []
    for pair in jumps:
        last = groups[-1] if groups else []
        if last and pair[0].after < min(jump.before for jump, _ in last):
            last.append(pair)
        else:
            groups.append([pair])
    return [_event(group) for group in groups]


def _event(group: Sequence[tuple[Jump, Followed]]) -> Event:
    after = max(jump.after for jump, _ in group)
    before = min(jump.before for jump, _ in group)
    effects = tuple(entry.effect for _, entry in group)
    oil = [jump for jump, entry in group if entry.effect == OIL]
    if oil:
        softer = oil[0].last < oil[0].first
        what = f'oil changed: {"softer" if softer else "stiffer"} than before' + (
            '; or air in it' if softer else '')
        if any(leaks(name) for name in effects):
            what += ', and the leakage jumped with it (another viscosity)'
        return Event(after, before, what, effects)
    return Event(after, before, '; '.join(dict.fromkeys(
        _said(jump, entry.effect) for jump, entry in group)), effects)


def _said(jump: Jump, effect: str) -> str:
    entry = effect_of(effect)
    # Against what a machine was, a size that none has of less than none may be just that.
    sign = 1.0 if one_way(effect) else max(jump.first, jump.last, key=abs)
    back = sign * jump.last < sign * _BACK * jump.first
    if entry.enters == 'sensor':
        return f'{effect} {"gone" if back else "jumped"}: sensor replaced or set anew'
    if back:
        return f'{effect} fell back: repaired, or a part replaced'
    if sign * jump.last < sign * jump.first:
        return f'{effect} fell at once: repaired in part, or other oil'
    return f'{effect} jumped: damage, ' + (
        'or thinner oil' if leaks(effect) else 'or a part replaced')
