# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The missing term in words, with its size: none, missing_term or ambiguous."""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.losses.study import Study
from hst_drive.losses.terms import Step
import numpy as np

PLACE = {'external': 'leakage to the case', 'internal': 'leakage between the ports',
         'total': 'leakage', 'torque': 'torque loss'}
# A smooth law that left-out rows miss by more than this, over the noise, lacks something.
LACKING = 1.35


class Missing(NamedTuple):
    """
    A term that the simple form lacks.

    ``size``, ``low``, ``high``: loss that the term makes at the table's highest pressure and
    speed in its middle motor (m^3/s or N.m), 95 %; ``share`` of the whole loss, mean over rows.
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


class Verdict(NamedTuple):
    """``verdict``: none, missing_term, ambiguous or unknown; sentence; terms; limits."""

    verdict: str
    sentence: str
    terms: tuple[Missing, ...]
    would_show: dict[str, dict[str, float]]


def verdict(study: Study) -> Verdict:
    """Return what the table says is missing in the simple form."""
    terms = []
    for name, entry in study.searches.items():
        before = entry.error
        for step in entry.steps:
            terms.append(_missing(study, name, step, before))
            before = step.trial.error
    would = would_show(study)
    left = {name: entry.error_after for name, entry in study.searches.items()
            if entry.error_after > LACKING}
    if not terms and not left:
        return Verdict('none', 'No term is missing: what the simple form leaves on left-out rows '
                       'is the noise of the sensors.', (), would)
    parts = [f'{term.id} ({term.title}) in the {PLACE[term.path]}, {100 * term.share:.3g} % of '
             f'it (95 %: {100 * term.share_low:.3g} to {100 * term.share_high:.3g}); the error on '
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
        return Verdict('unknown', f'Cannot tell which term is missing: {text}.', (), would)
    start = 'The simple form lacks ' if word == 'missing_term' else \
        'The simple form lacks a term, and the table cannot tell for certain which: '
    return Verdict(word, f'{start}{text}.', tuple(terms), would)


def _missing(study: Study, name: str, step: Step, before: float) -> Missing:
    trial, unit = step.trial, study.searches[name].path.unit
    x = study.searches[name].path.x
    # At the corner of the table, in a motor of the middle size.
    corner = x.rows([0])._replace(
        p=np.array([x.p.max()]), w=np.array([x.w.max()]), n=np.ones(1), d=np.ones(1),
        unit=np.zeros((1, x.unit.shape[1])))
    place = next(index for index, parameter in enumerate(trial.form.parameters())
                 if parameter.name == trial.term.id
                 and trial.fit.values[index] == trial.coefficient)
    without = trial.fit.values.copy()
    without[place] = 0.0
    size = float((trial.form(trial.fit.values, corner) - trial.form(without, corner))[0]) * unit
    wide = 1.96 * trial.sd / abs(trial.coefficient)
    low, high = sorted((size * (1 - wide), size * (1 + wide)))
    return Missing(trial.term.id, trial.term.title, name, trial.term.text, size, low, high,
                   'N.m' if name == 'torque' else 'm^3/s', step.share, step.share_low,
                   step.share_high, before, trial.error, step.rivals)


def would_show(study: Study) -> dict[str, dict[str, float]]:
    """
    Return, by path and term, the share of the loss from which a term would have been named.

    From the standard deviation of its coefficient: the size beyond doubt.
    """
    from hst_drive.losses.terms import LEAST_Z, term_share

    out: dict[str, dict[str, float]] = {}
    for name, entry in study.searches.items():
        named = {step.trial.term.id for step in entry.steps}
        for trial in entry.trials:
            if trial.term.id in named or trial.sd <= 0:
                continue
            share = abs(term_share(entry.path, trial, LEAST_Z * trial.sd))
            known = out.setdefault(name, {})
            known[trial.term.id] = min(share, known.get(trial.term.id, np.inf))
    return out
