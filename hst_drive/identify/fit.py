# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Fit of a model to a campaign: bounded Gauss-Newton with priors.

The unit's factors have Gaussian priors from the datasheet and are held within three sigma: with
tens of thousands of samples a prior alone is outvoted, and the factors would eat the physics.
"""
from __future__ import annotations

from itertools import count as count_from
from typing import Callable, Collection, Iterator, NamedTuple, Sequence

from hst_drive.effects import catalogue
from hst_drive.identify.campaign import Campaign, Model
from hst_drive.identify.judge import excess
from hst_drive.identify.unknowns import SIGMAS, Unknowns
import numpy as np
from scipy.optimize import lsq_linear

# Steps of the differences: of a tolerance for the unit's factors, relative for parameters. The
# drive rings: with steps that shift the ringing by a part of its period the fit gets stuck.
_NUDGE, _NUDGE_EFFECT = 0.05, 0.02
_TRIES = 4      # dampings of a step of all unknowns
_MOVES = (0.1, -0.1, 0.03, -0.03)   # of one parameter
_FITS = 0.1     # squared error over the floor's
_END = 0.8 * SIGMAS     # tolerances: near the end of what a factor may be
_HOT, _LONGEST = 9.0, 3     # squared error of a block, blocks: an event
_AT_END = 0.02      # of a bound: half of what formulas are off machines does not tell it from it
ErrorsAt = Callable[[np.ndarray], list[np.ndarray]]


class Fit(NamedTuple):
    """
    A fitted model.

    ``cost`` is the sum of squares of the weighted errors and of the priors; ``jacobian`` and
    ``names`` belong to the scaled unknowns (see ``Unknowns``).
    """

    model: Model
    errors: list[np.ndarray]
    cost: float
    names: tuple[tuple[str, str], ...]
    jacobian: np.ndarray


def score(campaign: Campaign, fitted: Fit) -> float:
    """
    Return the held-out squared error plus the fit's cost; lower is better.

    Each parameter of an effect beyond its size costs the logarithm of the number of samples, what
    it may gain by chance (G. Schwarz, Estimating the dimension of a model, Annals of Statistics
    6, 1978).
    """
    own = [name for name, _ in fitted.names if name]
    total = (len(own) - len({*own})) * float(np.log(max(len(fitted.jacobian), 1)))
    for error, column in zip(fitted.errors, campaign.columns):
        judged = (error * column.trust)[column.judge] * campaign.thinning(column)
        total += float(judged @ judged)
    return total + fitted.cost


def cost_of(campaign: Campaign, unknowns: Unknowns, vector: np.ndarray,
            errors: Sequence[np.ndarray], trimmed: bool = False) -> float:
    """Return the sum of squares of weighted errors and priors; ``trimmed``: without events."""
    residual = campaign.training(errors)
    if trimmed:
        residual = residual[campaign.without_events(residual)]
    prior = vector[:unknowns.factors]
    return float(residual @ residual + prior @ prior)


def differences(campaign: Campaign, unknowns: Unknowns, vector: np.ndarray,
                errors: Sequence[np.ndarray], which: Sequence[int],
                errors_at: ErrorsAt) -> np.ndarray:
    """Return columns of the Jacobian of the weighted errors, by forward differences."""
    base = campaign.training(errors)
    columns = np.empty((len(base), len(which)))
    for place, k in enumerate(which):
        step = _NUDGE if k < unknowns.factors else _NUDGE_EFFECT * max(abs(vector[k]), 0.3)
        if vector[k] + step > unknowns.high[k]:
            step = -step
        moved = vector.copy()
        moved[k] += step
        columns[:, place] = (campaign.training(errors_at(moved)) - base) / step
    return columns


def fit(campaign: Campaign, start: Model, *, iterations: int = 4, known: np.ndarray | None = None,
        refresh: bool = False, trimmed: bool = False, kept: Collection[tuple[str, str]] = (),
        progress: Callable[[str], None] = lambda text: None) -> Fit:
    """
    Fit the unit's factors and the parameters of the effects that are on.

    Parameters
    ----------
    campaign : Campaign
        What to fit.
    start : Model
        Where to start.
    iterations : int
        Most Gauss-Newton steps.
    known : ndarray, shape (samples, factors), optional
        Jacobian of the factors from a nearby model; saves most of the work.
    refresh : bool
        Form the whole Jacobian anew at the end, for intervals.
    trimmed : bool
        Leave out the few seconds where the model is off most, in each step anew: a drive that
        stalls only in the model stands in the way of all steps else.
    kept : collection of (str, str)
        What stays as ``start`` has it (``Unknowns``).
    progress : callable
        Called with a text before each replay; may raise to stop.

    """
    unknowns = Unknowns(campaign, start, kept)
    replays = count_from(1)

    def errors_at(vector: np.ndarray) -> list[np.ndarray]:
        progress(f'fitting: {next(replays)} replays')
        return campaign.errors(unknowns.unpack(vector), to_fit=True)

    vector = np.clip(unknowns.pack(start), unknowns.low, unknowns.high)
    errors = errors_at(vector)
    cost = cost_of(campaign, unknowns, vector, errors, trimmed)
    count = len(vector)
    free = list(range(unknowns.factors, count))
    jacobian = np.empty((len(campaign.training(errors)), count))
    if known is not None:
        jacobian[:, :unknowns.factors] = known
    damping = 1e-6
    for place in range(iterations if count else 0):
        which = free if known is not None else list(range(count))
        jacobian[:, which] = differences(campaign, unknowns, vector, errors, which,
                                         errors_at)
        step_taken = False
        for trial, damping in _trials(campaign, unknowns, vector, errors, jacobian, damping,
                                      trimmed, refresh):
            trial_errors = errors_at(trial)
            trial_cost = cost_of(campaign, unknowns, trial, trial_errors, trimmed)
            if trial_cost < cost:
                gain = cost - trial_cost
                vector, errors, cost = trial, trial_errors, trial_cost
                damping = max(damping / 10, 1e-9)
                step_taken = True
                break
        # A first step along a bend gains little; where time is taken the next one may gain more.
        if not step_taken or gain < 1e-3 * cost + 0.5 and (place or not refresh):
            break
        if _promise(campaign, unknowns, vector, errors, jacobian) < 1e-3 * cost + 0.5:
            break
    if refresh:
        jacobian = differences(campaign, unknowns, vector, errors, range(count), errors_at)
    if trimmed:
        cost = cost_of(campaign, unknowns, vector, errors)      # to be compared with others
    model = unknowns.unpack(vector)
    return Fit(model, campaign.errors(model), cost, unknowns.names, jacobian)


def settled(campaign: Campaign, fitted: Fit) -> tuple[Campaign, Fit]:
    """Return the campaign that sizes are taken from (``Campaign.settled``), and the fit in it."""
    own = campaign.settled(fitted.errors)
    if own is campaign:
        return campaign, fitted
    kept = {*Unknowns(own, fitted.model).names} - {*fitted.names}
    return own, fit(own, fitted.model, kept=kept, refresh=True)


def calibrated(campaign: Campaign) -> Fit:
    """
    Return the fit of the unit's factors alone.

    Where the model stalls and the machine does not, or the other way round, a few seconds may
    keep all else from being fitted: if all else then fits down to the noise, they are left to
    the effects. What comes back is no event, but physics that shows only there.
    """
    plain = fit(campaign, Model(), iterations=5, refresh=True)
    if _fits(campaign, plain):
        return plain
    plain = _deepest(campaign, plain)
    trimmed = fit(campaign, Model(), iterations=8, refresh=True, trimmed=True)
    return trimmed if _fits(campaign, trimmed) and _is_one_event(campaign, trimmed) else plain


def _fits(campaign: Campaign, fitted: Fit) -> bool:
    return excess(campaign.ratios(fitted.errors, False)) < _FITS


def _deepest(campaign: Campaign, plain: Fit) -> Fit:
    """
    Return the fit of the unit in the deepest valley.

    The drive rings, and a fit may end a period of the ringing off. Then the model is better, if
    all else stays, where one factor has the other end of its tolerance: from there it goes on.
    """
    unknowns = Unknowns(campaign, plain.model)
    vector = unknowns.pack(plain.model)
    if not len(vector):
        return plain

    def at(place: int, end: float) -> tuple[float, Model]:
        moved = vector.copy()
        moved[place] = _END * end
        model = unknowns.unpack(moved)
        return cost_of(campaign, unknowns, moved, campaign.errors(model, to_fit=True)), model

    cost, start = min((at(place, end) for place in range(len(vector)) for end in (-1.0, 1.0)),
                      key=lambda item: item[0])
    if cost >= plain.cost:
        return plain
    return min(plain, fit(campaign, start, iterations=5, refresh=True),
               key=lambda item: item.cost)


def _is_one_event(campaign: Campaign, fitted: Fit) -> bool:
    """Tell whether the blocks that the fit leaves far off lie side by side."""
    worst = np.nanmax(list(campaign.blocks(fitted.errors, False).values()), axis=0)
    hot = np.flatnonzero(worst > _HOT)
    return len(hot) == 0 or int(hot[-1] - hot[0]) < _LONGEST


def _promise(campaign: Campaign, unknowns: Unknowns, vector: np.ndarray,
             errors: Sequence[np.ndarray], jacobian: np.ndarray) -> float:
    """Return by how much one more step would lower the cost if the problem were linear."""
    move = _step(campaign, unknowns, vector, errors, jacobian, 1e-6) - vector
    residual = campaign.training(errors)
    prior = vector[:unknowns.factors]
    after, prior_after = residual + jacobian @ move, prior + move[:unknowns.factors]
    return float(residual @ residual + prior @ prior - after @ after - prior_after @ prior_after)


def _trials(campaign: Campaign, unknowns: Unknowns, vector: np.ndarray,
            errors: Sequence[np.ndarray], jacobian: np.ndarray, damping: float, trimmed: bool,
            patient: bool) -> Iterator[tuple[np.ndarray, float]]:
    """
    Yield vectors to try until one lowers the cost, and the damping that they came from.

    All unknowns are moved at once; then the unit alone, and the effects alone: what shifts the
    drive's ringing by a part of its period bars the way for all else. ``patient``: then also one
    parameter after the other, over the ripples that such shifts leave in the cost.
    """
    def step(by: float, moved: slice = slice(None)) -> tuple[np.ndarray, float]:
        return _step(campaign, unknowns, vector, errors, jacobian, by, trimmed, moved), by

    for _ in range(_TRIES):
        yield step(damping)
        damping = max(damping * 100, 1e-3)
    count = len(vector)
    if not 0 < unknowns.factors < count:
        return
    for moved in (slice(unknowns.factors), slice(unknowns.factors, count)):
        for damping in (1e-6, 1e-3):
            yield step(damping, moved)
    for k in range(unknowns.factors, count if patient else 0):
        for share in _MOVES:
            trial = vector.copy()
            trial[k] = np.clip(vector[k] * (1 + share), unknowns.low[k], unknowns.high[k])
            if trial[k] != vector[k]:
                yield trial, 1e-3


def _step(campaign: Campaign, unknowns: Unknowns, vector: np.ndarray,
          errors: Sequence[np.ndarray], jacobian: np.ndarray, damping: float,
          trimmed: bool = False, moved: slice = slice(None)) -> np.ndarray:
    """Solve the linearised problem within the bounds for the unknowns that are moved."""
    residual = campaign.training(errors)
    if trimmed:
        used = campaign.without_events(residual)
        residual, jacobian = residual[used], jacobian[used]
    normal = jacobian.T @ jacobian
    gradient = jacobian.T @ residual
    prior = np.zeros(len(vector))
    prior[:unknowns.factors] = 1.0
    gradient = gradient + prior * vector
    normal = normal + np.diag(prior)
    normal = normal + np.diag(damping * np.diag(normal) + 1e-9)
    factor = np.linalg.cholesky(normal[moved, moved])
    target = np.linalg.solve(factor, -gradient[moved])
    solution = lsq_linear(factor.T, target, ((unknowns.low - vector - 1e-12)[moved],
                                             (unknowns.high - vector + 1e-12)[moved]))
    trial = vector.copy()
    trial[moved] += solution.x
    return np.clip(trial, unknowns.low, unknowns.high)


def at_limit(campaign: Campaign, key: str, value: float) -> bool:
    """Say whether a factor of the unit (natural logarithm) sits at the limit of its tolerance."""
    return abs(value) > (SIGMAS - 0.01) * campaign.tolerances[key]


def limited(campaign: Campaign, fitted: Fit) -> set[str]:
    """Return the quantities of the unit that are as far off as their tolerances let them."""
    return {key for key, value in fitted.model.factors.items() if at_limit(campaign, key, value)}


def at_its_end(campaign: Campaign, model: Model, name: str) -> bool:
    """Say whether a parameter of an effect sits at an end of what is plausible on a machine."""
    for place, declared in enumerate(catalogue(everything=True)[name].parameters):
        entry = campaign.parameter(name, declared.name)
        ends, value = (entry.low, entry.high), model.effects[name].get(entry.name, entry.neutral)
        # None of something, what formulas usually have, the ends of a bare number that shapes an
        # effect and may be other forms of it, and all of a share are as plausible as the rest.
        form = place > 0 and entry.unit == '1' and (entry.neutral in ends or ends == (0.0, 1.0))
        ends = [end for end in ends if end not in (0.0, entry.neutral, *entry.usual)]
        if not entry.fixed and not form and any(abs(value - end) <= _AT_END * abs(end)
                                                for end in ends):
            return True
    return False
