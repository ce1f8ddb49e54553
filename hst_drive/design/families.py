# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Families of tests: what speed and load do over time, with parameters drawn from a seed."""
from __future__ import annotations

from typing import Any, Callable, NamedTuple

import numpy as np

STEP = 0.02             # s: shortest ramp, so that times rise
_SOFT = 0.8             # s: a ramp that the pump's control and the line follow

Knots = list[tuple[float, float]]


class Pen:
    """Draws speed and load over time: goes to a value and stays there."""

    def __init__(self, brake: float):
        self.time, self.brake = 0.0, brake
        self.speed: Knots = []
        self.load: Knots = []

    def go(self, speed: float, load: float, stay: float, ramp: float = STEP) -> None:
        """Go to speed and load within ``ramp`` (s) or more; stay until ``stay`` are over."""
        fall = self.speed[-1][1] - speed
        ramp = max(ramp, fall / self.brake)
        for knots, value in ((self.speed, speed), (self.load, load)):
            knots.append((self.time + ramp, value))
            knots.append((self.time + max(stay, ramp + STEP), value))
        self.time += max(stay, ramp + STEP) + STEP


def _spread(random: np.random.Generator, low: float, high: float, count: int) -> np.ndarray:
    """Return values over a range, one in each of its equal parts, in random order."""
    places = (np.arange(count) + random.uniform(0.0, 1.0, count)) / count
    return low + (high - low) * random.permutation(places)


def _load_steps(pen, random, bounds, duration):
    speeds = _spread(random, bounds.slow, bounds.fast, int(random.integers(2, 6)))
    for speed in speeds:
        count = max(int(duration / len(speeds) / random.uniform(1.5, 4.0)), 1)
        for load in _spread(random, bounds.light, bounds.heavy, count):
            pen.go(speed, load, duration / len(speeds) / count, 0.05)


def _speed_ramps(pen, random, bounds, duration):
    count = int(random.integers(1, 4))
    for load in _spread(random, bounds.light, bounds.heavy, count):
        for speed in (bounds.slow, bounds.fast):
            pen.go(speed, load, duration / count / 2, duration / count / 2 - 0.1)


def _load_ramps(pen, random, bounds, duration):
    count = int(random.integers(1, 4))
    for speed in _spread(random, bounds.slow, bounds.fast, count):
        for load in (bounds.heavy, bounds.light):
            pen.go(speed, load, duration / count / 2, duration / count / 2 - 0.1)


def _reversals(pen, random, bounds, duration):
    centres = _spread(random, 0.25 * bounds.fast, 0.85 * bounds.fast, 2)
    loads = _spread(random, bounds.light, 0.6 * bounds.heavy, 2)
    end = pen.time + duration
    for part, (centre, load) in enumerate(zip(centres, loads)):
        swing = random.uniform(0.02, 0.15) * bounds.fast
        period = random.uniform(0.5, 4.0)
        ramp = period * random.choice([0.05, 0.45])
        while pen.time < end - duration * (1 - part) / 2 - period:
            pen.go(centre + swing, load, period / 2, ramp)
            pen.go(centre - swing, load, period / 2, ramp)


def _fast_steps(pen, random, bounds, duration):
    end = pen.time + duration
    while pen.time < end - 0.5:
        pen.go(random.uniform(0.15, 1.0) * bounds.fast,
               bounds.light + random.uniform(0.0, 0.6) * (bounds.heavy - bounds.light),
               min(random.uniform(0.6, 2.5), end - pen.time))


def _soft_steps(pen, random, bounds, duration):
    count = max(int(duration / random.uniform(2.0, 4.0)), 2)
    loads = _spread(random, bounds.light, bounds.heavy, count)
    for speed, load in zip(_spread(random, bounds.slow, bounds.fast, count), loads):
        pen.go(speed, load, duration / count, _SOFT)


def _creeping(pen, random, bounds, duration):
    count = max(int(duration / random.uniform(2.0, 5.0)), 1)
    speeds = _spread(random, 0.4 * bounds.slow, 2 * bounds.slow, count)
    for speed, load in zip(speeds, _spread(random, bounds.light, 0.6 * bounds.heavy, count)):
        pen.go(speed, load, duration / count, 0.3)


def _unloaded(pen, random, bounds, duration):
    count = max(int(duration / random.uniform(2.0, 6.0)), 1)
    for speed in _spread(random, bounds.slow, bounds.fast, count):
        pen.go(speed, 0.0, duration / count, 0.3)


def _standstill(pen, random, bounds, duration):
    count = max(int(duration / random.uniform(8.0, 12.0)), 1)
    for load in _spread(random, bounds.light, 0.6 * bounds.heavy, count):
        pen.go(random.uniform(0.3, 0.7) * bounds.fast, load, 0.4 * duration / count, 0.5)
        pen.go(0.0, load, 0.6 * duration / count, random.uniform(0.3, 1.5))


def _drilling(pen, random, bounds, duration):
    count = max(int(duration / 5.0), 2)
    for load in _spread(random, bounds.light, 0.6 * bounds.heavy, count):
        pen.go(0.55 * bounds.fast, load, duration / count)


class Family(NamedTuple):
    """
    How one is drawn, and what it is for people.

    What it shows is worth less (``ease``) where it also shows what no model has quite right: how
    the drive gets from one point to the next, or what it does near standstill or without load.
    """

    draw: Callable[[Pen, np.random.Generator, Any, float], None]
    words: str
    ease: float = 1.0


FAMILIES = {
    'soft_steps': Family(_soft_steps, 'many speeds and loads, gently one after the other'),
    'load_steps': Family(_load_steps, 'load steps at several speeds'),
    'speed_ramps': Family(_speed_ramps, 'speed ramps at constant load'),
    'load_ramps': Family(_load_ramps, 'load ramps at constant speed'),
    'reversals': Family(_reversals, 'reversals of the command about an operating point', 0.8),
    'fast_steps': Family(_fast_steps, 'quick steps of speed and load', 0.8),
    'creeping': Family(_creeping, 'very low speeds under load', 0.8),
    'unloaded': Family(_unloaded, 'several speeds without load', 0.5),
    'standstill': Family(_standstill, 'runs that end at standstill', 0.5),
}
# The last is what everybody has recorded.
DRAWN = {**FAMILIES, 'drilling': Family(_drilling, 'load steps at one speed')}
