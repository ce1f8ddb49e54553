# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The missing term in words, with its size: none, missing_term or ambiguous."""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.losses.fit import Fit
from hst_drive.losses.forms import Form
from hst_drive.losses.ordinary import Ordinary, ordinary
from hst_drive.losses.study import Study
from hst_drive.losses.terms import (
    LEAKAGE, least_error, LEAST_FALL, LEAST_SHARE, LEAST_Z, Step, term_share, TORQUE)
import numpy as np

PLACE = {'external': 'leakage to the case', 'internal': 'leakage between the ports',
         'total': 'leakage', 'torque': 'torque loss'}
# A smooth law that left-out rows miss by more than this, over the noise, lacks something.
LACKING = 1.35
LEAST_ROWS = 20
_FITS = 1.1         # forms whose error is within this of the best one's


class Missing(NamedTuple):
    """
    A term that the simple form lacks.

    ``size``, ``low``, ``high``: loss that the term makes at the table's highest pressure and
    speed in its middle motor (m^3/s or N.m), 95 %; ``share`` of the whole loss, mean over rows.
    ``reason``: a form of its own, or why an ordinary term stands out.
    """

    id: str
    title: str
    path: str
    equation: str
    size: float
    low: float
    high: float
    unit: str
    share: float
    share_low: float
    share_high: float
    error_before: float
    error_after: float
    rivals: tuple[str, ...]
    reason: str


class Verdict(NamedTuple):
    """
    What is missing.

    ``verdict``: none, missing_term, ambiguous, unknown (something is missing that the catalogue
    has not) or not_decidable (too few rows). ``would_show``: share of the loss, by path and term,
    from which a term would have been named; ``not_observable``: term and what the table lacks.
    """

    verdict: str
    sentence: str
    terms: tuple[Missing, ...]
    would_show: dict[str, dict[str, float]]
    not_observable: dict[str, str]


def verdict(study: Study) -> Verdict:
    """Return what the table says is missing in the simple form."""
    blind = not_observable(study)
    if len(study.bench) < LEAST_ROWS:
        return Verdict('not_decidable', f'Whether a term is missing cannot be told from '
                       f'{len(study.bench)} rows; measure at least {LEAST_ROWS} operating points, '
                       'three levels of speed and load among them.', (), {}, blind)
    terms = []
    for name, entry in study.searches.items():
        before = entry.error
        for step in entry.steps:
            terms.append(_missing(study, name, step, before))
            before = step.trial.error
        stands_out = ordinary(entry, study.scales.pressure)
        if stands_out:
            terms.append(_ordinary(study, name, stands_out))
    would = {name: {key: share for key, share in known.items() if key not in blind}
             for name, known in would_show(study).items()}
    reasons = '; '.join(f'{key} ({why})' for key, why in blind.items())
    hidden = f' Not observable here: {reasons}.' if blind else ''
    left = {name: entry.error_after for name, entry in study.searches.items()
            if entry.error_after > LACKING}
    if not terms and not left:
        return Verdict('none', 'No term is missing: what the simple form leaves on left-out rows '
                       f'is the noise of the sensors.{hidden}', (), would, blind)
    parts = [f'{term.id} ({term.title}{_why(term)}) in the {PLACE[term.path]}, '
             f'{100 * term.share:.3g} % of it (95 %: {100 * term.share_low:.3g} to '
             f'{100 * term.share_high:.3g}); the error on '
             f'left-out rows falls from {term.error_before:.2f} to {term.error_after:.2f} times '
             'the noise' + (f'; {" or ".join(term.rivals)} would do as well'
                            if term.rivals else '') for term in terms]
    if left:
        worst = max(left, key=left.__getitem__)
        parts.append(f'the {PLACE[worst]} stays {left[worst]:.2f} times the noise off on left-out '
                     'rows, and no term of the catalogue explains that')
    word = 'ambiguous' if any(term.rivals for term in terms) else 'missing_term'
    text = '; and '.join(parts)
    if not terms:
        return Verdict('unknown', f'Cannot tell which term is missing: {text}.{hidden}', (),
                       would, blind)
    start = 'The simple form lacks ' if word == 'missing_term' else \
        'The simple form lacks a term, and the table cannot tell for certain which: '
    return Verdict(word, f'{start}{text}.{hidden}', tuple(terms), would, blind)


