# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""From fitted candidates to an answer: none, found, ambiguous or unknown."""
from __future__ import annotations

from typing import Callable, Mapping, Sequence

from hst_drive.channels import CHANNELS
from hst_drive.design.design import in_short
from hst_drive.design.rivals import told_apart
from hst_drive.diagnose.causes import one_cause, outlier_record, several_drives
from hst_drive.diagnose.choose import (
    doubted, exchanged, instead_of_the_unit, likeliest, oil_told, searched)
from hst_drive.diagnose.result import (
    Diagnosis, Found, NextTest, Ranked, Step, UNIT_ALONE, Unknown, Value)
from hst_drive.diagnose.sentence import (
    beyond, less, limits, listed, nearly, sentence, taken, times)
from hst_drive.diagnose.unit import at_limits, calibration, sensors
from hst_drive.diagnose.unknown import describe
from hst_drive.diagnose.unlisted import Unlisted, unlisted_addition, unlisted_replacement
from hst_drive.effects import effect_of
from hst_drive.effects.leakage_temperature import OIL_LAW
from hst_drive.errors import InputError
from hst_drive.identify.campaign import Campaign, ELSEWHERE
from hst_drive.identify.conditions import oil_untold, outside
from hst_drive.identify.evidence import decided
from hst_drive.identify.fit import Fit, fit, for_sizes
from hst_drive.identify.intervals import intervals
from hst_drive.identify.judge import excess, over_own_floors
from hst_drive.identify.model import Model
from hst_drive.identify.part import campaign_of
from hst_drive.identify.search import Candidate, Search
from hst_drive.identify.standing import (
    alternatives, forms, RIVALS_TRIED, standing, without)
from hst_drive.identify.weigh import log_odds, weigh
from hst_drive.measure.inertia import found_inertia, INERTIA, with_found_inertia
from hst_drive.measure.plausibility import drifts, refuse_wrong_units
from hst_drive.measure.run import Run
from hst_drive.measure.useful import refuse_unjudged, refuse_useless
from hst_drive.rig import Rig
from hst_drive.rig.fingerprint import SECTION

_SHORT = 10.0           # s that a recording should have at least


def diagnose(rig: Rig, runs: Sequence[Run], holdout: Sequence[Run] = (), *,
             progress: Callable[[str], None] = lambda text: None) -> Diagnosis:
    """
    Say which physical effects a model lacks.

    Parameters
    ----------
    rig : Rig
        The baseline; effects that it has adopted are part of it.
    runs : sequence of Run
        One campaign: recordings of the same drive.
    holdout : sequence of Run
        Recordings to judge on; without them a third of ``runs`` is held out.
    progress : callable
        Called with a text while the work goes on.

    Raises
    ------
    InputError
        If the logs lack the channels that a replay needs, or tell nothing.

    """
    logs = (*runs, *holdout)
    refuse_useless(rig, logs)
    refuse_wrong_units(rig, logs)
    drifting = drifts(rig, logs)
    progress('calibrating the unit')
    campaign = campaign_of(with_found_inertia(rig, logs), runs, holdout)
    sheet = fit(campaign, Model(), iterations=0)
    if not campaign.ratios(sheet.errors, True):
        _refuse_short(campaign, logs)
    search, seen = searched(campaign, progress)
    best, left, better, more = _explained(search)
    for ask in (oil_told, doubted):
        if other := ask(search, best, left):
            search, seen = searched(other, progress)
            best, left, better, more = _explained(search)
    unsure = bool(left or more or better)
    campaign = search.campaign      # its recordings may have been turned
    remaining = next((entry.unknown for entry in (*better.values(), *([more] if more else []))
                      if entry.unknown), None)
    if not remaining and unsure:
        remaining = describe(campaign, best.fit)
    drifting = [entry for entry in drifting if entry.channel in left]
    if drifting:
        # The reading parts from all others with time.
        remaining = Unknown('sensor', drifting[0].channel, ('time',), '')
    odd, several = _unlike(campaign, logs) if left and not drifting else ('', '')
    strained = at_limits(campaign, best.fit)
    beside = None if unsure else instead_of_the_unit(search, best)
    alone, best = best if beside else None, beside or best
    order = _order(search, best)
    rivals = {name: alternatives(search, best, name) for name in order}
    first = best if unsure else likeliest(search, best, rivals, alone)
    if first is not best:
        best, order = first, _order(search, first)
        rivals = {name: alternatives(search, best, name) for name in order}
    if alone:
        rivals = {name: group if name in alone.names else (*group, UNIT_ALONE)
                  for name, group in rivals.items()}
    campaign = search.campaign      # its recordings may have been turned again
    ladder, ranking = _ladder(search, best, order, sheet), _ranking(search)
    effects = _found(search, best, order, rivals, ladder)
    ambiguous = any(rivals.values())
    unseen = outside(rig, logs)
    inertia = found_inertia(rig, campaign.rig, best.fit.model.scales)
    explained = {*best.names, *sum(rivals.values(), ())}
    hidden = {entry.id: entry.reason for entry in seen if entry.reason
              and entry.id not in explained}
    verdict = ('unknown' if unsure else 'none' if not effects
               else 'ambiguous' if ambiguous else 'missing_effect')
    # What is named beside a sensor that drifts may be the drift.
    mend = [f'{entry.told}; mend the sensor or leave its column out first.' for entry in drifting]
    named = {best.names, *exchanged(best, rivals)} if verdict != 'unknown' else set()
    given = decided(weigh(search, best), named)
    # How its leakages go with its oil, where these logs are the first to tell.
    power = None if OIL_LAW in rig.effects else campaign.adopted.get(OIL_LAW, {}).get('exponent')
    said = sentence(verdict, effects, ladder, remaining,
                    tuple(name for name in hidden if hidden[name] != ELSEWHERE), strained,
                    campaign.commissioned_unit, tuple(campaign.faults)).strip()
    return Diagnosis(
        verdict=verdict, sentence=' '.join(filter(None, [
            *mend, odd, said, '' if alone else nearly(given, named), several,
            '' if alone else limits(verdict, strained, campaign.commissioned_unit),
            *(f'{" and ".join(name for name, entry in better.items() if entry.told == told)} '
              f'{told}.' for told in dict.fromkeys(entry.told for entry in better.values())),
            *([f'{more.told[0].upper()}{more.told[1:]}.'] if more else []),
            beyond(unseen, verdict != 'none' and oil_untold(rig, logs), power),
            taken(inertia)])),
        effects=effects, ranking=ranking, ladder=ladder, not_observable=hidden,
        smallest={entry.id: entry.smallest for entry in seen if not entry.reason
                  and entry.id not in explained},
        calibration=calibration(campaign, best.fit, {INERTIA} if inertia else ()),
        zeros=sensors(campaign, best.fit.model.zeros),
        delays=sensors(campaign, best.fit.model.delays), inertia=inertia,
        probability=given, unknown=remaining,
        next_test=_measure(best, alone, strained) if alone else
        _next_test(search, best, rivals) if ambiguous else None,
        rivals={**_why_lost(search, best, rivals, ranking, ladder[-1].holdout),
                **{name: entry.told for name, entry in better.items()}},
        rig=rig.source or rig.name, rig_digest=rig.digest,
        logs=tuple(run.source for run in logs),
        held_out=tuple(run.source for run in holdout), outside=unseen,
        since=tuple((rig.provenance.get(SECTION) or {}).get('logs', ())))


