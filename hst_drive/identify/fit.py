# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Fit of a model to a campaign: bounded Gauss-Newton with priors.

The unit's factors have Gaussian priors from the datasheet and are held within three sigma: with
tens of thousands of samples a prior alone is outvoted, and the factors would eat the physics.
"""
from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import count as count_from
import os
from types import MappingProxyType
from typing import (
    Callable, Collection, Iterable, Iterator, Mapping, NamedTuple, Sequence, TypeVar)

from hst_drive.effects import effect_of
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.linearised import Linearised
from hst_drive.identify.model import Model
from hst_drive.identify.unknowns import SIGMAS, Unknowns
import numpy as np

# Steps of the differences: of a tolerance for the unit's factors, relative for parameters. The
# drive rings: with steps that shift the ringing by a part of its period the fit gets stuck.
_NUDGE, _NUDGE_EFFECT = 0.05, 0.02
_TRIES = 4      # dampings of a step of all unknowns
PATIENT = 8     # steps of a fit that begins far from where it ends
_MOST, _FALLS = 20, 0.1     # steps; of the cost, that a step beyond those asked for must gain
_AS_SAID = 0.75  # of what a step should gain: below, the Jacobian has changed on the way
FORM = 0.04     # of a size, relative standard deviation: no machine follows a formula exactly
ErrorsAt = Callable[[np.ndarray], list[np.ndarray]]
_Item, _Found = TypeVar('_Item'), TypeVar('_Found')


def each(work: Callable[[_Item], _Found], items: Iterable[_Item]) -> Iterator[_Found]:
    """Yield what a function returns for each item, in their order: compiled work on all cores."""
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        yield from pool.map(work, items)


class Fit(NamedTuple):
    """
    A fitted model.

    ``cost`` is the sum of squares of the weighted errors and of the priors; ``jacobian``,
    ``names`` and ``information``, the Jacobian's square, belong to the scaled unknowns (see
    ``Unknowns``). The Jacobian may have been dropped (``light``). With another model in it
    (``only``, ``without``) it is where to start from: then model and ``columns`` count.
    """

    model: Model
    errors: list[np.ndarray]
    cost: float
    names: tuple[tuple[str, str], ...]
    jacobian: np.ndarray
    information: np.ndarray

    @property
    def columns(self) -> dict[tuple[str, str], np.ndarray]:
        """The columns of the Jacobian by (effect, parameter); effect '' for the unit."""
        return dict(zip(self.names, self.jacobian.T))

    def light(self) -> Fit:
        """Return the fit without its Jacobian: many of long logs would fill the memory."""
        return self._replace(jacobian=np.zeros((0, 0)))

    def only(self, names: Collection[str]) -> Fit:
        """Return the model and the columns to start from with some of the effects."""
        return self._replace(model=replace(self.model, effects={
            name: values for name, values in self.model.effects.items() if name in names}))

    def without(self, name: str) -> Fit:
        """Return the model and the columns to start from without an effect."""
        return self._replace(model=self.model.without(name))


def score(campaign: Campaign, fitted: Fit) -> float:
    """
    Return the held-out squared error plus the fit's cost; lower is better.

    Each parameter of an effect beyond its size costs the logarithm of the number of samples, what
    it may gain by chance (G. Schwarz, Estimating the dimension of a model, Annals of Statistics
    6, 1978).
    """
    own = [name for name, _ in fitted.names if name]
    samples = sum(len(column.fit) for column in campaign.columns)
    total = (len(own) - len({*own})) * float(np.log(max(samples, 1)))
    for error, column in zip(fitted.errors, campaign.columns):
        judged = (error * column.weight)[column.judge] * campaign.thinning(column)
        total += float(judged @ judged)
    return total + fitted.cost


def differences(campaign: Campaign, unknowns: Unknowns, vector: np.ndarray,
                errors: Sequence[np.ndarray], which: Sequence[int],
                errors_at: ErrorsAt) -> np.ndarray:
    """Return columns of the Jacobian of the weighted errors, by forward differences."""
    base = campaign.training(errors)

    def column(k: int) -> np.ndarray:
        step = _NUDGE if k < unknowns.factors else _NUDGE_EFFECT * max(abs(vector[k]), 0.3)
        if vector[k] + step > unknowns.high[k]:
            step = -step
        moved = vector.copy()
        moved[k] += step
        return (campaign.training(errors_at(moved)) - base) / step

    return np.array([*each(column, which)]).reshape(len(which), len(base)).T


def fit(campaign: Campaign, start: Model, *, iterations: int = 4,
        known: Mapping[tuple[str, str], np.ndarray] = MappingProxyType({}),
        refresh: bool = False, kept: Collection[tuple[str, str]] = (),
        progress: Callable[[str], None] = lambda text: None) -> Fit:
    """
    Fit the unit's factors and the parameters of the effects that are on.

    Where much of the Jacobian is ``known``, the rest is formed once, and each step corrects it by
    what the errors did (C. Broyden, A class of methods for solving nonlinear simultaneous
    equations, Mathematics of Computation 19, 1965); where that was not what it had said, the rest
    is formed anew. Else all of it is, in each step.

    Parameters
    ----------
    campaign : Campaign
        What to fit.
    start : Model
        Where to start.
    iterations : int
        Most Gauss-Newton steps; while the cost still falls fast more are taken.
    known : mapping of (str, str) to ndarray, optional
        Columns of the Jacobian from a nearby model (``Fit.columns``); saves most of the work.
    refresh : bool
        Form the whole Jacobian anew at the end, for intervals.
    kept : collection of (str, str)
        What stays as ``start`` has it (``Unknowns``).
    progress : callable
        Called with a text before each replay, from several threads; may raise to stop.

    """
    unknowns = Unknowns(campaign, start, kept)
    replays = count_from(1)

    def errors_at(vector: np.ndarray) -> list[np.ndarray]:
        progress(f'fitting: {next(replays)} replays')
        return campaign.errors(unknowns.unpack(vector), to_fit=True)

    def cost_of(vector: np.ndarray, residual: np.ndarray) -> float:
        prior = vector[:unknowns.factors]
        return float(residual @ residual + prior @ prior)

    def linearised() -> Linearised:
        return Linearised(residual, jacobian, vector, unknowns.factors)

    vector = np.clip(unknowns.pack(start), unknowns.low, unknowns.high)
    errors = errors_at(vector)
    residual = campaign.training(errors)
    cost = cost_of(vector, residual)
    everything = list(range(len(vector)))
    own = [k for k in everything if unknowns.names[k] not in known]
    jacobian = np.zeros((len(vector), len(residual))).T
    for k in {*everything} - {*own}:
        jacobian[:, k] = known[unknowns.names[k]]
    # Whether what is not known was formed, nearby or here.
    formed, here, damping, gain = not own, False, 1e-6, 0.0
    own = own or everything
    linear = linearised() if formed else None
    for done in range(_MOST if everything else 0):
        if done >= iterations and gain <= _FALLS * cost:
            break
        if not formed:
            jacobian[:, own] = differences(campaign, unknowns, vector, errors, own, errors_at)
            formed = here = True
            linear = linearised()
        reached = None
        for trial, damping in _trials(linear, unknowns, vector, damping):
            trial_errors = errors_at(trial)
            moved = campaign.training(trial_errors)
            trial_cost = cost_of(trial, moved)
            if trial_cost < cost:
                reached, damping = trial, max(damping / 10, 1e-9)
                break
        if reached is None:
            if here:
                break
            formed, damping = False, 1e-6
            continue
        gain, move = cost - trial_cost, reached - vector
        as_said = gain >= _AS_SAID * (linear.cost - linear.after(move)) > 0.0
        trusted, formed, here = here or as_said, bool(known) and as_said, False
        surprise = moved - residual - jacobian @ move
        jacobian += np.outer(move / (move @ move), surprise).T
        vector, errors, residual, cost = reached, trial_errors, moved, trial_cost
        # A first step along a bend gains little; where time is taken the next one may gain more.
        if trusted and gain < 1e-3 * cost + 0.5 and (done or not refresh):
            break
        linear = linearised()
        more = linear.cost - linear.after(_step(linear, unknowns, vector, 1e-6))
        if trusted and more < 1e-3 * cost + 0.5:
            break
    if refresh and not (here and own == everything):
        jacobian = differences(campaign, unknowns, vector, errors, everything, errors_at)
    model = unknowns.unpack(vector)
    return Fit(model, campaign.errors(model, known=errors), cost, unknowns.names, jacobian,
               jacobian.T @ jacobian)


def for_sizes(campaign: Campaign, fitted: Fit) -> tuple[Campaign, Fit]:
    """
    Return the campaign for sizes (``Campaign.for_sizes``), and the fit in it.

    The size of an adopted effect is one of the form in which it was adopted.
    """
    own = campaign.for_sizes(fitted.errors)
    if own is campaign:
        return campaign, fitted
    fitted = fitted._replace(model=replace(fitted.model, effects={name: {
        key: value if own.fits(name, key) or name not in own.adopted else own.off(name)[key]
        for key, value in values.items()} for name, values in fitted.model.effects.items()}))
    kept = {*Unknowns(own, fitted.model).names} - {*fitted.names}
    found = fit(own, fitted.model, kept=kept, refresh=True)
    # A shape that runs away when all rows count stays as it was found.
    ran = {(name, key) for name, values in found.model.effects.items()
           for key in at_ends(own, found.model, name) if key != next(iter(values))} & {
               *found.names}
    return own, fit(own, fitted.model, kept=kept | ran, refresh=True) if ran else found


def _trials(linear: Linearised, unknowns: Unknowns, vector: np.ndarray,
            damping: float) -> Iterator[tuple[np.ndarray, float]]:
    """
    Yield vectors to try until one lowers the cost, and the damping that they came from.

    All unknowns are moved at once; then the unit alone, and the effects alone: what shifts the
    drive's ringing by a part of its period bars the way for all else.
    """
    for _ in range(_TRIES):
        yield vector + _step(linear, unknowns, vector, damping), damping
        damping = max(damping * 100, 1e-3)
    if not 0 < unknowns.factors < len(vector):
        return
    for moved in (slice(unknowns.factors), slice(unknowns.factors, len(vector))):
        for damping in (1e-6, 1e-3):
            yield vector + _step(linear, unknowns, vector, damping, moved), damping


def _step(linear: Linearised, unknowns: Unknowns, vector: np.ndarray, damping: float,
          moved: slice = slice(None)) -> np.ndarray:
    """Return a step within the bounds."""
    move = linear.step(unknowns.low - vector, unknowns.high - vector, damping, moved)
    return np.clip(vector + move, unknowns.low, unknowns.high) - vector


def at_limit(campaign: Campaign, key: str, value: float) -> bool:
    """Say whether a number that tells the unit (``Model.unit``) is as far off as it may be."""
    return abs(value) > (SIGMAS - 0.01) * campaign.sigmas[key]


def limited(campaign: Campaign, fitted: Fit) -> list[str]:
    """Return the numbers that tell the unit (``Model.unit``) and are as far off as may be."""
    return [key for key, value in fitted.model.unit.items() if at_limit(campaign, key, value)]


def ended(campaign: Campaign, model: Model, names: Iterable[str]) -> bool:
    """Say whether one of some effects sits at an end of what is plausible on a machine."""
    return any(at_ends(campaign, model, name) for name in names)


def at_ends(campaign: Campaign, model: Model, name: str) -> list[str]:
    """Return the parameters of an effect at an end of what is plausible on a machine."""
    found = []
    for index, declared in enumerate(effect_of(name).parameters):
        entry = campaign.parameter(name, declared.name)
        ends, value = (entry.low, entry.high), model.effects[name].get(entry.name, entry.neutral)
        # Half of what formulas are off machines does not tell a value from an end.
        # None of something, what formulas usually have, the ends of a bare number that shapes an
        # effect and may be other forms of it, and all of a share are as plausible as the rest.
        form = index > 0 and entry.unit == '1' and (entry.neutral in ends or ends == (0.0, 1.0))
        ends = [end for end in ends if end not in (0.0, entry.neutral, *entry.usual)]
        if not entry.fixed and not form and any(abs(value - end) <= 0.5 * FORM * abs(end)
                                                for end in ends):
            found.append(entry.name)
    return found
