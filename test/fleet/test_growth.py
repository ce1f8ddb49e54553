# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Growth and what remains, on lives of sizes whose law is known in closed form."""
from hst_drive.fleet.growth import Growth, History
from hst_drive.fleet.laws import ACCELERATING, at, inverse, LINEAR, ONSET
import numpy as np
import pytest

DAYS = 61.0 * np.arange(12)
END = DAYS[-1]


def history(law, *, days=DAYS, sigma=0.03, seed=1, temperatures=np.empty(0)):
    """Return measured sizes of a law."""
    noise = np.random.default_rng(seed).standard_normal(len(days))
    return History(days, law(days) + sigma * noise, np.full(len(days), sigma), temperatures)


def test_a_law_is_undone_by_its_inverse():
    """And each is 0 where it begins and 1 at the end of the stretch."""
    for kind, shape in ((LINEAR, 0.0), (ONSET, 0.4), (ACCELERATING, 3.0)):
        places = np.linspace(0.5, 3.0, 6)
        assert inverse(kind, shape, at(kind, shape, places)) == pytest.approx(places)
        assert at(kind, shape, np.array([0.0, 1.0])) == pytest.approx([0.0, 1.0])


def test_linear_wear_has_its_slope_and_its_end():
    """The slope is that of weighted least squares; the end is where the line meets the limit."""
    made = history(lambda day: 0.5 * day / END)
    found = Growth(made)
    slope, start = np.polyfit(made.days, made.values, 1)
    assert found.kind == 'grows' and not found.jumps and found.since < 61.0
    assert found.rate[0] < 0.5 / END < found.rate[2]
    assert found.rate[1] == pytest.approx(slope, rel=0.1)
    left = found.remaining(1.0)
    assert left.middle == pytest.approx((1.0 - start) / slope, rel=0.05)
    assert left.low < 2.0 * END < left.high and left.reached == 0.0


def test_a_formula_that_is_off_makes_no_trend_but_moves_the_end():
    """Sizes that are 5 % too large reach a limit when the true one is at 0.95 of it."""
    made = history(lambda day: 0.5 * day / END, sigma=1e-4)
    found = Growth(made, 0.05)
    assert found.rate == pytest.approx(Growth(made).rate)
    left, width = found.remaining(1.0), 1.96 * 0.05
    assert [left.low, left.high] == pytest.approx(
        2.0 * END * np.exp([-width, width]), rel=0.01)
    assert [found.level[0], found.level[2]] == pytest.approx(
        0.5 * np.exp([-width, width]), rel=0.01)


def test_what_all_sizes_are_off_by_makes_no_trend_but_moves_the_end():
    """A line that is 0.02 too high reaches a limit so much earlier, and has no other slope."""
    made = history(lambda day: 0.5 * day / END, sigma=1e-4)
    found, width = Growth(made._replace(offset=0.02)), 1.96 * 0.02
    assert found.rate == pytest.approx(Growth(made).rate)
    left = found.remaining(1.0)
    assert [left.low, left.high] == pytest.approx(
        2.0 * END * np.array([1.0 - width, 1.0 + width]), rel=0.005)
    assert [found.level[0], found.level[2]] == pytest.approx([0.5 - width, 0.5 + width], rel=0.01)


def test_wear_from_some_day_on_and_accelerating():
    late = Growth(history(lambda day: 0.6 * np.maximum(day - 300.0, 0.0) / (END - 300.0)))
    assert late.kind == 'grows' and late.since == pytest.approx(300.0, abs=61.0)
    faster = Growth(history(lambda day: 0.6 * np.expm1(3.0 * day / END) / np.expm1(3.0)))
    assert faster.kind == 'accelerates'


def test_a_repair_is_a_jump_after_which_all_begins_anew():
    found = Growth(history(lambda day: np.where(day < 330.0, 0.7 * day / 330.0,
                                                0.5 * (day - 330.0) / (END - 330.0))))
    jump, = found.jumps
    assert (jump.after, jump.before) == (305.0, 366.0) and jump.last < 0.2 * jump.first
    assert found.kind == 'grows' and found.since > 250.0


