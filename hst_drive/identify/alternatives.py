# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What could stand in the place of an effect that was found."""
from __future__ import annotations

from typing import NamedTuple, Sequence

from hst_drive.effects import catalogue
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit
from hst_drive.identify.judge import contribution
from hst_drive.identify.score_test import score_test
from hst_drive.identify.search import at_its_end, Candidate, Search

_RIVALS_TRIED = 6
_NEARLY = 0.1           # of what the best takes away: who leaves no more is tried, too
BEATEN_SHARE = 0.03    # of the held-out squared error: what tells two explanations apart
BEATEN_SIGMA = 3.0
_BEATEN_FORM = 0.06     # of what the effect does: the formula's own uncertainty
_AS_GOOD = 0.06        # of the squared error: less is no sign of what more parameters stand for
BEATEN_SCORE = 12.0    # twice the natural logarithm of the likelihood ratio


class Gap(NamedTuple):
    """
    What lies between the best explanation and a rival.

    ``sigma`` is the greatest significance of a signal that they leave differently enough;
    ``forms`` the squared difference over what another formula of the effect could make.
    """

    sigma: float
    forms: float


def gaps(search: Search, best: Candidate, rival: Candidate, without: Fit,
         uncertain: float) -> list[Gap]:
    """
    Return what the data show between the best explanation and a rival.

    ``without`` is the best explanation with the effect in question taken out: a difference that
    another formula of that effect could make, a share ``uncertain`` of what it does, does not
    count. Rivals have about as many parameters, so that what was fitted may judge, too: the first
    gap is that on held-out, the second that on fitted data.
    """
    found = []
    for held_out in (True, False):
        gain = search.gain(rival, best, held_out)
        done = contribution(search.campaign, without, best.fit, held_out)
        form = sum((uncertain * value)**2 for value in done.values())
        found.append(Gap(
            max((gain.sigma[name] for name in gain.share if gain.share[name] >= BEATEN_SHARE),
                default=0.0),
            sum(max(value, 0.0) for value in gain.amount.values()) / max(form, 1e-12)))
    return found


def uncertainty(names: Sequence[str], others: Sequence[str]) -> float:
    """Return the share of what effects do by which formulas may differ beside these others."""
    alike = [max(catalogue()[name].formula_error, catalogue()[other].formula_error)
             for name in names for other in others if other in catalogue()[name].alike]
    return max(alike, default=_BEATEN_FORM)


def plainer(search: Search, best: Candidate) -> Candidate:
    """
    Return the best with what is the plainer explanation in the place of one that looks alike.

    That is one that these logs need not turn both ways to show, an effect of fewer parameters, or
    a known one that has changed: of a machine that is known to have a fault it is likelier that
    this grows than that another one comes up. Only where it leaves as little as the other, held
    out and fitted.
    """
    for name in best.names:
        kept = best.fit.model.without(name)
        others = tuple(entry for entry in best.names if entry != name)
        rivals = [search.refine(rival) for rival in search.try_all(
            [((*others, entry), kept) for entry in search.candidates
             if entry not in best.names and _comes_first(search.campaign, entry, name)],
            'trying rivals', again=True)]
        as_good = [rival for rival in rivals if _leaves_as_little(search, best, rival)]
        if as_good:
            # In its place a plainer one still may do.
            return plainer(search, min(as_good, key=lambda rival: rival.score))
    return best


def _comes_first(campaign: Campaign, entry: str, name: str) -> bool:
    first, second = catalogue()[entry], catalogue()[name]
    if name in campaign.adopted or entry in campaign.adopted:
        return name not in campaign.adopted
    return entry in second.alike and (first.both_ways, len(first.parameters)) < (
        second.both_ways, len(second.parameters))


def _leaves_as_little(search: Search, best: Candidate, rival: Candidate) -> bool:
    for held_out in (True, False):
        gain = search.gain(rival, best, held_out)
        if any(share >= _AS_GOOD and gain.sigma[name] >= BEATEN_SIGMA
               for name, share in gain.share.items()):
            return False
    return True


def alternatives(search: Search, best: Candidate, name: str) -> tuple[str, ...]:
    """Return the effects that could stand in the place of one of those found."""
    kept = best.fit.model.without(name)
    without = best.fit._replace(errors=search.campaign.errors(kept))
    others = tuple(entry for entry in best.names if entry != name)
    scores = {entry: search.single(entry).score for entry in search.candidates
              if entry not in best.names}
    singles = sorted(scores, key=scores.get)
    limit = best.score + _NEARLY * (search.baseline.score - best.score)
    alike = [entry for entry in singles
             if entry in catalogue()[name].alike or scores[entry] <= limit]
    if others:
        # Beside others the best alone may be what explains those.
        fewer = search.try_all([(others, kept)], 'trying rivals')[0]
        share = {entry: found for found, entry in score_test(search, fewer)}
        singles.sort(key=lambda entry: -share[entry])
    tried = dict.fromkeys((*singles[:_RIVALS_TRIED], *alike, *search.campaign.doubles(name)))
    # Alone they were fitted from a unit that was calibrated without any effect: try from here.
    found = search.try_all([((*others, entry), kept) for entry in tried], 'trying rivals',
                           again=True)
    standing = []
    for rival in sorted(found, key=lambda item: item.score):
        entry = next(entry for entry in rival.names if entry not in others)
        if rival.score - best.score <= BEATEN_SCORE or not (
                at_its_end(search.campaign, rival.fit.model, entry)
                or any(gap.sigma >= BEATEN_SIGMA and gap.forms >= 1.0 for gap in gaps(
                    search, best, rival, without, uncertainty((name,), (entry,))))):
            standing.append(entry)
    return tuple(standing)
