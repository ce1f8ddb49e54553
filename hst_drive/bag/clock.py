# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A clock that was set back while a bag was recorded.

The stamps then run over the same stretch twice, and sorting would mix what was hours or
milliseconds apart. The order in which the messages were written shows where it happened.
"""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

import numpy as np

_WINDOW = 10        # messages on either side of a step
_LEAST = 1.5        # periods; less is jitter
_MOST = 5           # steps; more are messages that came out of order, or two sources
_TRIED = 100        # bursts of late messages to look into
_COVERED = 0.5      # of the messages after a step there must be earlier ones at the same stamps


class Written(NamedTuple):
    """The messages of a topic as written: name, places in the whole bag, and stamps (ns)."""

    name: str
    order: np.ndarray
    stamps: np.ndarray


class Stamped(Protocol):
    """What ``Written`` has; it may be read anew each time that it is asked for."""

    name: str
    order: np.ndarray
    stamps: np.ndarray


class Step(NamedTuple):
    """The clock lost ``lost`` (ns) before the message at place ``order`` of the bag."""

    order: int
    lost: int


def set_forward_again(topics: Sequence[Stamped], notes: list[str]
                      ) -> Iterator[tuple[int, np.ndarray]]:
    """
    Yield the stamps of each topic on a clock that goes on where it was set back.

    Each comes with the topic's number, one after the other: all may be too many for the memory.
    """
    if not topics:
        return
    place = max(range(len(topics)), key=lambda index: len(topics[index].stamps))
    steps: list[tuple[Step, Around]] = []
    for number in (place, *(index for index in range(len(topics)) if index != place)):
        topic = Written(topics[number].name, topics[number].order, topics[number].stamps)
        for step, around in steps:
            topic = topic._replace(stamps=_moved(topic, step, around))
        for step in steps_back(topic):
            around = Around.of(topic, step)
            topic = topic._replace(stamps=_moved(topic, step, around))
            # A sensor may have a clock of its own.
            notes.append(_told('the clock' if number == place else f'{topic.name}: its clock',
                               step, topic))
            if number == place:
                steps.append((step, around))
        yield number, topic.stamps


def _told(what: str, step: Step, topic: Written) -> str:
    after = topic.stamps[np.searchsorted(topic.order, step.order)] - topic.stamps[0]
    return (f'{what} was set back by {step.lost / 1e9:.3g} s after {after / 1e9:.4g} s; what was '
            'written later is put behind what was written before')


def steps_back(topic: Written) -> list[Step]:
    """
    Return where the clock was set back.

    A message that came late is followed by messages at the old pace, and a burst of late ones
    fills a hole that they had left; after a step all go on at the usual pace from an
    earlier time, one that there have been messages of before.
    """
    gaps = np.diff(topic.stamps)
    if len(gaps) < 2 * _WINDOW or (gaps >= 0).all():
        return []
    times = topic.stamps.copy()
    period = float(np.median(np.abs(gaps)))
    found: list[Step] = []
    tried = 0
    for place in np.flatnonzero(gaps < -0.5 * period):
        before = times[max(place + 1 - _WINDOW, 0):place + 1]
        after = times[place + 1:place + 1 + _WINDOW]
        if min(len(before), len(after)) < _WINDOW // 2:
            continue
        due = before[0] + period * len(before) + np.median(
            before - before[0] - period * np.arange(len(before)))
        came = after[0] + np.median(after - after[0] - period * np.arange(len(after)))
        lost = round(due - came)
        if lost < _LEAST * period:
            continue
        tried += 1
        if tried > _TRIED or len(found) > _MOST:
            return []
        if _again(times[:place + 1], after, period):
            found.append(Step(int(topic.order[place + 1]), lost))
            times[place + 1:] += lost
    return found if len(found) <= _MOST else []


def _again(earlier: np.ndarray, after: np.ndarray, period: float) -> bool:
    """Tell whether stamps lie where there were some before, or before all of them."""
    after = after[after <= earlier.max()]
    near = np.abs(earlier[:, None] - after[None, :]).min(axis=0) <= period
    return float(np.mean(near | (after < earlier.min()))) > _COVERED


class Around(NamedTuple):
    """Places in the bag close to a step, and what the time was there on the clock that goes on."""

    order: np.ndarray
    true: np.ndarray

    @classmethod
    def of(cls, topic: Written, step: Step) -> Around:
        """Return what a topic says of the time around a step."""
        first = int(np.searchsorted(topic.order, step.order))
        near = slice(max(first - _WINDOW, 0), first + _WINDOW)
        order = topic.order[near]
        return cls(order, topic.stamps[near] + np.where(order >= step.order, step.lost, 0))


def _moved(topic: Written, step: Step, around: Around) -> np.ndarray:
    """Return the stamps of a topic with those after a step set forward."""
    after = topic.order >= step.order
    # What was stamped before the step may have been written after it, and the other way round:
    # close to it the clock that fits the base's time counts.
    order, true = around
    close = (topic.order >= order[0]) & (topic.order <= order[-1])
    meant = np.interp(topic.order[close], order, true - true[0]) + true[0]
    off = topic.stamps[close] - meant
    after[close] = np.abs(off + step.lost) < np.abs(off)
    return topic.stamps + np.where(after, step.lost, 0)
