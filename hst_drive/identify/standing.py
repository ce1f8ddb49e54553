# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What may be named of a set that was found, whichever way it was found.

An effect stands if its interval leaves out that it is not there (of one that the rig has adopted:
that it is as it was), and if it is not at the end of
what is plausible on a machine. What a set leaves beyond the noise may be the work of something
that acts like one of its effects, so that each is known no better than by what is left over what
it takes away. Without one that falls the others are fitted and judged anew.
"""
from __future__ import annotations

from typing import Collection

from hst_drive.effects import catalogue
from hst_drive.identify.campaign import Campaign, Model
from hst_drive.identify.fit import at_its_end, Fit, settled
from hst_drive.identify.intervals import Spread, spread
from hst_drive.identify.judge import AT_NOISE, excess, judged
from hst_drive.identify.search import Candidate, Search
import numpy as np

_SURE = 1.96    # standard deviations: half of a 95 % interval


def standing(search: Search, best: Candidate) -> Candidate:
    """Return what may be named of a set, fitted without the rest."""
    while best.names:
        campaign, sizes = settled(search.campaign, best.fit)
        known = spread(campaign, sizes, forms(search, best))
        sure = {name: _sigmas(campaign, sizes.model, known, name)
                for name in best.names}
        weakest = min(sure, key=sure.get)
        if sure[weakest] >= _SURE:
            break
        best = without(search, best, [weakest])
    return best


def forms(search: Search, best: Candidate) -> dict[str, float]:
    """Return by what share each effect of a set may be off, for what the set leaves."""
    fewer = search.try_all([_rest(best, [name]) for name in best.names], 'taking effects out')
    return {name: min(_share(search.campaign, rest.fit, best.fit, held_out)
                      for held_out in (True, False)) for name, rest in zip(best.names, fewer)}


def _share(campaign: Campaign, before: Fit, after: Fit, held_out: bool) -> float:
    """Return what is left beyond noise and chance over what was taken away, both rms."""
    first, last = (campaign.ratios(entry.errors, held_out) for entry in (before, after))
    own, fitted = judged(campaign, after)
    left = sum(max(ratio**2 - AT_NOISE**2 - own.scatter(name), 0.0)
               for name, ratio in own.ratios(fitted.errors, held_out).items())
    return float(np.sqrt(left / max(excess(first) - excess(last), 1e-9)))


def without(search: Search, best: Candidate, out: Collection[str]) -> Candidate:
    """Return the fit without some of the effects of a set."""
    kept, start = _rest(best, out)
    if not kept or not out:
        return best if kept else search.baseline
    return search.refine(search.try_all([(kept, start)], 'taking effects out')[0])


def _rest(best: Candidate, out: Collection[str]) -> tuple[tuple[str, ...], Fit]:
    kept = tuple(name for name in best.names if name not in out)
    return kept, best.fit.only(kept)


def _sigmas(campaign: Campaign, model: Model, known: Spread, name: str) -> float:
    """Return by how many standard deviations an effect is there; 0 at the end of its range."""
    if at_its_end(campaign, model, name):
        return 0.0
    places = [known.unknowns.names.index((name, key)) for key in _sizes(campaign, model, name)
              if (name, key) in known.unknowns.names]
    values = (known.vector - known.before)[places]
    # Together: where a friction's constant part ends and its share of the load begins may be open.
    part = known.covariance[np.ix_(places, places)]
    return float(np.sqrt(values @ np.linalg.solve(part, values)))


def _sizes(campaign: Campaign, model: Model, name: str) -> list[str]:
    """Return the parameters of an effect that do something without the others."""
    effect, values = catalogue(everything=True)[name], model.effects[name]
    if name in campaign.adopted:
        return [effect.parameters[0].name]
    nothing = {entry.name: values[entry.name] if entry.fixed else entry.neutral
               for entry in effect.parameters}
    size, *others = nothing
    rest = campaign.errors(model.with_effect(name, nothing), to_fit=True)
    return [size, *(key for key in others if any(
        not np.array_equal(first, second) for first, second in zip(rest, campaign.errors(
            model.with_effect(name, {**nothing, key: values[key]}), to_fit=True))))]
