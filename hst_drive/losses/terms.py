# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which physical term the simple form lacks.

The simple form of a path is the better of the paper's trends written as laws (``forms``). Each
term of the catalogue is added to it; what counts is the error on left-out speeds, loads and
temperatures. A term is named when its size is beyond doubt, the held-out error falls by enough and
towards the noise, and no rival does as well; then the next is looked for.
"""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.losses.fit import Fit
from hst_drive.losses.forms import Form, Term
from hst_drive.losses.heldout import held_out, HeldOut
from hst_drive.losses.paths import fit_path, Path
import numpy as np

# Tried on tables of test/losses: beyond chance in some 15 trials per table (z), and a fall of the
# held-out error that no mere reshaping of a smooth law gives.
LEAST_Z = 4.5
LEAST_ERROR = 1.05          # of the simple form, over the noise
LEAST_FALL = 0.05
NEXT_FALL = 0.10            # of a further term in the same loss
LEAST_SHARE = 0.035         # of the whole loss, mean over the rows
LEAST_EXCESS = 0.35         # share of the excess over the noise that a term must remove
RIVAL_Z = 2.5

LEAKAGE = (
    Term('elastic_leakage', 'gaps that open with pressure, leakage with their height cubed',
         lambda c, x: (1.0 + c * x.p)**3 - 1.0, 'laminar x ((1 + s P)^3 - 1)', within=True,
         needs='load'),
    Term('elastic_leakage', 'gaps that open with pressure, whatever oil and speed',
         lambda c, x: c * x.p**3, 'c P^3', exponent=0.0, needs='load'),
    Term('orifice_leakage', 'turbulent leakage through an orifice',
         lambda c, x: c * np.sqrt(x.p), 'c P^0.5', exponent=2.0 / 3.0, needs='load'),
    Term('compressibility_flow', 'flow lost by decompression of the displaced volume',
         lambda c, x: c * x.p * x.w, 'c D w P'),
    Term('displacement_error', 'displacement larger or smaller than stated',
         lambda c, x: c * x.w, 'c D w', signed=True),
    Term('constant_leakage', 'leakage that depends on nothing, or an offset of a flow meter',
         lambda c, x: c * np.ones_like(x.p), 'c', exponent=0.0, signed=True),
)
TORQUE = (
    Term('hydrodynamic_drag', 'churning: drag in proportion to speed squared',
         lambda c, x: c * x.w**2, 'c w^2', exponent=5.0 / 3.0, needs='speed'),
    Term('bearing_friction', 'load-dependent bearing friction, growing with P^1.5',
         lambda c, x: c * x.p**1.5, 'c P^1.5', needs='load'),
    Term('bearing_friction', 'load-dependent bearing friction, growing with P^2',
         lambda c, x: c * x.p**2, 'c P^2', needs='load'),
    Term('load_speed_friction', 'friction in proportion to load and speed',
         lambda c, x: c * x.p * x.w, 'c P w', needs='speed'),
    Term('mixed_friction', 'mixed friction at low speed (Stribeck)',
         lambda c, x: c * np.exp(-3.0 * x.w), 'c exp(-3 w/w0)', needs='speed'),
    Term('mixed_friction', 'mixed friction at low speed, with the load',
         lambda c, x: c * x.p * np.exp(-3.0 * x.w), 'c P exp(-3 w/w0)', needs='speed'),
)
CATALOGUE = {'external': LEAKAGE, 'internal': LEAKAGE, 'total': LEAKAGE, 'torque': TORQUE}


class Trial(NamedTuple):
    """
    A form with a term: its fit, held-out errors, and what the term is worth.

    ``place`` is that of the term's coefficient among the parameters.
    """

    form: Form
    fit: Fit
    held: HeldOut
    term: Term
    place: int
    coefficient: float
    sd: float
    error: float

    @property
    def z(self) -> float:
        """Return the coefficient over its standard deviation."""
        return abs(self.coefficient) / self.sd if self.sd > 0 else 0.0


class Step(NamedTuple):
    """A term that was named: trial, rivals that do as well, share of the loss it makes."""

    trial: Trial
    rivals: tuple[str, ...]
    share: float
    share_low: float
    share_high: float


class Search(NamedTuple):
    """Result for a path: simple form, its fit and held-out error, steps, all first trials."""

    path: Path
    form: Form
    fit: Fit
    held: HeldOut
    error: float
    steps: tuple[Step, ...]
    trials: tuple[Trial, ...]
    forms: tuple[tuple[str, float], ...]
    kinds: tuple[str, ...]

    @property
    def best(self) -> tuple[Form, Fit, HeldOut]:
        """Return form, fit and held-out errors with the named terms."""
        last = self.steps[-1].trial if self.steps else self
        return last.form, last.fit, last.held

    @property
    def error_after(self) -> float:
        """Return the held-out error, over the noise, with the named terms."""
        return self.steps[-1].trial.error if self.steps else self.error


def _kinds(path: Path) -> tuple[str, ...]:
    """
    Return the variables whose left-out levels judge a term.

    Not the size: a motor that was never seen is off for other reasons. Nor, where others are
    there, one of two levels: what one level says about the other is mostly the prior.
    """
    known = [kind for kind in path.groups if kind != 'size']
    return tuple([kind for kind in known if path.groups[kind].max() > 1] or known
                 or path.groups)


def search(path: Path, most: int = 2) -> Search:
    """Look for the terms that a path's simple form lacks."""
    kinds = _kinds(path)
    judged = []
    for form in path.forms():
        fit = fit_path(path, form)
        held = held_out(path, form, fit)
        judged.append((held.rms(fit.weights, kinds), form, fit, held))
    judged.sort(key=lambda entry: entry[0])
    error, form, fit, held = judged[0]
    steps: list[Step] = []
    first: tuple[Trial, ...] = ()
    state = (error, form, fit, held)
    for step in range(most):
        # A term must mend every way of writing the simple form, not just the best one.
        bases = [entry[1:] for entry in judged] if not steps else [state[1:]]
        trials = [trial for base in bases for trial in _trials(path, *base)]
        if not steps:
            first = tuple(sorted(trials, key=lambda trial: trial.error))
        found = _named(path, state, trials, steps)
        if found is None:
            break
        steps.append(found)
        state = (found.trial.error, *found.trial[:3])
    return Search(path, form, fit, held, error, tuple(steps), first,
                  tuple((entry[1].id, entry[0]) for entry in judged), kinds)


