# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Fit and intervals on a linear problem, against closed forms and against draws."""
from types import SimpleNamespace

from hst_drive.effects import catalogue
from hst_drive.identify.fit import Fit, fit
from hst_drive.identify.intervals import intervals
from hst_drive.identify.model import Model
from hst_drive.identify.unknowns import SIGMAS, Unknowns
import numpy as np
import pytest
from scipy.optimize import lsq_linear

TOLERANCES = {'motor.leakage': 0.1, 'pump.leakage': 0.05}
EFFECT, KEY = 'viscous_drag', 'coefficient'
TYPICAL = catalogue()[EFFECT].parameters[0].typical
ROWS, BLOCK = 600, 20


class Linear:
    """A campaign whose errors are linear in the unknowns, each counted in its own scale."""

    tolerances = TOLERANCES
    ties = {}
    zeros = delays = {}
    adopted = {}
    commissioned_unit = False

    @property
    def sigmas(self):
        return self.tolerances

    def __init__(self, matrix, values):
        self.matrix, self.values = matrix, values
        everything = np.arange(len(values))
        self.columns = [SimpleNamespace(log=0, fit=everything, judge=everything[:0], weight=1.0)]

    def fits(self, name, key):
        return True

    def least(self, key):
        return -np.inf

    def parameter(self, name, key):
        return catalogue()[name].parameter(key)

    def errors(self, model, *, to_fit=False, known=None):
        unknowns = [model.factors.get(key, 0.0) / value for key, value in TOLERANCES.items()]
        unknowns += [values[KEY] / TYPICAL for values in model.effects.values()]
        return [self.matrix[:, :len(unknowns)] @ np.array(unknowns) - self.values]

    def training(self, errors):
        return errors[0]

    def fitted_blocks(self):
        return np.arange(len(self.values)) // BLOCK


class Curved(Linear):
    """Errors that grow exponentially with the effect: each step comes nearer by a third."""

    def errors(self, model, *, to_fit=False, known=None):
        size = model.effects[EFFECT][KEY] / TYPICAL
        factors = [model.factors.get(key, 0.0) / value for key, value in TOLERANCES.items()]
        return [self.matrix @ np.array([*factors, np.exp(3.0 * size)]) - self.values]


def problem(seed, true, noise=None):
    """Return a linear campaign whose unknowns are ``true`` in their scales."""
    random = np.random.default_rng(seed)
    matrix = random.standard_normal((ROWS, 3)) * [0.3, 0.3, 0.3]
    noise = random.standard_normal(ROWS) if noise is None else noise(random, matrix)
    return Linear(matrix, matrix @ true + noise)


def start():
    """Return the model that fits begin with."""
    return Model({EFFECT: {KEY: 0.3 * TYPICAL}})


def scaled(model):
    """Return the unknowns of a model in their scales."""
    return [*(model.factors[key] / value for key, value in TOLERANCES.items()),
            model.effects[EFFECT][KEY] / TYPICAL]


def test_a_fit_goes_on_while_the_cost_falls_fast():
    """A pump whose plate moves slowly was lost: four steps from a slower one led half the way."""
    linear = problem(3, np.array([0.5, -1.0, np.exp(3.0 * 0.3)]))
    begin = Model({EFFECT: {KEY: 2.0 * TYPICAL}})
    found = fit(Curved(linear.matrix, linear.values), begin, iterations=2)
    assert scaled(found.model)[-1] == pytest.approx(0.3, abs=0.02)
    assert fit(linear, begin, iterations=0).model.effects == begin.effects


@pytest.mark.parametrize('true', [(0.5, -1.0, 1.5), (0.0, 8.0, 1.0), (0.5, 0.5, -2.0)])
def test_a_linear_problem_is_bounded_ridge_regression(true):
    """Factors within three tolerances and drawn to the datasheet; a drag is not negative."""
    campaign = problem(3, np.array(true))
    prior = np.diag([1.0, 1.0, 0.0])
    exact = lsq_linear(np.vstack([campaign.matrix, prior]),
                       np.concatenate([campaign.values, np.zeros(3)]),
                       ([-SIGMAS, -SIGMAS, 0.0], [SIGMAS, SIGMAS, np.inf])).x
    found = fit(campaign, start(), iterations=6)
    assert scaled(found.model) == pytest.approx(exact, abs=2e-3)
    error = campaign.matrix @ exact - campaign.values
    assert found.cost == pytest.approx(float(error @ error + exact[:2] @ exact[:2]), rel=1e-5)


