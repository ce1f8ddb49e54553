# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Probabilities of explanations against closed forms, other formulas and exact integrals."""
from hst_drive.identify.evidence import (
    BIN, covariance, CREDIBLE, evidence, expected_odds, Explanation, laplace, likelihoods,
    probability, range_of, Sensor, Signal)
import numpy as np
import pytest
from scipy.integrate import dblquad, quad
from scipy.stats import multivariate_normal, multivariate_t

SENSOR = Sensor(0.1, 0.5, 0.3)
SENSORS = {'speed': SENSOR}


def noise(seed, pieces=20, length=60):
    """Return errors of a perfect model."""
    rng = np.random.default_rng(seed)
    return rng.multivariate_normal(np.zeros(length), covariance(SENSOR, length), pieces)


def explanation(names, errors, moved=0.0, penalty=0.0, **more):
    return Explanation(names, {'speed': Signal((errors,), float(np.sqrt(np.mean(
        np.square(moved)))))}, penalty, **more)


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


def test_what_a_sheet_is_declared_to_be_off_is_no_surprise():
    """Smooth errors of that size speak less against a model than where the sheet is right."""
    apart = np.abs(np.subtract.outer(np.arange(60), np.arange(60)))
    smooth = np.random.default_rng(2).multivariate_normal(
        np.zeros(60), np.exp(-0.5 * BIN * apart), 20)
    errors = noise(1) + 0.8 * smooth
    off, right = (evidence(explanation((), errors), {'speed': SENSOR._replace(sheet=sheet)}, 30)[0]
                  for sheet in (0.8, 0.0))
    assert off > right + 0.5


def test_a_parameter_that_moves_nothing_costs_nothing():
    with_still = laplace(np.diag([5.0, 0.0]), np.zeros(2, bool), np.array([3.0, 8.0]), np.ones(2))
    without = laplace(np.diag([5.0]), np.zeros(1, bool), np.array([3.0]), np.ones(1))
    assert with_still == pytest.approx(without)


def test_the_prior_of_sizes_is_a_density():
    """One over its range adds up to 1 over the sizes that there may be."""
    for both_ways, low in ((True, -np.inf), (False, 0.0)):
        total, _ = quad(lambda size: 1.0 / range_of(size, both_ways), low, np.inf)
        assert total == pytest.approx(1.0)
        assert quad(lambda size: 1.0 / range_of(size, both_ways), max(low, -3.0), 3.0)[
            0] == pytest.approx(0.5)


def test_a_second_number_that_may_be_none_is_weighed_as_both():
    """The mean of two evidences, each of a linear Gaussian model, in closed form."""
    rng = np.random.default_rng(3)
    design, width = rng.standard_normal((40, 2)), np.array([4.0, 9.0])
    for second in (0.0, 0.1, 1.0):
        target = design @ [0.5, second] + rng.standard_normal(40)
        scaled = design * width
        mode = np.linalg.solve(design.T @ design + np.diag(width**-2.0), design.T @ target)
        left = target - design @ mode
        # The Laplace form leaves out what the prior of an even one costs at its mode.
        found = (-0.5 * left @ left - 20 * np.log(2 * np.pi) - 0.5 * np.sum((mode / width)**2)
                 + laplace(design.T @ design, np.zeros(2, bool), width * np.sqrt(2 * np.pi),
                           mode, np.array([np.nan, 0.0])))
        both, alone = (multivariate_normal(np.zeros(40), np.eye(40) + part @ part.T).logpdf(target)
                       for part in (scaled, scaled[:, :1]))
        assert found == pytest.approx(np.logaddexp(both, alone) - np.log(2.0), abs=1e-9)


def test_means_of_coloured_noise_scatter_as_simulated_ones_do():
    rng, fine, memory = np.random.default_rng(2), 20, 0.15
    decay = np.exp(-BIN / fine / memory)
    values = rng.standard_normal((4000, 4 * fine))
    for place in range(1, values.shape[1]):
        values[:, place] = decay * values[:, place - 1] + np.sqrt(1 - decay**2) * values[:, place]
    means = values.reshape(4000, 4, fine).mean(axis=2)
    assert covariance(Sensor(0.0, 1.0, memory), 4) == pytest.approx(np.cov(means.T), abs=0.06)


def test_a_piece_has_a_student_density_about_noise_and_discrepancy():
    errors = noise(3, pieces=2, length=12)
    apart = np.abs(np.subtract.outer(np.arange(12), np.arange(12)))
    found = likelihoods((errors,), SENSOR)
    smooth = np.exp(-BIN * apart / 2.0)

    def exact(size):
        shape = covariance(SENSOR, 12) + size**2 * smooth
        return multivariate_t(np.zeros(12), shape, df=30).logpdf(errors).sum()

    # The greatest size is 60 floors, the least none.
    assert found[-1] - found[0] == pytest.approx(exact(60.0) - exact(0.0), rel=1e-9)


WAVE = 4.0 * np.sin(np.arange(1200) / 20).reshape(20, 60)


def test_an_effect_that_adds_nothing_is_less_probable_than_none():
    found = probability([explanation((), noise(4)),
                         explanation(('leak',), noise(4), 0.0, -3.0)], SENSORS, 30)
    assert found.none > 9 * found.effects['leak'] and found.none > 3 * found.unknown


