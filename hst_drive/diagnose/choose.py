# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What is searched for, and which of the sets that were fitted is the answer."""
from __future__ import annotations

from math import log
from typing import Callable, Container, Mapping, Sequence

from hst_drive.diagnose.free_forms import beyond_noise
from hst_drive.diagnose.result import UNIT_ALONE
from hst_drive.effects import catalogue
from hst_drive.effects.leakage_temperature import OIL_LAW, POWER, POWER_SIGMA
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.evidence import CREDIBLE, DECIDED, USUAL
from hst_drive.identify.fit import limited
from hst_drive.identify.judge import REST
from hst_drive.identify.model import Model
from hst_drive.identify.observable import Visibility, visibility
from hst_drive.identify.search import Candidate, MOST_EFFECTS, Search
from hst_drive.identify.standing import standing
from hst_drive.identify.weigh import log_odds, log_odds_of

_ASKED = 12     # effects that may take the unit off its limits


def searched(campaign: Campaign, progress: Callable[[str], None]) -> tuple[
        Search, list[Visibility]]:
    """Return the search for what these logs may show, and how well they show each effect."""
    search = Search(campaign, [], progress)
    seen = visibility(campaign, search.base, campaign.candidates())
    search.candidates = tuple(entry.id for entry in seen if entry.tried)
    return search, seen


def exchanged(best: Candidate, rivals: Mapping[str, Sequence[str]]) -> set[tuple[str, ...]]:
    """Return the sets with a rival, or the unit alone, in the place of an effect."""
    return {tuple(sorted({*best.names} - {name} | {rival} - {UNIT_ALONE}))
            for name, group in rivals.items() for rival in group}


def oil_told(search: Search, best: Candidate, left: Container[str]) -> Campaign | None:
    """
    Return the campaign of a machine whose leakages follow its oil as these logs tell.

    None if they do not, or if commissioning told it: then another power is news, as is one by
    which no gap leaks. Whatever is ``left`` may follow from that.
    """
    campaign, law = search.campaign, best.fit.model.effects.get(OIL_LAW)
    if not law or not campaign.commissioned_unit or OIL_LAW in campaign.adopted or (
            law['exponent'] > POWER + 2.0 * POWER_SIGMA):
        return None
    return campaign.with_oil_law(law['exponent'])


def doubted(search: Search, best: Candidate, left: Container[str]) -> Campaign | None:
    """
    Return the campaign of readings that are late, and of a pump off its curve, if that will do.

    ``left`` are the signals that the set leaves unexplained. It will do if then an effect less is
    enough. Where something is left it also will if that explains it, or most of it, the logs are
    far likelier, and no sensor is as late as it may be.
    """
    other = search.campaign.doubted() if best.names or left else None
    if not other:
        return None
    again, what = Search(other, search.candidates, search.progress), 'doubting curve and sensors'
    fewer = again.try_all([({*best.names} - {name}, best.fit.without(name))
                           for name in best.names], what)
    enough = [rest for rest in fewer if not again.unexplained(rest)]
    if not left and not enough:
        return None
    full = again.refine(again.try_all([(best.names, best.fit)], what)[0])
    if left and (not again.unexplained(full) or _most_of_it(search, best, other, full)):
        return again.campaign
    return again.campaign if any(not again.asked(rest, full) for rest in enough) else None


def _most_of_it(search: Search, best: Candidate, other: Campaign, full: Candidate) -> bool:
    """Say whether a set, fitted in another campaign, explains most of what the best one leaves."""
    late = {*limited(other, full.fit)} & other.delays.keys()
    return not late and log_odds_of(search, best, other, full.fit, True) > CREDIBLE and (
        beyond_noise(other, full.fit) <= REST * beyond_noise(search.campaign, best.fit))


def instead_of_the_unit(search: Search, best: Candidate) -> Candidate | None:
    """
    Return a set with one effect more, which stands where the unit is at limits without it.

    It is likelier, relieves the unit and leaves nothing; None if there is none.
    """
    if len(best.names) == MOST_EFFECTS or not limited(search.campaign, best.fit):
        return None
    more = search.extend(best, most=_ASKED) if best.names else search.singles()
    if not more:
        return None
    (top, *_), _ = search.likeliest(best, more)
    top = search.refine(top)
    stands = _relieves(search, top, best) and not search.unexplained(top) and (
        search.odds(best, [top])[0] > log(DECIDED) and standing(search, top).names == top.names)
    return top if stands else None


def _relieves(search: Search, found: Candidate, without: Candidate) -> bool:
    """Say whether a set takes the unit off one of its limits, or off all beside other effects."""
    left = {*limited(search.campaign, found.fit)}
    return not left if without.names else left < {*limited(search.campaign, without.fit)}


def likeliest(search: Search, best: Candidate, rivals: Mapping[str, Sequence[str]],
              alone: Candidate | None = None) -> Candidate:
    """
    Return the likeliest of ``best`` and the sets with a rival in the place of an effect.

    Where the rival does not stand, what is left of several effects is likelier than ``best``.
    Of those that relieve the unit of limits at which it is ``alone``, as ``best`` does.
    """
    wanted = exchanged(best, rivals)
    if not wanted:
        return best
    sets = [best, *(search.refine(entry) for entry in search.tried() if entry.names in wanted)]
    odds = log_odds(search, sets)
    # Of what evidence hardly tells apart (Kass and Raftery) the plainest.
    first, _ = min(((entry, value) for entry, value in zip(sets, odds)
                    if value >= odds.max() - log(DECIDED)),
                   key=lambda item: (_plainness(search, item[0]), -item[1]))
    if first is best:
        return best
    found = standing(search, first)
    of_several = found.names and {*found.names} < {*best.names}
    stands = (found.names in wanted or of_several) and not search.unexplained(found) and (
        alone is None or _relieves(search, found, alone))
    return found if stands else best


def _plainness(search: Search, entry: Candidate) -> tuple[int, int, int, int]:
    """
    Return how many effects the machine is not known to have, are special, and unusually large.

    Then how many parameters they have: those that tell the oil count for no effect, since the
    machine's oil sets them. Special ones need a drive that turns both ways to show, or are one
    form of another effect.
    """
    names = {*entry.names} - {*search.campaign.faults}
    effects = [catalogue()[name] for name in entry.names]
    return (len(names), sum(effect.both_ways or bool(effect.form_of) for effect in effects),
            sum(_unusual(search.campaign, entry.fit.model, name) for name in names),
            sum(len(effect.own) for effect in effects))


def _unusual(campaign: Campaign, model: Model, name: str) -> bool:
    """Say whether an effect is larger than half of all that there are."""
    size = campaign.parameter(name, catalogue()[name].size.name)
    return abs(model.effects[name][size.name] - size.neutral) > USUAL * abs(size.typical)