def _refuse_short(campaign: Campaign, logs: Sequence[Run]) -> None:
    """Raise InputError: no row of these logs can be judged."""
    sources = ', '.join(run.source for run in logs)
    if sum(float(run.time[-1] - run.time[0]) for run in logs) > _SHORT:
        refuse_unjudged(sources, campaign.signals)
    raise InputError(f'{sources}: too short: after the start nothing is left to judge on; '
                     'record at least 10 s, better a minute')


def _explained(search: Search) -> tuple[
        Candidate, dict[str, float], dict[str, Unlisted], Unlisted | None]:
    """
    Search for what explains the logs.

    Returns
    -------
    best : Candidate
        The best set of listed effects.
    left : dict of str to float
        Noise ratio of each signal that it does not explain.
    better : dict of str to Unlisted
        What is not listed and fits better in the place of an effect that was found.
    more : Unlisted or None
        What is not listed and fits better beside them.

    """
    best = standing(search, search.run())
    left = search.unexplained(best)
    whole = not search.campaign.by_balance
    more = one_cause(search, best, left) if whole else None
    better = {} if more else unlisted_replacement(search, best, left)
    if better and (again := search.anew(best, better)) is not best:
        best, left = again, search.unexplained(again)
        better = unlisted_replacement(search, best, left)
    found = best
    if more:
        found = search.baseline
    elif better:
        found = standing(search, without(search, best, better))
    elif whole:
        found, more = unlisted_addition(search, best, left)
    return found, left if found is best else search.unexplained(found), better, more


def _unlike(campaign: Campaign, logs: Sequence[Run]) -> tuple[str, str]:
    """Say which log is unlike the others, or that they seem to be of several drives."""
    odd = outlier_record(campaign)
    if odd is not None:
        return (f'{logs[odd[0]].source} is unlike the others, which the model explains: {odd[1]} '
                'there explains it; mend that first, or leave the log out.'), ''
    return '', 'Each log alone is explained by a unit within its tolerances, but not all by the ' \
        'same: were they recorded on several drives, or was a part changed in between?' \
        if several_drives(campaign) else ''


