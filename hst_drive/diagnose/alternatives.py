# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What could stand in the place of an effect that was found."""
from __future__ import annotations

from hst_drive.diagnose.fit import Fit
from hst_drive.diagnose.judge import contribution
from hst_drive.diagnose.search import at_its_end, Candidate, Search
from hst_drive.effects import catalogue

_RIVALS_TRIED = 6
_BEATEN_SHARE = 0.03    # of the held-out squared error: what tells two explanations apart
_BEATEN_SIGMA = 3.0
_BEATEN_FORM = 0.06     # of what the effect does: the formula's own uncertainty
_BEATEN_SCORE = 12.0    # twice the natural logarithm of the likelihood ratio


def _beaten(search: Search, best: Candidate, rival: Candidate, without: Fit,
            uncertain: float) -> bool:
    """
    Say whether the data tell the rival from the best explanation.

    ``without`` is the best explanation with the effect in question taken out: a difference that
    another formula of that effect could make, a share ``uncertain`` of what it does, does not
    count. Rivals have about as many parameters, so that what was fitted may judge, too.
    """
    for held_out in (True, False):
        found = search.gain(rival, best, held_out)
        done = contribution(search.campaign, without, best.fit, held_out)
        form = sum((uncertain * value)**2 for value in done.values())
        if sum(max(value, 0.0) for value in found.amount.values()) >= form and any(
                found.sigma[name] >= _BEATEN_SIGMA and found.share[name] >= _BEATEN_SHARE
                for name in found.share):
            return True
    return False


def alternatives(search: Search, best: Candidate, name: str) -> tuple[str, ...]:
    """Return the effects that could stand in the place of one of those found."""
    kept = best.fit.model.without(name)
    without = best.fit._replace(errors=search.campaign.errors(kept))
    others = tuple(entry for entry in best.names if entry != name)
    singles = sorted((entry for entry in search.candidates
                      if entry not in best.names), key=lambda entry: search.single(entry).score)
    if others:
        # Beside others the best alone may be what explains those: the most alike come first.
        likeness = search.likeness(name)
        singles.sort(key=lambda entry: -likeness(entry))
    alike = [entry for entry in singles if entry in catalogue()[name].alike]
    tried = dict.fromkeys((*singles[:_RIVALS_TRIED], *alike))
    # Alone they were fitted from a unit that was calibrated without any effect: try from here.
    found = search.try_all([((*others, entry), kept) for entry in tried], 'trying rivals',
                           again=True)
    standing = []
    for rival in sorted(found, key=lambda item: item.score):
        entry = next(entry for entry in rival.names if entry not in others)
        uncertain = _BEATEN_FORM
        if entry in alike:
            uncertain = max(catalogue()[one].formula_error for one in (name, entry))
        if rival.score - best.score <= _BEATEN_SCORE or not (
                at_its_end(rival.fit.model, entry)
                or _beaten(search, best, rival, without, uncertain)):
            standing.append(entry)
    return tuple(standing)
