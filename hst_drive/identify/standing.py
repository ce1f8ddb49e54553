# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What may be named of a set that was found, whichever way it was found.

An effect stands if the evidence does not speak against it (``weigh``), and if it is neither at
the end of what is plausible on a machine nor as it was adopted. What a set leaves beyond the noise
may be the work of something that acts like one of its effects: what takes away little more than is
left falls, too, unless the set explains all and does not without it. Without one that falls the
others are fitted and judged anew. At last it is asked what could stand in the place of each.
"""
from __future__ import annotations

from math import inf, log
from typing import Collection

from hst_drive.effects import catalogue, effect_of
from hst_drive.effects.base import arguments, FORMULA_ERROR
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.evidence import BASELINE, CREDIBLE, DECIDED
from hst_drive.identify.fit import at_ends, Fit, for_sizes
from hst_drive.identify.judge import contribution, excess, over_own_floors, PRACTICAL, REST
from hst_drive.identify.model import Model
from hst_drive.identify.score_test import score_test
from hst_drive.identify.search import Candidate, Search
from hst_drive.identify.weigh import log_odds
from hst_drive.measure.where import AT_NOISE
import numpy as np

RIVALS_TRIED = 6


def standing(search: Search, best: Candidate) -> Candidate:
    """Return what may be named of a set, fitted without the rest."""
    while best.names:
        fewer = _each_without(search, best, again=True)
        left, sizes = forms(search, best), for_sizes(search.campaign, best.fit)[1].model
        against = {name: inf if left[name]**2 > REST and not _needed(search, best, rest)
                   or at_ends(search.campaign, sizes, name)
                   or _as_before(search.campaign, sizes, name)
                   or _as_the_oil(search.campaign, rest.fit, best.fit, name)
                   else odds
                   for name, rest, odds in zip(best.names, fewer, log_odds(
                       search, [best, *fewer])[1:])}
        weakest = max(against, key=lambda name: (against[name], left[name]))
        if against[weakest] <= log(DECIDED):
            break
        best = without(search, best, [weakest])
    return best


def _needed(search: Search, best: Candidate, rest: Candidate) -> bool:
    """Say whether a set explains all, and the rest of it does not."""
    return not search.unexplained(best) and bool(search.unexplained(rest))


def _as_before(campaign: Campaign, model: Model, name: str) -> bool:
    """Say whether an adopted effect is as large as it was, but for what formulas are off."""
    size = effect_of(name).size.name
    before = campaign.adopted.get(name, {}).get(size, inf)
    return abs(model.effects[name][size] - before) <= FORMULA_ERROR * abs(before) < inf


def _as_the_oil(campaign: Campaign, without: Fit, model: Fit, name: str) -> bool:
    """Say whether a drag is no more than oil may make that is not as warm as it was."""
    effect = effect_of(name)
    drag = effect.slot == 'motor_torque_loss' and 'motor_speed' in arguments(effect.function)
    return drag and campaign.torque_off > 0.0 and all(
        amount <= max(campaign.oil_error(signal), BASELINE)
        for signal, amount in contribution(campaign, without, model, None).items())


def _each_without(search: Search, best: Candidate, again: bool = False) -> list[Candidate]:
    """Return the sets without each of the effects; ``again``: also fitted from the set itself."""
    return search.try_all([_rest(best, [name]) for name in best.names], 'taking effects out',
                          again)


def forms(search: Search, best: Candidate) -> dict[str, float]:
    """Return by what share each effect of a set may be off, for what the set leaves."""
    return {name: min(_share(search.campaign, rest.fit, best.fit, held_out)
                      for held_out in (True, False))
            for name, rest in zip(best.names, _each_without(search, best))}


def _share(campaign: Campaign, before: Fit, after: Fit, held_out: bool) -> float:
    """Return what is left beyond noise and chance over what was taken away, both rms."""
    first, last = (campaign.ratios(entry.errors, held_out) for entry in (before, after))
    own, fitted = over_own_floors(campaign, after)
    everything = left = taken = 0.0
    for name, ratio in own.ratios(fitted.errors, held_out).items():
        rest = max(ratio**2 - AT_NOISE**2 - own.scatter(name, held_out), 0.0)
        off = excess({name: first[name]}) - excess({name: last[name]})
        # Where an effect takes nothing away, what is left is not its own.
        everything, left, taken = everything + rest, left + min(rest, max(off, 0.0)), taken + off
    if taken <= 1e-9:
        return inf if everything else 0.0
    return float(np.sqrt(left / taken))


def without(search: Search, best: Candidate, out: Collection[str]) -> Candidate:
    """Return the fit without some of the effects of a set."""
    kept, start = _rest(best, out)
    return search.refine(search.try_all([(kept, start)], 'taking effects out')[0]) if kept \
        else search.baseline


def _rest(best: Candidate, out: Collection[str]) -> tuple[tuple[str, ...], Fit]:
    kept = tuple(name for name in best.names if name not in out)
    return kept, best.fit.only(kept)


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