def _trials(path: Path, form: Form, fit: Fit, held: HeldOut) -> list[Trial]:
    """Add each term of the catalogue to a form."""
    kinds = _kinds(path)
    before = held.rms(fit.weights, kinds)
    out = []
    for term in CATALOGUE[path.name]:
        if term in form.terms:
            continue
        wider = form.with_terms(term)
        place = len(form.own) + sum(len(old.parameters(form.several)) for old in form.terms)
        own = [entry.start for entry in term.parameters(form.several)]
        start = np.insert(fit.values, [place] * len(own), own)
        start[place] = 1e-3
        trial = fit_path(path, wider, start)
        coefficient = float(trial.values[place])
        sd, new, error = float(np.sqrt(trial.covariance[place, place])), held, before
        if not (coefficient == 0.0 or abs(coefficient) < LEAST_Z * sd):
            new = held_out(path, wider, trial, kinds)
            error = new.rms(trial.weights, kinds)
        out.append(Trial(wider, trial, new, term, place, coefficient, sd, error))
    return out


def _named(path: Path, state, trials: list[Trial], steps: list[Step]) -> Step | None:
    """Return the term that is beyond doubt, with its rivals, or None."""
    error = state[0]
    if error < least_error(path, state[1]):
        return None
    fall = NEXT_FALL if steps else LEAST_FALL
    named = {step.trial.term.id for step in steps}
    good = [trial for trial in trials
            if trial.z >= LEAST_Z and trial.term.id not in named
            and trial.error < error * (1.0 - fall)
            and error**2 - trial.error**2 > LEAST_EXCESS * max(error**2 - 1.0, 0.0)
            and abs(term_share(path, trial, trial.coefficient)) >= LEAST_SHARE]
    if not good:
        return None
    good.sort(key=lambda trial: trial.error)
    best = good[0]
    rivals = []
    for trial in good[1:]:
        if trial.term.id != best.term.id and trial.term.id not in rivals \
                and not _worse(trial, best, _kinds(path)):
            rivals.append(trial.term.id)
    share, low, high = _share(path, best)
    return Step(best, tuple(rivals), share, low, high)


def least_error(path: Path, form: Form) -> float:
    """
    Return the held-out error above which a form may lack something.

    Also a perfect form is off on left-out rows by what its parameters scatter; few rows, more.
    """
    return LEAST_ERROR * float(np.sqrt(1.0 + 2.0 * len(form.parameters()) / len(path.y)))


def _worse(trial: Trial, best: Trial, kinds: tuple[str, ...]) -> bool:
    """Return whether a trial's held-out errors are larger beyond chance (levels as blocks)."""
    gaps = []
    for kind in kinds:
        if kind in trial.held.error:
            error = best.held.error[kind]
            gaps.append(np.clip(trial.held.error[kind], -30, 30)**2 - np.clip(error, -30, 30)**2)
    gap = np.mean(gaps, axis=0)
    return bool(gap.mean() > RIVAL_Z * gap.std() / np.sqrt(len(gap)))


def _share(path: Path, trial: Trial) -> tuple[float, float, float]:
    """Return the share of the whole loss that a term makes, and its 95 % interval."""
    share = term_share(path, trial, trial.coefficient)
    wide = 1.96 * trial.sd / max(abs(trial.coefficient), 1e-12)
    ends = sorted((share * (1.0 - wide), share * (1.0 + wide)))
    return share, ends[0], ends[1]


def term_share(path: Path, trial: Trial, coefficient: float) -> float:
    """Return the share of the loss over all rows that a term with this coefficient makes."""
    with_it, without = trial.fit.values.copy(), trial.fit.values.copy()
    with_it[trial.place], without[trial.place] = coefficient, 0.0
    bare = trial.form(without, path.x)
    return float(np.sum(trial.form(with_it, path.x) - bare) / np.sum(np.abs(path.y)))