def not_observable(study: Study) -> dict[str, str]:
    """Return the terms that a table cannot show by form, and what it lacks."""
    out = {}
    for variable in ('speed', 'load'):
        levels = len(study.bench.levels(variable)[1])
        if levels < 3:
            out |= {term.id: f'{levels} level{"s" if levels > 1 else ""} of {variable}, three '
                    'needed' for term in (*TORQUE, *LEAKAGE) if term.needs == variable}
    return out


def _why(term: Missing) -> str:
    return '' if term.reason == 'a form of its own' else f'; {term.reason}'


def _missing(study: Study, name: str, step: Step, before: float) -> Missing:
    trial = step.trial
    return Missing(trial.term.id, trial.term.title, name, trial.term.text,
                   *_size(study, name, trial.form, trial.fit, trial.place, trial.sd),
                   step.share, step.share_low, step.share_high, before, trial.error, step.rivals,
                   'a form of its own')


def _ordinary(study: Study, name: str, found: Ordinary) -> Missing:
    path, values = study.searches[name].path, found.fit.values
    without = values.copy()
    without[found.place] = 0.0
    whole = found.form(values, path.x)
    share = float(np.sum(whole - found.form(without, path.x)) / np.sum(whole))
    wide = 1.96 * found.sd / values[found.place]
    return Missing(found.id, found.title, name, found.equation,
                   *_size(study, name, found.form, found.fit, found.place, found.sd),
                   share, share * (1 - wide), share * (1 + wide), found.error_before,
                   found.error_after, (), found.reason)


def _size(study: Study, name: str, form: Form, fit: Fit, place: int,
          sd: float) -> tuple[float, float, float, str]:
    """Return the loss that a parameter makes at the table's corner, its interval and unit."""
    path = study.searches[name].path
    corner = path.x.rows([0])._replace(
        p=np.array([path.x.p.max()]), w=np.array([path.x.w.max()]), n=np.ones(1), d=np.ones(1),
        unit=np.zeros((1, path.x.unit.shape[1])))
    without = fit.values.copy()
    without[place] = 0.0
    size = float((form(fit.values, corner) - form(without, corner))[0]) * path.unit
    wide = 1.96 * sd / abs(fit.values[place])
    low, high = sorted((size * (1 - wide), size * (1 + wide)))
    return size, low, high, 'N.m' if name == 'torque' else 'm^3/s'


def would_show(study: Study) -> dict[str, dict[str, float]]:
    """
    Return, by path and term, the share of the loss from which a term would have been named.

    From the standard deviation of its coefficient: the size that is beyond doubt and raises the
    error of the form without it by enough. Each way of writing the simple form that fits takes up
    its own part of a term: the largest size over them counts.
    """
    out: dict[str, dict[str, float]] = {}
    for name, entry in study.searches.items():
        named = {step.trial.term.id for step in entry.steps}
        fitting = [form for form, error in entry.forms if error < _FITS * entry.error]
        error, rows = entry.error_after, len(entry.path.y)
        lifted = max(least_error(entry.path, entry.best[0]), error / (1.0 - LEAST_FALL))**2 \
            - error**2
        z = max(LEAST_Z, float(np.sqrt(rows * max(lifted, 0.0))))
        known: dict[str, dict[str, float]] = {}
        for trial in entry.trials:
            form = trial.form.id.partition('+')[0]
            if trial.term.id in named or trial.sd <= 0 or form not in fitting:
                continue
            share = max(LEAST_SHARE, abs(term_share(entry.path, trial, z * trial.sd)))
            shares = known.setdefault(trial.term.id, {})
            shares[form] = min(share, shares.get(form, np.inf))
        if known:
            # 1: could be all of the loss and would not show.
            out[name] = {term: min(max(shares.values()), 1.0) for term, shares in known.items()}
    return out
