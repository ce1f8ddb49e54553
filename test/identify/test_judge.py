# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How models are judged block by block, on made-up blocks whose answer is known."""
from hst_drive.identify.judge import gain, matters, shown, unharmed
import numpy as np
import pytest
from scipy.stats import ttest_1samp


def blocks(count, fall, seed=1, scatter=0.2):
    """Return squared errors by block before and after, and their difference."""
    random = np.random.default_rng(seed)
    after = 1.0 + 0.1 * random.standard_normal(count)
    difference = fall + scatter * random.standard_normal(count)
    return {'motor_speed': after + difference}, {'motor_speed': after}, difference


def test_gain_is_the_paired_t_statistic():
    before, after, difference = blocks(40, 0.5)
    found = gain(before, after)
    assert found.amount['motor_speed'] == pytest.approx(difference.mean())
    assert found.share['motor_speed'] == pytest.approx(
        difference.mean() / before['motor_speed'].mean())
    assert found.sigma['motor_speed'] == pytest.approx(ttest_1samp(difference, 0.0).statistic)


def test_chance_is_seldom_called_significant():
    """Beyond 3 lies 0.13 % of a normal distribution, 3 of 2000; 60 blocks make it a few more."""
    hits = sum(gain(*blocks(60, 0.0, seed)[:2]).sigma['motor_speed'] >= 3.0
               for seed in range(2000))
    assert hits <= 10


def test_one_wild_block_does_not_decide():
    before, after, _ = blocks(40, 0.0)
    before['motor_speed'][7] += 1000.0
    found = gain(before, after)
    assert found.share['motor_speed'] > 0.9     # by the mean alone it would be named
    assert found.sigma['motor_speed'] < 3.0


def test_missing_blocks_are_left_out_and_two_are_too_few():
    before, after, difference = blocks(40, 0.5)
    before['motor_speed'][:10] = np.nan
    found = gain(before, after)
    assert found.amount['motor_speed'] == pytest.approx(difference[10:].mean())
    before['motor_speed'][2:] = np.nan
    assert gain(before, after).sigma == {}


def test_a_signal_that_gets_worse_is_harmed():
    before, after, _ = blocks(40, 0.5)
    assert unharmed(gain(before, after)) and not unharmed(gain(after, before))


def moves(count, slope, seed, where):
    """Return mean squares of 200 errors in each block with a move in some blocks, and of it."""
    random = np.random.default_rng(seed)
    noise, move = random.standard_normal((2, count, 200))
    move[where:] *= 0.01
    before = noise + slope * move
    return [{'a': np.mean(square**2, axis=1)} for square in (before, before - move, move)]


def test_what_shows_in_a_few_blocks_is_sure_where_its_move_is_in_them():
    """White noise: the slope of 1200 errors on the move has a standard error of 1/sqrt(1200)."""
    found = [gain(*moves(60, 1.0, seed, 6)) for seed in range(200)]
    assert np.median([entry.sigma['a'] for entry in found]) < 3.0
    assert np.median([entry.shown['a'] for entry in found]) == pytest.approx(
        0.5 * 1200**0.5, rel=0.3)


def test_a_move_that_is_not_there_is_seldom_sure_twice():
    """Three blocks of fitted data and three of held-out: at least 3 and 2 are asked for."""
    chance = [min(gain(*moves(30, 0.0, seed, 3)).shown['a'] / 3.0,
                  gain(*moves(15, 0.0, 5000 + seed, 3)).shown['a'] / 2.0) for seed in range(2000)]
    assert np.sum(np.array(chance) >= 1.0) <= 10


@pytest.mark.parametrize('slope, done, expected', [
    (1.0, 0.0, True),       # a few blocks hold all of the move
    (0.0, 0.0, False),      # none holds it
    (1.0, 20.0, False),     # less than a fifth of what others do there: another form of theirs
])
def test_what_is_shown_is_worth_a_name(slope, done, expected):
    held_out, fitted = (gain(*moves(count, slope, seed, count // 5))
                        for count, seed in ((60, 1), (120, 2)))
    assert shown(held_out, fitted, {'a': done}) is expected


def test_what_one_half_alone_shows_is_not_worth_a_name():
    there, not_there = (gain(*moves(60, slope, 3, 12)) for slope in (1.0, 0.0))
    assert shown(there, there, {'a': 0.0})
    assert not shown(there, not_there, {'a': 0.0}) and not shown(not_there, there, {'a': 0.0})


@pytest.mark.parametrize('share, worth', [(0.09, False), (0.11, True)])
def test_a_tenth_of_one_signals_squared_error_matters(share, worth):
    before = {'motor_speed': 2.0, 'load_torque': 1.0}
    after = {**before, 'motor_speed': 2.0 * (1.0 - share)**0.5}
    assert matters(before, after) is worth and not matters(before, before)
