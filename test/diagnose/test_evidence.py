# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Probabilities of explanations against closed forms and exact integrals."""
from hst_drive.diagnose.evidence import (
    decided, Explanation, independent, laplace, likelihood, Probability, probability, Signal)
import numpy as np
import pytest
from scipy.integrate import dblquad, quad
from scipy.stats import multivariate_normal


def coloured(seed, count, memory):
    """Return unit noise with correlation exp(-1/memory) from sample to sample."""
    rng, share = np.random.default_rng(seed), np.exp(-1.0 / memory)
    values = rng.standard_normal(count)
    for place in range(1, count):
        values[place] = share * values[place - 1] + np.sqrt(1 - share**2) * values[place]
    return values


def blocks(values):
    return (values.reshape(-1, 40)**2).mean(axis=1)


def explanation(names, errors, moved=0.0, penalty=0.0):
    moved = moved * np.ones_like(errors)
    return Explanation(names, {'speed': Signal(blocks(errors), blocks(moved), 1.5)}, penalty)


def test_laplace_is_exact_for_a_linear_gaussian_model():
    rng = np.random.default_rng(1)
    design, target = rng.standard_normal((40, 3)), rng.standard_normal(40)
    inverse = np.linalg.inv(design.T @ design + np.eye(3))
    mode = inverse @ design.T @ target
    left = target - design @ mode
    found = (-0.5 * left @ left - 20 * np.log(2 * np.pi)
             + laplace(design.T @ design, np.ones(3, bool), np.ones(3), mode))
    exact = multivariate_normal(np.zeros(40), np.eye(40) + design @ design.T).logpdf(target)
    assert found == pytest.approx(exact, abs=1e-9)


def test_laplace_agrees_with_an_integral_over_even_and_normal_priors():
    information, mode = np.array([[60.0, 12.0], [12.0, 30.0]]), np.array([0.7, 0.2])

    def density(effect, factor):
        move = np.array([factor, effect]) - mode[::-1]
        # About the mode of the whole, the prior of the factor included.
        return np.exp(-0.5 * move @ (information + np.diag([1.0, 0.0])) @ move)

    volume, _ = dblquad(density, -3, 3, -4.3, 5.7, epsabs=1e-9)
    exact = np.log(volume / 10.0 / np.sqrt(2 * np.pi)) - 0.5 * 0.2**2
    found = laplace(information, np.array([True, False]), np.array([1.0, 10.0]),
                    np.array([0.2, 0.7]))
    assert found == pytest.approx(exact, abs=0.02)


def test_a_parameter_that_moves_nothing_costs_nothing():
    with_still = laplace(np.diag([5.0, 0.0]), np.zeros(2, bool), np.array([3.0, 8.0]), np.ones(2))
    without = laplace(np.diag([5.0]), np.zeros(1, bool), np.array([3.0]), np.ones(1))
    assert with_still == pytest.approx(without)


def test_the_scale_of_a_block_is_integrated_out():
    samples, squares = 6.0, np.array([1.2, 3.0])
    found = [likelihood(Signal(np.array([square]), np.zeros(1), 1.5), samples)
             for square in squares]

    def given(precision, square):   # over it the scale is known by five samples
        return (precision**(5 / 2 - 1) * np.exp(-5 * precision / 2)
                * precision**(samples / 2) * np.exp(-samples * square * precision / 2))

    exact = [np.log(quad(given, 0, 40, args=(square,))[0]) for square in squares]
    assert found[1] - found[0] == pytest.approx(exact[1] - exact[0], rel=1e-6)


def test_independent_samples_are_those_of_the_correlation():
    found = np.mean([independent(coloured(seed, 8000, 10.0), 1e9) for seed in range(6)])
    exact = 8000 * np.tanh(0.05)    # (1 - a)/(1 + a) with a = exp(-1/10)
    assert found == pytest.approx(exact, rel=0.2)


@pytest.mark.parametrize('step', [2, 4])
def test_half_the_rows_say_nearly_the_same(step):
    noise = coloured(3, 16000, 40.0)
    wave = np.sin(np.arange(16000) / 600)

    def of(step):
        squares = [(values.reshape(-1, 160)[:, ::step]**2).mean(axis=1)
                   for values in (noise + wave, noise, wave)]
        samples = {'speed': independent(noise[::step], 1e9) / len(squares[0])}
        return probability([
            Explanation((), {'speed': Signal(squares[0], 0 * squares[0], 1.5)}, 0.0),
            Explanation(('leak',), {'speed': Signal(squares[1], squares[2], 1.5)}, -6.0)],
            samples, 30)

    assert of(step).effects['leak'] == pytest.approx(of(1).effects['leak'], abs=0.02)


