# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What could stand in the place of an effect that was found."""
from __future__ import annotations

from hst_drive.effects import catalogue
from hst_drive.identify.evidence import CREDIBLE
from hst_drive.identify.fit import at_ends
from hst_drive.identify.judge import PRACTICAL
from hst_drive.identify.score_test import score_test
from hst_drive.identify.search import Candidate, Search
from hst_drive.identify.weigh import log_odds
import numpy as np

RIVALS_TRIED = 6


def alternatives(search: Search, best: Candidate, name: str) -> tuple[str, ...]:
    """Return the effects that could stand in the place of one of those found, likeliest first."""
    kept = best.fit.without(name)
    others = tuple(entry for entry in best.names if entry != name)
    scores = {entry: search.single(entry).score for entry in search.candidates
              if entry not in best.names}
    singles = sorted(scores, key=scores.get)
    # Who leaves hardly more than the best is tried, too.
    limit = best.score + PRACTICAL * (search.baseline.score - best.score)
    alike = [entry for entry in singles
             if entry in catalogue()[name].alike or scores[entry] <= limit]
    if others:
        # Beside others the best alone may be what explains those.
        fewer = search.try_all([(others, kept)], 'trying rivals')[0]
        share = {entry: found for found, entry in score_test(search, fewer)}
        singles.sort(key=lambda entry: -share[entry])
    tried = dict.fromkeys((*singles[:RIVALS_TRIED], *alike))
    # Alone they were fitted from a unit that was calibrated without any effect: try from here.
    found = search.try_all([((*others, entry), kept) for entry in tried], 'trying rivals',
                           again=True)
    held = [(new, entry) for new, entry in zip(tried, found)
            if not at_ends(search.campaign, entry.fit.model, new)]
    odds = log_odds(search, [best, *(entry for _, entry in held)])[1:]
    return tuple(held[index][0] for index in np.argsort(-odds) if odds[index] >= -CREDIBLE)
