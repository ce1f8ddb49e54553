# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Functions of time that a scenario is made of.

A profile is called with a time in s (from the start of the run) and returns a float in SI. All
are pure: the same time gives the same value, in any order of calls.
"""
from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
import math

import numpy as np


class Profile:
    """A function of time."""

    def __call__(self, t: float) -> float:
        """Return the value at ``t`` (s)."""
        raise NotImplementedError

    def sample(self, times) -> np.ndarray:
        """Return the values at many times, shape as ``times``."""
        return np.array([self(t) for t in np.asarray(times, dtype=float).tolist()])


class Points(Profile):
    """
    Values at given times; end values are held outside.

    Parameters
    ----------
    times : sequence of float
        s, strictly rising.
    values : sequence of float
        One for each time.
    hold : {'zero', 'linear'}
        Between two times: the earlier value stays, or a straight line.

    """

    def __init__(self, times: Sequence[float], values: Sequence[float], hold: str = 'linear'):
        self.times = [float(t) for t in times]
        self.values = [float(v) for v in values]
        if not self.times or len(self.times) != len(self.values):
            raise ValueError(f'{len(self.times)} times and {len(self.values)} values: expected '
                             'as many, at least one')
        if any(b <= a for a, b in zip(self.times, self.times[1:])):
            raise ValueError('times: expected strictly rising values')
        self.hold = hold

    def __call__(self, t: float) -> float:
        """Return the value at ``t`` (s)."""
        times, values = self.times, self.values
        after = bisect_right(times, t)
        if after == 0:
            return values[0]
        if after == len(times) or self.hold == 'zero':
            return values[after - 1]
        before = times[after - 1]
        share = (t - before) / (times[after] - before)
        return values[after - 1] + share * (values[after] - values[after - 1])

    def sample(self, times) -> np.ndarray:
        """Return the values at many times, shape as ``times``."""
        if self.hold == 'linear':
            return np.interp(times, self.times, self.values)
        index = np.searchsorted(self.times, times, side='right') - 1
        return np.asarray(self.values)[np.maximum(index, 0)]


def constant(value: float) -> Points:
    """Return a profile that stays at ``value``."""
    return Points([0.0], [value], 'zero')


class Sine(Profile):
    """``mean + amplitude * sin(frequency * t)``; frequency in rad/s."""

    def __init__(self, mean: float, amplitude: float, frequency: float):
        self.mean, self.amplitude, self.frequency = mean, amplitude, frequency

    def __call__(self, t: float) -> float:
        """Return the value at ``t`` (s)."""
        return self.mean + self.amplitude * math.sin(self.frequency * t)


class Chirp(Profile):
    """
    A sine whose frequency rises exponentially from ``first`` to ``last`` within ``duration``.

    Every octave gets the same time. Before 0 and after ``duration`` the mean.
    """

    def __init__(self, mean: float, amplitude: float, first: float, last: float, duration: float):
        if not (first > 0 and last > 0 and duration > 0):
            raise ValueError('frequencies and duration: expected positive values')
        self.mean, self.amplitude, self.duration = mean, amplitude, duration
        self.first, self.last = first, last
        self._rate = math.log(last / first) / duration

    def __call__(self, t: float) -> float:
        """Return the value at ``t`` (s)."""
        if not 0.0 <= t <= self.duration:
            return self.mean
        turned = t if self._rate == 0.0 else math.expm1(self._rate * t) / self._rate
        return self.mean + self.amplitude * math.sin(self.first * turned)


class Sum(Profile):
    """The sum of profiles."""

    def __init__(self, parts: Sequence[Profile]):
        self.parts = tuple(parts)

    def __call__(self, t: float) -> float:
        """Return the value at ``t`` (s)."""
        return math.fsum(part(t) for part in self.parts)


class Sequenced(Profile):
    """
    Profiles one after the other, each on its own clock; the last goes on.

    Parameters
    ----------
    parts : sequence of (float, Profile)
        Duration in s and profile.

    """

    def __init__(self, parts: Sequence[tuple[float, Profile]]):
        if not parts or any(not duration > 0 for duration, _ in parts):
            raise ValueError('a sequence needs parts with a positive duration')
        ends = np.cumsum([duration for duration, _ in parts]).tolist()
        self._starts = [0.0, *ends[:-1]]
        self._parts = [part for _, part in parts]

    def __call__(self, t: float) -> float:
        """Return the value at ``t`` (s)."""
        i = max(bisect_right(self._starts, t) - 1, 0)
        return self._parts[i](t - self._starts[i])


def random_steps(low: float, high: float, shortest: float, longest: float, duration: float,
                 seed: Sequence[int]) -> Points:
    """
    Return steps to random levels after random times, both uniform.

    Parameters
    ----------
    low, high : float
        Range of the levels.
    shortest, longest : float
        Range of the time between steps, s.
    duration : float
        Steps until then, s.
    seed : sequence of int
        The same seed gives the same steps.

    """
    if not 0.0 < shortest <= longest or not low <= high:
        raise ValueError('expected 0 < shortest <= longest and low <= high')
    if duration > 1e6 * shortest:
        raise ValueError(f'up to {duration / shortest:.3g} steps, expected at most a million')
    rng = np.random.default_rng(list(seed))
    times, values = [0.0], [float(rng.uniform(low, high))]
    while times[-1] < duration:
        times.append(times[-1] + float(rng.uniform(shortest, longest)))
        values.append(float(rng.uniform(low, high)))
    return Points(times, values, 'zero')
