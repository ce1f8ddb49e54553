# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Trials of what is not listed: formulas fitted in a model, and whether they are better."""
from __future__ import annotations

from math import log
from types import MappingProxyType
from typing import Callable, Container, Iterable, Mapping, NamedTuple

from hst_drive.channels import CHANNELS
from hst_drive.diagnose.result import Unknown
from hst_drive.diagnose.unknown import worth
from hst_drive.effects.formula import FORMULAS, TEXTS, values, written
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.evidence import CREDIBLE, DECIDED
from hst_drive.identify.fit import Fit, fit
from hst_drive.identify.judge import excess, parts, PRACTICAL, REST
from hst_drive.identify.model import Model
from hst_drive.identify.search import Candidate, Search
from hst_drive.identify.weigh import log_odds_of
import numpy as np

_START = 1e-3           # of a formula's typical size: where its fit starts


class FreeForm(NamedTuple):
    """
    A formula that is tried: what it is, its effect, terms, and what it would be told as.

    ``unknown`` is None if what is left without the effect says best what it is.
    """

    what: str
    formula: str
    terms: tuple[tuple[str, ...], ...]
    unknown: Unknown | None = None


class Trial(NamedTuple):
    """
    Something that is not listed: what it is, its fit, and what it would be told as.

    ``free_form`` is the formula that carries it, if one does.
    """

    what: str
    fit: Fit
    unknown: Unknown | None
    free_form: FreeForm | None = None


def with_start(model: Model, form: FreeForm) -> Model:
    """Return a model with next to nothing of a formula, where its fit starts."""
    size = _START * FORMULAS[form.formula].size.typical
    return model.with_effect(form.formula, values(
        form.formula, [(size, term) for term in form.terms]))


def fitted_forms(campaign: Campaign, model: Model, forms: Iterable[FreeForm],
                 known: Mapping[tuple[str, str], np.ndarray] = MappingProxyType({})
                 ) -> list[Trial]:
    """Fit a model with each formula that the rig has not adopted and that these logs may show."""
    return [Trial(form.what, fit(campaign, with_start(model, form), known=known), form.unknown,
                  form)
            for form in forms if form.formula not in campaign.rig.effects
            and (form.unknown is None or form.unknown.signal in campaign.signals)]


def better(search: Search, best: Candidate, trial: Fit, campaign: Campaign,
           left: Container[str], simpler: bool = False) -> bool:
    """
    Say whether something that is not listed, fitted in a campaign, is a better answer than a set.

    It leaves nothing unexplained, or little, and the logs are far likelier with it. Where the set
    leaves something (``left``) they need not be, if the evidence does not speak against it; where
    the set is not as simple, they must only not be far less likely.
    """
    least = -CREDIBLE if simpler else -log(DECIDED) if left else CREDIBLE
    if log_odds_of(search, best, campaign, trial, False) <= least:
        return False
    if not search.unexplained(best._replace(fit=trial)):
        return True
    before, after = (beyond_noise(campaign, entry) for entry in (best.fit, trial))
    return 0.0 < before and after <= REST * before


def beyond_noise(campaign: Campaign, fitted: Fit) -> float:
    """Return the squared error of a fit beyond the noise, in squared floors."""
    return sum(excess(campaign.ratios(fitted.errors, part)) for part in parts(campaign))


def how_much_better(search: Search, best: Candidate, trial: Fit) -> str:
    """Return by what share the squared error falls, of the signal where most, for people."""
    share, signal = max(((value, name) for part in parts(search.campaign) for name, value in
                         search.taken(best, best._replace(fit=trial), part).items()),
                        default=(0.0, ''))
    return 'explains as much alone' if share < PRACTICAL else (
        f'leaves {100 * share:.0f} % less squared error of {CHANNELS[signal].title}')


def as_unknown(campaign: Campaign, bare: Callable[[], Fit], trial: Trial) -> Unknown | None:
    """Return what a trial would be told as, with the formula to adopt over a bare model."""
    if trial.unknown is None or trial.free_form is None:
        return trial.unknown
    formula, terms = trial.free_form.formula, trial.free_form.terms
    own = trial.fit.model.effects[formula]
    return trial.unknown._replace(
        expression=written(trial.unknown.expression, [
            (own[f'coefficient_{index}'], [TEXTS[variable] for variable in term])
            for index, term in enumerate(terms, 1)]),
        formula=worth(campaign, bare(), formula, trial.fit))