def test_growth_that_sets_in_between_two_dates_is_no_jump():
    """A bend without a step, seen sharply."""
    sizes = np.array([0.0, 0.01, 0.02, 0.06, 0.1, 0.15, 0.21, 0.3, 0.4, 0.53, 0.7, 0.92])
    assert not Growth(History(DAYS, sizes, np.full(12, 0.003))).jumps
    slow, fast = 1e-4 * DAYS, 1e-3 * (DAYS - 244.0)
    bent = np.where(DAYS < 244.0, slow, fast + 0.08)
    found = Growth(History(DAYS, bent + 0.2 * (DAYS > 200.0), np.full(12, 0.003)))
    assert not Growth(History(DAYS, bent, np.full(12, 0.003))).jumps
    assert [(jump.after, jump.before) for jump in found.jumps] == [(183.0, 244.0)]


def test_summers_are_no_growth():
    warm = 50.0 + 10.0 * np.sin(2.0 * np.pi * DAYS / 365.25)
    found = Growth(history(lambda day: 0.3 + 0.2 * np.sin(2.0 * np.pi * day / 365.25),
                           temperatures=warm))
    assert found.kind == 'steady' and found.season > 0.9 and not found.jumps
    both = Growth(history(lambda day: 0.3 + 0.2 * np.sin(2.0 * np.pi * day / 365.25)
                          + 0.6 * day / END, temperatures=warm))
    assert both.kind == 'grows' and both.rate[0] < 0.6 / END < both.rate[2]


def test_a_few_kelvin_count_as_well():
    """Days of 48.5 to 51.5 degC: what they do to a leak is not taken for scatter."""
    warm = 50.0 + np.random.default_rng(3).uniform(-1.5, 1.5, len(DAYS))
    made = history(lambda day: 0.6 * day / END + 0.06 * (warm - 50.0), sigma=0.01,
                   temperatures=warm)
    found, blind = Growth(made), Growth(made._replace(temperatures=np.empty(0)))
    assert found.season > 0.9 and found.kind == 'grows'
    left, without = found.remaining(1.0), blind.remaining(1.0)
    assert left.low < END / 0.6 < left.high
    assert left.high - left.low < 0.6 * (without.high - without.low)


def test_what_all_sizes_may_be_off_together_is_found():
    """It is the generalised least squares estimate of a line, by a covariance of rank one."""
    together = 0.1 * np.sin(2.0 * np.pi * DAYS / 365.25) + 0.05
    made = history(lambda day: 0.6 * day / END + 1.5 * together, sigma=0.01)
    found = Growth(made._replace(thinner=together))
    design = np.column_stack([np.ones_like(DAYS), DAYS])
    weight = np.linalg.inv(1e-4 * np.eye(len(DAYS)) + np.outer(together, together))
    slope = np.linalg.solve(design.T @ weight @ design, design.T @ weight @ made.values)[1]
    assert found.kind == 'grows' and not found.jumps
    assert found.rate[1] == pytest.approx(slope, rel=0.05)
    left, blind = found.remaining(1.0), Growth(made).remaining(1.0)
    assert left.low < END / 0.6 < left.high
    assert left.high - left.low < 0.5 * (blind.high - blind.low)


def test_a_size_that_gets_more_negative_grows():
    """A sensor that reads less and less; its limit is negative, too."""
    found = Growth(history(lambda day: -0.5 * day / END))
    assert found.kind == 'grows'
    assert found.remaining(-1.0).low < 2.0 * END < found.remaining(-1.0).high
    assert np.isinf(found.remaining(1.0).low)


def test_two_dates_are_too_few():
    found = Growth(history(lambda day: day / END, days=DAYS[:2]))
    assert found.kind == 'too few dates' and found.remaining(1.0) is None
    assert Growth(history(lambda day: 0.5 + 0 * day, days=DAYS[:1])).level[1] == pytest.approx(
        0.5, abs=0.1)


def test_what_is_reached_is_told():
    left = Growth(history(lambda day: 2.0 * day / END)).remaining(1.0)
    assert left.reached > 0.99 and left.middle == END


def test_remaining_time_lies_in_its_interval():
    """Lives drawn by chance, of which every law, also with more scatter than is told."""
    from bench.growth import life

    hits = []
    for seed in range(60):
        _, made, true = life(seed)
        left = Growth(made).remaining(1.0)
        hits.append(left.low <= true <= left.high)
    assert sum(hits) >= 0.9 * len(hits)


def test_steady_sizes_are_not_told_as_growing():
    random = np.random.default_rng(11)
    found = [Growth(History(61.0 * np.arange(count), 0.5 * (number % 2) + 0.06
                            * random.standard_normal(count), np.full(count, 0.05)))
             for number, count in enumerate(random.integers(4, 16, 30))]
    assert sum(entry.kind in ('grows', 'accelerates', 'falls') for entry in found) <= 1
    assert sum(len(entry.jumps) for entry in found) <= 1
