# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Noise, coloured disturbances and their smoothing, against simulated and exact values."""
from hst_drive.measure.noise import (
    Coloured, estimate_coloured, noise_std, Smoother, variance_ratio)
import numpy as np
import pytest

from .synthetic import coloured

TIME = np.arange(6000) * 0.01


@pytest.mark.parametrize('motion', ['none', 'steps', 'ringing', 'drift'])
def test_white_noise_is_found_under_motion(motion):
    signal = {'none': 0 * TIME, 'steps': 40.0 * ((TIME / 4).astype(int) % 2),
              'drift': 10 * np.sin(2 * np.pi * 0.3 * TIME),
              # The hydraulic resonance after a step every 5 s.
              'ringing': 30 * np.exp(-(TIME % 5) * 4) * np.sin(2 * np.pi * 9.6 * (TIME % 5)),
              }[motion]
    found = [noise_std(signal + 0.5 * np.random.default_rng(seed).standard_normal(len(TIME)))
             for seed in range(8)]
    assert np.mean(found) == pytest.approx(0.5, rel=0.03)
    assert np.max(np.abs(np.array(found) - 0.5)) < 0.05


@pytest.mark.parametrize('n, expected', [(9, 0.0), (0, 0.0), (40, 1.0), (200, 1.0)])
def test_noise_of_short_records(n, expected):
    found = np.mean([noise_std(np.random.default_rng(seed).standard_normal(n))
                     for seed in range(300)])
    assert found == pytest.approx(expected, rel=0.15)


def test_noise_with_missing_samples():
    values = np.random.default_rng(1).standard_normal(6000)
    values[::7] = np.nan
    assert noise_std(values) == pytest.approx(1.0, rel=0.05)
    assert noise_std(np.full(50, np.nan)) == 0.0


@pytest.mark.parametrize('rate', [50, 100, 500])
@pytest.mark.parametrize('std, constant', [(0.5, 0.1), (3.0, 0.1), (3.0, 0.05), (8.0, 0.3)])
def test_roughness_and_noise_are_told_apart(rate, std, constant):
    n = 60 * rate
    found = []
    for seed in range(6):
        random = np.random.default_rng(seed)
        values = (coloured(random, n, 1 / rate, std, constant)
                  + 0.5 * random.standard_normal(n))
        found.append(estimate_coloured(np.arange(n) / rate, values, noise_std(values)))
    deviation, time_constant, noise = np.mean(found, axis=0)
    assert deviation == pytest.approx(std, rel=0.25)
    assert time_constant == pytest.approx(constant, rel=0.4)
    # Increments of the roughness hide the noise when they are larger.
    assert noise == pytest.approx(0.5, abs=0.05 + 0.6 * std * np.sqrt(2 / rate / constant) / 5)