def _found(search: Search, best: Candidate, order: Sequence[str],
           rivals: Mapping[str, tuple[str, ...]], ladder: Sequence[Step]) -> tuple[Found, ...]:
    """Return the effects of a set with their sizes and intervals."""
    campaign = search.campaign
    sized, sizes = for_sizes(campaign, best.fit)
    found = intervals(sized, sizes, forms(search, best)) if best.names else {}
    return tuple(Found(
        name, {key: Value(value, *found.get((name, key), (value, value)),
                          effect_of(name).parameter(key).unit)
               for key, value in sizes.model.effects[name].items()},
        removed, rivals[name], dict(campaign.adopted.get(name, {})))
        for name, removed in zip(order, _removed(ladder)))


def _order(search: Search, best: Candidate) -> list[str]:
    """Return the effects in the order in which the error falls."""
    order: list[str] = []
    while rest := [name for name in best.names if name not in order]:
        trials = search.try_all([((*order, name), best.fit.only((*order, name)))
                                 for name in rest], 'ordering')
        order.append(min(zip(trials, rest), key=lambda pair: pair[0].score)[1])
    return order


def _ladder(search: Search, best: Candidate, order: Sequence[str],
            sheet: Fit) -> tuple[Step, ...]:
    def step(added: str, fitted: Fit) -> Step:
        own, model = over_own_floors(search.campaign, fitted)
        return Step(added, own.ratios(model.errors, False), own.ratios(model.errors, True))

    first = 'commissioned unit' if search.campaign.commissioned_unit else 'datasheet'
    steps = [step(first, sheet), step('calibrated unit', search.base)]
    for count in range(1, len(order)):
        names = tuple(order[:count])
        steps.append(step(names[-1], search.try_all([(names, best.fit.only(names))],
                                                    'ladder')[0].fit))
    return (*steps, *([step(order[-1], best.fit)] if order else []))


def _removed(ladder: Sequence[Step]) -> list[float]:
    start = excess(ladder[1].holdout)
    return [min(max((excess(before.holdout) - excess(after.holdout)) / start, 0.0), 1.0)
            if start else 0.0
            for before, after in zip(ladder[1:], ladder[2:])]


def _ranking(search: Search) -> tuple[Ranked, ...]:
    entries = []
    for name in search.candidates:
        candidate = search.single(name)
        ratios = search.campaign.ratios(candidate.fit.errors, True)
        mean = (sum(value**2 for value in ratios.values()) / max(len(ratios), 1))**0.5
        entries.append(Ranked(name, mean, 0.5 * (search.baseline.score - candidate.score)))
    return tuple(sorted(entries, key=lambda entry: -entry.evidence))


def _why_lost(search: Search, best: Candidate, rivals: dict[str, tuple[str, ...]],
              ranking: Sequence[Ranked], left: Mapping[str, float]) -> dict[str, str]:
    """Say of the nearest candidates why they are not the answer, which leaves ``left``."""
    if not best.names:
        return {}
    standing = {entry for group in rivals.values() for entry in group}
    named = 'what was found' if len(best.names) > 1 else best.names[0]
    told = {}
    nearest = [search.single(entry.id) for entry in ranking[:RIVALS_TRIED]
               if entry.id not in best.names and entry.id not in standing]
    for entry, value in zip(nearest, log_odds(search, [best, *nearest])[1:]):
        ratios = search.campaign.ratios(entry.fit.errors, True)
        if not ratios:      # too little is held out
            continue
        worst = max(ratios, key=lambda name: ratios[name]**2 - left[name]**2)
        leaves, well = times(ratios[worst]), times(left[worst])
        told[entry.names[0]] = (
            f'leaves {CHANNELS[worst].title} at {leaves} times the noise, {named} at {well}'
            if ratios[worst] > left[worst] and leaves != well else
            f'leaves as little, and is {less(value)} probable')
    return told


def _measure(best: Candidate, alone: Candidate, strained: Sequence[str]) -> NextTest:
    """Return what separates an effect from a unit at its limits: a datasheet that is sharper."""
    return NextTest((*(name for name in best.names if name not in alone.names), UNIT_ALONE),
                    f'measure {listed(strained)} of this unit by itself and write the number and '
                    'how well it is known into the rig file; or record it when it was healthy',
                    tuple(dict(entry.fit.model.effects) for entry in (best, alone)))


def _next_test(search: Search, best: Candidate, rivals: dict[str, tuple[str, ...]]) -> NextTest:
    models = [best.fit.model]
    for name, group in rivals.items():
        others, kept = tuple(entry for entry in best.names if entry != name), best.fit
        models += [entry.fit.model for entry in search.try_all(
            [((*others, rival), kept.without(name)) for rival in group], 'trying rivals')]
    campaign = search.campaign
    search.progress('looking for a test')
    what = campaign.to_record(models) or in_short(campaign.rig, models, campaign.signals)
    return NextTest(told_apart(models), what, tuple(dict(entry.effects) for entry in models))
