# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Profiles against closed forms."""
import math

from hst_drive.load.profiles import (
    Chirp, constant, Points, random_steps, Sequenced, Sine, Sum)
from hypothesis import given, strategies as st
import numpy as np
import pytest

TIMES = st.lists(st.floats(0, 100), min_size=1, max_size=8, unique=True).map(sorted)


def test_step_of_the_paper():
    step = Points([0.0, 16.52], [223.5, 241.1], 'zero')
    assert step(16.519999) == 223.5
    assert step(16.52) == 241.1
    assert step(-1.0) == 223.5
    assert step(1e9) == 241.1


@given(TIMES, st.floats(-10, 110), st.integers(0, 9))
def test_ramps_agree_with_numpy(times, t, seed):
    if any(b - a < 1e-6 for a, b in zip(times, times[1:])):
        return
    values = np.random.default_rng(seed).normal(size=len(times))
    assert Points(times, values)(t) == pytest.approx(np.interp(t, times, values), abs=1e-9)


@given(TIMES, st.sampled_from(('zero', 'linear')))
def test_sampling_agrees_with_calling(times, hold):
    if any(b - a < 1e-6 for a, b in zip(times, times[1:])):
        return
    profile = Points(times, [t * t for t in times], hold)
    grid = np.linspace(-5, 105, 57)
    assert profile.sample(grid) == pytest.approx([profile(t) for t in grid])


def test_chirp_reaches_its_frequencies():
    """The phase rate, by differences, is the first frequency at 0 and the last at the end."""
    chirp = Chirp(0.0, 1.0, 2.0, 50.0, 20.0)
    for t, frequency in ((0.0, 2.0), (10.0, 10.0), (20.0 - 1e-5, 50.0)):
        # d/dt sin(phase) = phase rate * cos(phase)
        slope = (chirp(t + 1e-6) - chirp(t)) / 1e-6
        cosine = math.sqrt(1.0 - chirp(t)**2)
        assert abs(slope) == pytest.approx(frequency * cosine, rel=2e-3)
    assert chirp(20.1) == 0.0


def test_sum_and_sequence():
    total = Sum([constant(3.0), Sine(1.0, 2.0, math.pi)])
    assert total(0.5) == pytest.approx(6.0)
    row = Sequenced([(2.0, constant(1.0)), (3.0, Points([0.0, 3.0], [0.0, 3.0]))])
    assert [row(t) for t in (0.0, 1.99, 2.0, 4.0, 50.0)] == pytest.approx([1, 1, 0, 2, 3])


@given(st.integers(0, 50))
def test_random_steps_stay_in_range_and_repeat(seed):
    one, two = (random_steps(2.0, 5.0, 0.5, 1.5, 20.0, (seed, 1)) for _ in range(2))
    assert one.times == two.times and one.values == two.values
    assert all(2.0 <= value <= 5.0 for value in one.values)
    gaps = np.diff(one.times)
    assert gaps.min() >= 0.5 and gaps.max() <= 1.5
    assert one.times[-1] >= 20.0


@pytest.mark.parametrize('build', (
    lambda: Points([], []), lambda: Points([0.0, 0.0], [1.0, 2.0]), lambda: Points([0.0], [1, 2]),
    lambda: Sequenced([]), lambda: Chirp(0, 1, 0.0, 5.0, 1.0),
    lambda: random_steps(1.0, 0.0, 1.0, 2.0, 5.0, (1,))))
def test_nonsense_is_refused(build):
    with pytest.raises(ValueError):
        build()