WAVE = 4.0 * np.sin(np.arange(16000) / 200)


def test_an_effect_that_adds_nothing_is_less_probable_than_none():
    noise = coloured(4, 16000, 8.0)
    found = probability([explanation((), noise), explanation(('leak',), noise, 0.0, -3.0)],
                        {'speed': 4.0}, 30)
    assert found.none > 0.9 and found.unknown < 0.1


def test_what_one_effect_explains_names_it_and_all_sums_to_one():
    noise = coloured(5, 16000, 8.0)
    sets = [explanation((), noise + WAVE), explanation(('leak',), noise, WAVE, -6.0),
            explanation(('drag',), noise + 0.5 * WAVE, 0.5 * WAVE, -6.0),
            explanation(('drag', 'leak'), noise, WAVE, -12.0)]
    found = probability(sets, {'speed': 4.0}, 30)
    assert found.none + found.unknown + sum(p for _, p in found.sets) == pytest.approx(1.0)
    assert found.sets[0][0] == ('leak',) and found.effects['leak'] > 0.95
    assert found.effects['drag'] == pytest.approx(
        sum(p for names, p in found.sets if 'drag' in names))


def test_what_no_set_explains_is_unknown():
    noise = coloured(6, 16000, 8.0)
    found = probability([explanation((), noise + WAVE),
                         explanation(('drag',), noise + 0.9 * WAVE, 0.1 * WAVE, -6.0)],
                        {'speed': 4.0}, 30)
    assert found.unknown > 0.95


def test_a_formula_that_is_a_tenth_off_is_not_unknown():
    noise = coloured(7, 16000, 8.0)
    found = probability([explanation((), noise + 4 * WAVE),
                         explanation(('leak',), noise + 0.3 * WAVE, 3.7 * WAVE, -6.0)],
                        {'speed': 4.0}, 30)
    assert found.effects['leak'] > 0.8


def test_the_order_of_the_logs_and_of_the_sets_changes_nothing():
    noise = coloured(8, 16000, 8.0)

    def found(logs, order):
        def joined(values):
            return np.concatenate([values[part] for part in logs])

        made = [explanation((), joined(noise + WAVE)),
                explanation(('leak',), joined(noise), joined(WAVE), -6.0)]
        return probability(made[::order], {'speed': 4.0}, 30)

    first, second = slice(0, 8000), slice(8000, 16000)
    one, two = found((first, second), 1), found((second, first), -1)
    assert one.none == pytest.approx(two.none) and one.effects == pytest.approx(two.effects)


def test_one_event_says_less_than_the_same_power_all_along():
    noise = coloured(9, 16000, 8.0)
    event = np.where(np.arange(16000) < 40, 40.0, 0.0)
    spread = np.full(16000, 2.0)

    def gained(extra):
        return probability([explanation((), noise + extra),
                            explanation(('leak',), noise, extra, -6.0)], {'speed': 4.0}, 30)

    assert gained(event).effects['leak'] < 0.9 < gained(spread).effects['leak']


FOUND = Probability(0.3, 0.1, ((('leak',), 0.4), (('drag',), 0.2)))


@pytest.mark.parametrize('verdict, named, said', [
    ('none', [()], lambda found: found.none), ('unknown', [], lambda found: found.unknown),
    ('missing_effect', [('drag',)], lambda found: found.effects['drag']),
    ('ambiguous', [('drag',), ('leak',)], lambda found: sum(p for _, p in found.sets))])
def test_what_was_decided_is_more_probable_and_the_rest_keeps_its_odds(verdict, named, said):
    found = decided(FOUND, verdict, named)
    assert found.none + found.unknown + sum(p for _, p in found.sets) == pytest.approx(1.0)
    assert said(found) > said(FOUND) and said(found) >= 0.5
    if verdict == 'unknown':
        assert found.none / found.effects['leak'] == pytest.approx(0.3 / 0.4)
