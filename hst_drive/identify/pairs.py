# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Two effects in the place of one, or of two, that leave what formulas could be blamed for.

No machine follows one formula exactly, so that a share of what an effect does may remain
(``judge``). Two effects that together look like one other leave such a rest as well: a friction
that falls with speed and a drag that rises look like a constant one. Where two bring everything
down to the noise, on the logs that were fitted and on those held out, and what was found does on
neither, they are the better answer.
"""
from __future__ import annotations

from hst_drive.identify.judge import AT_NOISE, CLEAN_FITTED, contribution, SIGNIFICANT
from hst_drive.identify.search import Candidate, Search
from hst_drive.identify.standing import standing

_SINGLES = 6        # that are combined, the best ones
_FORM = 0.05        # of what an effect does: less is left by another formula of it
_SHARE = 0.3        # of that signal's squared error, which the pair must take on both


def pair_instead(search: Search, best: Candidate) -> Candidate:
    """Return two effects that explain all where the best leave something, or the best."""
    left = _left(search, best)
    if not left or len(best.names) not in (1, 2):
        return best
    pairs = sorted((pair for single in search.singles()[:_SINGLES]
                    for pair in search.extend(single)), key=lambda item: item.score)
    pair = standing(search, search.prune(search.refine(pairs[0]))) if pairs else best
    ratios = [search.campaign.ratios(pair.fit.errors, held_out) for held_out in (False, True)]
    gains = [search.gain(best, pair, held_out) for held_out in (False, True)]
    clean = all(value <= AT_NOISE for found in ratios for value in found.values())
    sure = all(found.share[name] >= _SHARE and found.sigma[name] >= SIGNIFICANT
               for found in gains for name in left if name in found.share)
    return pair if clean and sure else best


def _left(search: Search, best: Candidate) -> list[str]:
    """Return the signals that stay well above noise and formula, fitted and held out."""
    def high(held_out: bool) -> set[str]:
        done = contribution(search.campaign, search.base, best.fit, held_out)
        return {name for name, ratio in search.campaign.ratios(best.fit.errors, held_out).items()
                if ratio > CLEAN_FITTED
                and ratio**2 - 1 > (_FORM * done[name])**2}

    return sorted(high(False) & high(True))