@pytest.mark.parametrize('share', [0.2, -1.0, 3.0])
def test_columns_that_are_wrong_lead_there_too(share):
    """What is known of the Jacobian comes from another model: steps that fail form it anew."""
    campaign = problem(3, np.array((0.5, -1.0, 1.5)))
    known = {('', key): share * column for key, column in zip(TOLERANCES, campaign.matrix.T)}
    known[EFFECT, KEY] = share * campaign.matrix[:, 2]
    found = fit(campaign, start(), iterations=8, known=known)
    assert found.cost == pytest.approx(fit(campaign, start(), iterations=8).cost, abs=0.6)


def covered(noise, off=0.0, count=300):
    """Return how often an interval holds a size of 2; ``off``: a factor's, in tolerances."""
    hits = 0
    for seed in range(count):
        campaign = problem(seed, np.array([0.0, off, 2.0]), noise)
        low, high = intervals(campaign, fit(campaign, start(), refresh=True))[EFFECT, KEY]
        hits += low <= 2.0 * TYPICAL <= high
    return hits / count


def test_intervals_hold_the_truth_though_errors_are_alike_within_a_block():
    """Independent-sample statistics, a cluster per row, hold it in 45 % of these cases."""
    def noise(random, matrix):
        # The column of the effect keeps its sign within a block, and so does the error.
        sign = np.repeat(random.choice([-1.0, 1.0], ROWS // BLOCK), BLOCK)
        matrix[:, 2] = 0.3 * sign
        return (0.5 * np.repeat(random.standard_normal(ROWS // BLOCK), BLOCK)
                + 0.5 * random.standard_normal(ROWS))

    assert 0.88 <= covered(noise) <= 0.99


def test_intervals_are_not_too_wide_where_samples_are_independent():
    assert 0.88 <= covered(None) <= 0.985


@pytest.mark.parametrize('off, least, most', [(0.0, 0.93, 0.995), (3.0, 0.89, 0.985)])
def test_intervals_hold_the_truth_where_the_unit_is_far_off_its_make(off, least, most):
    """A factor that moves the errors nearly as the effect does is drawn to the datasheet."""
    def noise(random, matrix):
        matrix[:, 2] = matrix[:, 1] + 0.3 * matrix[:, 2]
        return random.standard_normal(ROWS)

    assert least <= covered(noise, off) <= most


@pytest.mark.parametrize('name, key', [
    (name, entry.name) for name, effect in catalogue().items() for entry in effect.parameters])
def test_what_moves_nothing_has_the_declared_bounds_to_the_last_digit(name, key):
    campaign = problem(1, (0.0, 0.0, 0.0))
    campaign.tolerances = {}
    jacobian = np.zeros((ROWS, 1))
    campaign.fits = lambda effect, parameter: parameter == key
    parameter = catalogue()[name].parameter(key)
    found = intervals(campaign, Fit(Model({name: catalogue()[name].typical}),
                                    [campaign.values], 0.0, ((name, key),), jacobian,
                                    jacobian.T @ jacobian))
    assert found[name, key] == (parameter.low, parameter.high)


@pytest.mark.parametrize('name', catalogue())
def test_an_unknown_is_counted_in_a_size_within_its_bounds(name):
    """Else a difference quotient steps from one bound to the other, or by rounding errors."""
    campaign = Linear(np.zeros((1, 1)), np.zeros(1))
    unknowns = Unknowns(campaign, Model({name: dict(catalogue()[name].typical)}))
    assert (unknowns.high - unknowns.low >= 0.1).all()
    assert (unknowns.high - unknowns.low <= 1e4).all()


def test_a_model_as_it_stands_knows_nothing_of_its_unknowns():
    """Without a step no Jacobian is formed, and none is made up."""
    campaign = problem(1, (0.0, 0.0, 0.0))
    for _ in range(3):
        np.full((3, ROWS), 1e300)       # what memory may hold
        assert not fit(campaign, start(), iterations=0).information.any()
