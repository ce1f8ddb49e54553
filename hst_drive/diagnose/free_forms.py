# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Trials of what is not listed: formulas fitted in a model, and whether they are better."""
from __future__ import annotations

from types import MappingProxyType
from typing import Callable, Mapping, NamedTuple

from hst_drive.diagnose.result import Unknown
from hst_drive.diagnose.unknown import Carried, worth
from hst_drive.effects.formula import FORMULAS, TEXTS, values, written
from hst_drive.identify.campaign import Campaign, Model
from hst_drive.identify.evidence import CREDIBLE
from hst_drive.identify.fit import Fit, fit, score
from hst_drive.identify.judge import (
    contribution, excess, FORM_SHARE, IN_EVENTS, PRACTICAL, SIGNIFICANT)
from hst_drive.identify.search import Candidate, Search
from hst_drive.identify.weigh import log_odds_unlisted
from hst_drive.measure.run import CHANNELS
import numpy as np

# Standard errors: more than for an effect of the list, since it has a freer form and is
# judged on what it was fitted to as well.
_SURE = 5.0
REST = 0.1         # of the excess squared error: what a formula in the place of others may leave
_DEARER = 3.0           # times what other signals lose: it need not be right in all
PATIENT = 8             # steps of a fit that gets the same chance as another
_FAINT = 1e-3           # of a formula's typical size: where its fit starts


class Freer(NamedTuple):
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

    ``freer`` is the formula that carries it, if one does.
    """

    what: str
    fit: Fit
    unknown: Unknown | None
    freer: Freer | None = None


def faint(model: Model, freer: Freer) -> Model:
    """Return a model with next to nothing of a formula, where its fit starts."""
    size = _FAINT * FORMULAS[freer.formula].parameters[0].typical
    return model.with_effect(freer.formula, values(
        freer.formula, [(size, term) for term in freer.terms]))


def fitted_freer(campaign: Campaign, model: Model, freer: Freer,
                 known: Mapping[tuple[str, str], np.ndarray] = MappingProxyType({})
                 ) -> Trial | None:
    """Fit a model with a formula; None if the rig has adopted that already."""
    if freer.formula in campaign.rig.effects:
        return None
    return Trial(freer.what, fit(campaign, faint(model, freer), known=known), freer.unknown, freer)


def beaten(search: Search, best: Candidate, fitted: Fit) -> tuple[str, float] | None:
    """Return the signal in which a trial is clearly better, and by what share of its square."""
    trial = Candidate((), fitted, score(search.campaign, fitted))
    if trial.score >= best.score:
        return None
    shares: dict[str, float] = {}
    for held_out in (False, True):
        found = search.gain(best, trial, held_out)
        done = contribution(search.campaign, search.base, best.fit, held_out)
        lost = -sum(min(amount, 0.0) for amount in found.amount.values())
        for name, share in found.share.items():
            # A few quick steps may be all that shows how a pump answers: then blocks count.
            sure = found.sigma[name] >= _SURE or (
                share >= IN_EVENTS and found.votes[name] >= SIGNIFICANT)
            if share >= PRACTICAL and sure and found.amount[name] >= max(
                    PRACTICAL, (FORM_SHARE * done[name])**2, _DEARER * lost):
                shares[name] = max(share, shares.get(name, 0.0))
    return max(shares.items(), key=lambda item: item[1], default=None)


def sure(search: Search, best: Candidate, trial: Fit) -> tuple[str, float] | None:
    """Ask ``beaten`` once the set has had the same chance: fitted from where that ended."""
    if not beaten(search, best, trial):
        return None
    effects = {key: trial.model.effects.get(key, own)
               for key, own in best.fit.model.effects.items()}
    fitted = fit(search.campaign, Model(effects, trial.model.factors), iterations=PATIENT)
    again = Candidate(best.names, fitted, score(search.campaign, fitted))
    return beaten(search, min(best, again, key=lambda item: item.score), trial)


def as_much(search: Search, best: Candidate, trial: Fit, campaign: Campaign) -> bool:
    """Say whether a trial, fitted in a campaign, leaves nothing and a set is not far likelier."""
    return not search.unexplained(best._replace(fit=trial)) and log_odds_unlisted(
        search, best, campaign, trial) >= -CREDIBLE


def much_left(search: Search, best: Candidate, fitted: Fit, rest: float = REST) -> bool:
    """Say whether a trial leaves more than formulas are off machines."""
    if not search.unexplained(best._replace(fit=fitted)):
        return False
    before, after = (excess(search.campaign.ratios(entry.errors, True))
                     for entry in (best.fit, fitted))
    return after > rest * before


def share_of(beaten: tuple[str, float]) -> str:
    """Return what ``beaten`` found, for people."""
    signal, share = beaten
    return f'{100 * share:.0f} % less squared error of {CHANNELS[signal].title}'


def told_as(campaign: Campaign, bare: Callable[[], Fit], trial: Trial) -> Unknown | None:
    """Return what a trial would be told as, with the formula to adopt over a bare model."""
    if trial.unknown is None or trial.freer is None:
        return trial.unknown
    formula, terms = trial.freer.formula, trial.freer.terms
    own = trial.fit.model.effects[formula]
    return trial.unknown._replace(
        expression=written(trial.unknown.expression, [
            (own[f'coefficient_{place}'], [TEXTS[variable] for variable in term])
            for place, term in enumerate(terms, 1)]),
        formula=worth(campaign, bare(), Carried(formula, trial.fit)))