@pytest.mark.parametrize('rate', [20, 25, 50, 100, 200, 500])
def test_steps_of_the_load_are_no_roughness_at_any_rate(rate):
    """A step of the load each five seconds, and the same rock in between."""
    n, found = 60 * rate, []
    for seed in range(6):
        random = np.random.default_rng(seed)
        steps = 60.0 * random.standard_normal(13)[np.arange(n) // (5 * rate)]
        values = (coloured(random, n, 1 / rate, 3.0, 0.3) + steps
                  + 0.5 * random.standard_normal(n))
        found.append(estimate_coloured(np.arange(n) / rate, values, noise_std(values)).std)
    assert np.mean(found) == pytest.approx(3.0, rel=0.25)


def test_noise_that_smooth_rock_hides():
    """Two poles have no increments at short lags, where one pole would leave no noise."""
    random, rate = np.random.default_rng(3), 100
    rock = coloured(random, 6000, 1 / rate, 1.0, 0.16)
    for k in range(1, len(rock)):
        rock[k] = rock[k - 1] + (rock[k] - rock[k - 1]) / (0.16 * rate)
    values = 3.0 * rock / rock.std() + 0.5 * random.standard_normal(6000)
    time = np.arange(6000) / rate
    found = estimate_coloured(time, values, noise_std(values))
    assert found.noise_std == pytest.approx(0.5, rel=0.15)


@pytest.mark.parametrize('rate, std, constant, second, step', [
    (100, 3.0, 0.16, 0.16, 0.0), (50, 2.3, 0.12, 0.036, 0.0), (50, 2.3, 0.12, 0.12, 0.0),
    (25, 3.0, 0.3, 0.3, 0.0), (100, 2.3, 0.12, 0.036, 2.0)])
def test_noise_beside_rock_of_two_poles(rate, std, constant, second, step):
    """
    Two poles have few increments at short lags, where one pole would leave no noise.

    A model of the load that is off by another ``step`` (N.m) every second shows at long lags.
    """
    found, n = [], 60 * rate
    for seed in range(6):
        random = np.random.default_rng(seed)
        rock = coloured(random, n, 1 / rate, 1.0, constant)
        share = 1.0 - np.exp(-1.0 / (second * rate))
        for k in range(1, n):
            rock[k] = rock[k - 1] + share * (rock[k] - rock[k - 1])
        values = std * rock / rock.std() + 0.5 * random.standard_normal(n)
        values += step * random.standard_normal(61)[np.arange(n) // rate]
        found.append(estimate_coloured(np.arange(n) / rate, values, noise_std(values)).noise_std)
    assert np.mean(found) == pytest.approx(0.5, rel=0.15)


def test_nothing_coloured_in_white_noise_and_short_records():
    found = estimate_coloured(TIME, np.random.default_rng(2).standard_normal(6000), 1.0)
    assert found.std < 0.25 and found.noise_std == pytest.approx(1.0, rel=0.03)
    assert estimate_coloured(TIME[:15], np.zeros(15), 0.3) == Coloured(0.0, 0.3, 0.3)


@pytest.fixture
def dense():
    """Return uneven time stamps, samples that count, and dense Gaussian-process algebra."""
    random = np.random.default_rng(4)
    time = np.cumsum(random.uniform(0.005, 0.05, 120))
    valid = random.uniform(size=120) > 0.2
    assumed = Coloured(1.7, 0.12, 0.6)
    prior = assumed.std**2 * np.exp(-np.abs(time[:, None] - time) / assumed.time_constant)
    cross = prior[:, valid]
    gain = cross @ np.linalg.inv(prior[np.ix_(valid, valid)] + assumed.noise_std**2 * np.eye(
        valid.sum()))
    return time, valid, assumed, gain, prior - gain @ cross.T


@pytest.mark.parametrize('goes_with_load', [True, False])
def test_rock_is_as_rough_as_its_load_or_always_alike(goes_with_load):
    """Ten layers of 20 to 240 N.m, 1 % of it or 1 N.m rough in 0.5 N.m of noise; a fifth rests."""
    load = 20.0 + 220.0 * np.random.default_rng(3).permutation(10)[(TIME / 6).astype(int)] / 9
    turns = TIME % 5.0 > 1.0
    found = []
    for seed in range(12):
        random = np.random.default_rng(seed)
        rough = coloured(random, len(TIME), 0.01, 1.0, 0.1) * (
            0.01 * load if goes_with_load else 1.0)
        rough = np.where(turns, rough + 0.5 * random.standard_normal(len(TIME)), 0.0)
        found.append(variance_ratio(TIME, rough, np.where(turns, load, np.nan), 0.5, turns))
    assert np.isfinite(found).all()
    true = load**2 / np.median(load**2) if goes_with_load else np.ones(len(TIME))
    high, low = turns & (load > 150.0), turns & (load < 60.0)
    for part in (high, low) if goes_with_load else (high,):
        assert np.mean(found, axis=0)[part].mean() == pytest.approx(
            true[part].mean(), rel=0.25, abs=0.1)


def test_smoother_is_the_gaussian_process_mean(dense):
    time, valid, assumed, gain, _ = dense
    values = np.random.default_rng(5).standard_normal(120)
    values[~valid] = np.nan
    found = Smoother(time, assumed, valid)(values)
    np.testing.assert_allclose(found, gain @ values[valid], rtol=1e-8, atol=1e-10)


def test_drawn_errors_have_the_posterior_covariance(dense):
    time, valid, assumed, _, covariance = dense
    smoother = Smoother(time, assumed, valid)
    random = np.random.default_rng(6)
    draws = np.array([smoother.draw_error(random) for _ in range(20000)])
    # Between samples the disturbance is a bridge whose mean has a twelfth of the innovation.
    decay = np.exp(-2 * np.diff(time) / assumed.time_constant)
    bridge = assumed.std**2 * (1 - decay) / 12
    want = covariance + np.diag(np.append(bridge, bridge[-1]))
    found = np.cov(draws.T)
    scale = np.sqrt(np.outer(np.diag(want), np.diag(want)))
    assert np.max(np.abs(found - want) / scale) < 0.05
    assert np.max(np.abs(draws.mean(axis=0)) / np.sqrt(np.diag(want))) < 0.05


def test_nothing_to_smooth():
    smoother = Smoother(TIME, Coloured(0.0, 0.3, 0.5), np.full(len(TIME), True))
    assert not smoother(np.ones(6000)).any()
    assert not smoother.draw_error(np.random.default_rng(1)).any()


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('size', [0.0, 1e-160, 1e-12, 1e9])
def test_the_unit_of_a_residual_does_not_matter(size):
    values = size * np.random.default_rng(1).standard_normal(2000)
    found = estimate_coloured(np.arange(2000) * 0.01, values, size)
    assert found.noise_std <= 1.001 * size and found.std <= 0.5 * size