def test_what_is_not_there_is_seldom_decided_for():
    """Fitted to noise alone; 300 draws, an effect whose work is a wave of about its length."""
    shape, won = WAVE / np.sqrt(np.sum(WAVE**2)), 0
    for seed in range(300):
        left = noise(seed)
        size = float(np.sum(shape * left))
        penalty = laplace(np.array([[np.sum(shape**2) / SENSOR.white]]), np.zeros(1, bool),
                          np.array([range_of(size, True)]), np.array([size]))
        alone, fitted = (evidence(entry, SENSORS, 30)[0] for entry in (
            explanation((), left),
            explanation(('leak',), left - size * shape, size * shape, penalty)))
        won += fitted - alone > CREDIBLE
    assert won <= 1


def test_what_is_known_of_a_machine_is_as_probable_beforehand_as_none():
    """Of equal fits; any other effect is one of as many as are searched for."""
    found = probability([explanation((), noise(4)), explanation(('leak',), noise(4), known=1),
                         explanation(('drag',), noise(4))], SENSORS, 20)
    assert found.effects['leak'] == pytest.approx(found.none)
    assert found.effects['leak'] == pytest.approx(20 * found.effects['drag'])


def test_what_one_effect_explains_names_it_and_all_sums_to_one():
    left = noise(5)
    sets = [explanation((), left + WAVE), explanation(('leak',), left, WAVE, -6.0),
            explanation(('drag',), left + 0.5 * WAVE, 0.5 * WAVE, -6.0),
            explanation(('drag', 'leak'), left, WAVE, -12.0)]
    found = probability(sets, SENSORS, 30)
    assert found.none + found.unknown + sum(p for _, p in found.sets) == pytest.approx(1.0)
    assert found.sets[0][0] == ('leak',) and found.sets[0][1] > 9 * found.sets[1][1]
    assert found.effects['leak'] > 3 * found.unknown
    assert found.effects['drag'] == pytest.approx(
        sum(p for names, p in found.sets if 'drag' in names))


def test_what_no_set_explains_is_unknown():
    left = noise(6)
    found = probability([explanation((), left + WAVE),
                         explanation(('drag',), left + 0.9 * WAVE, 0.1 * WAVE, -6.0)],
                        SENSORS, 30)
    assert found.unknown > 0.95


def test_what_one_signal_of_four_shows_is_unknown():
    left = {name: noise(number) for number, name in enumerate(('speed', 'flow', 'in', 'out'))}
    left['flow'] = left['flow'] + 0.5 * WAVE
    found = probability([Explanation((), {name: Signal((errors,), 0.0)
                                          for name, errors in left.items()}, 0.0)],
                        dict.fromkeys(left, SENSOR), 30)
    assert found.unknown > 0.9


def test_a_formula_that_is_a_tenth_off_is_not_unknown():
    left = noise(7)
    found = probability([explanation((), left + 4 * WAVE),
                         explanation(('leak',), left + 0.3 * WAVE, 3.7 * WAVE, -6.0)],
                        SENSORS, 30)
    assert found.effects['leak'] > 3 * found.unknown > 100 * found.none


def test_what_is_not_listed_and_fits_is_unknown():
    left = noise(8)
    near = explanation(('lag',), left + 0.2 * WAVE, 0.8 * WAVE, -6.0)
    sets = [explanation((), left + WAVE), near]
    dead_time = explanation((), left, WAVE, -6.0, listed=False)
    assert probability([*sets, dead_time], SENSORS, 30).unknown > max(
        0.5, probability(sets, SENSORS, 30).unknown)


def test_the_order_of_pieces_and_sets_changes_nothing():
    left = noise(9)
    sets = [explanation((), left + WAVE), explanation(('leak',), left, WAVE, -6.0)]
    turned = [explanation(entry.effects, entry.signals['speed'].pieces[0][::-1], moved,
                          entry.penalty) for entry, moved in zip(sets, (0.0, WAVE))][::-1]
    one, two = probability(sets, SENSORS, 30), probability(turned, SENSORS, 30)
    assert one.none == pytest.approx(two.none) and one.effects == pytest.approx(two.effects)


def test_one_event_says_less_than_the_same_power_all_along():
    left, event = noise(10), np.zeros((20, 60))
    event[3, 10:14] = 20.0
    steady = np.full((20, 60), np.sqrt(np.mean(event**2)))

    def gained(extra):
        first, second = (likelihoods((errors,), SENSOR)[0] for errors in (left + extra, left))
        return second - first

    assert gained(event) < 0.8 * gained(steady)


@pytest.mark.parametrize('size', [0.05, 0.2, 1.0])
def test_the_odds_that_are_to_come_are_about_those_that_come(size):
    """The truth leaves noise, the other model a part of a wave as well."""
    known = {'speed': Signal((size * WAVE,), 1.0)}
    come = []
    for seed in range(40):
        left = noise(seed)
        right, wrong = (evidence(explanation(('leak',), errors, np.ones(1)), SENSORS, 1)[0]
                        for errors in (left, left + size * WAVE))
        come.append(right - wrong)
    assert expected_odds(known, SENSORS, 0.1) == pytest.approx(np.mean(come), rel=0.15)
