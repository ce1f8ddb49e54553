# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a search has fitted, as explanations that are weighed against each other (``evidence``)."""
from __future__ import annotations

from typing import Iterator, Mapping, NamedTuple, Sequence

from hst_drive.diagnose.evidence import (
    BIN, DECIDED, decided, Explanation, laplace, PIECE, Probability, probability, range_of, Sensor,
    Signal, weight)
from hst_drive.diagnose.result import UNIT_ALONE
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import at_its_end, Fit
from hst_drive.identify.judge import IN_SAMPLE
from hst_drive.identify.limits import limited
from hst_drive.identify.part import PartCampaign
from hst_drive.identify.search import Candidate, Search
from hst_drive.identify.standing import standing
from hst_drive.identify.unknowns import Unknowns
import numpy as np

_CERTAIN = 0.9  # of what is listed: from there on evidence alone names what leaves nothing
_QUICK = 0.03   # s: with the right model pressure, flow and speed are alike for 0.01 to 0.04
_ROUGH = 0.03   # of the squared floor: white noise that floors do not know


class _Piece(NamedTuple):
    """Samples of a column (its place), each row those of one mean; ``mean`` takes it."""

    column: int
    bins: np.ndarray


def after_tests(search: Search, best: Candidate, rivals: Mapping[str, Sequence[str]],
                verdict: str) -> Probability:
    """
    Return how probable each set is, given what the tests over held-out blocks decided as well.

    ``rivals`` are what could stand in the place of each effect of the set that was found.
    """
    named = [best.names, *(
        tuple(sorted({*best.names} - {name} | {rival} - {UNIT_ALONE}))
        for name, group in rivals.items() for rival in group)]
    return decided(weigh(search, best), verdict, named)


def weigh(search: Search, best: Candidate) -> Probability:
    """Return how probable each set is that a search has fitted, ``best`` among them."""
    campaign = search.campaign
    tried = [entry for entry in search.tried() if entry.names == best.names or not any(
        at_its_end(campaign, entry.fit.model, name) for name in entry.names)]
    pieces = list(_pieces(campaign))
    base = _means(campaign, search.base.errors)
    found = [Explanation(names, _signals(campaign, pieces, base, fitted),
                         _penalty(own, fitted), listed)
             for names, own, fitted, listed in (
                 *((entry.names, campaign, entry.fit, True) for entry in tried),
                 *((_listed(search, fitted), own, fitted, False)
                   for own, fitted in search.unlisted))]
    return probability(found, _sensors(campaign), len(search.candidates))


def nearly_certain(search: Search, best: Candidate) -> Candidate:
    """
    Return the set that is nearly certain and leaves nothing, or what the tests found.

    What shows in a single event of a short log no test over blocks can be sure of. Something may
    hide so although nothing seems to be left: where it takes the unit off a limit, and much of
    the error of the logs that were fitted.
    """
    left = search.unexplained(best)
    strained = limited(search.campaign, best.fit)
    if not (left or strained):
        return best
    found = weigh(search, best)
    names, share = max(found.sets, key=lambda item: item[1], default=((), 0.0))
    if share < _CERTAIN * (1.0 - found.unknown) or names == best.names:
        return best
    entry, = (entry for entry in search.tried() if entry.names == names)
    likelier = standing(search, search.refine(entry))
    if likelier.names != names or search.unexplained(likelier):
        return best
    hidden = limited(search.campaign, likelier.fit) < strained and max(
        search.gain(best, likelier, False).share.values(), default=0.0) >= IN_SAMPLE
    return likelier if left or hidden else best


def likeliest(search: Search, best: Candidate,
              rivals: Mapping[str, Sequence[str]]) -> Candidate:
    """
    Return the likeliest of the sets that stand.

    The tests have chosen ``best``, so that another one must outweigh that.
    """
    others = [tuple(sorted({*best.names} - {name} | {rival}))
              for name, group in rivals.items() for rival in group
              if rival in search.candidates]
    if not others:
        return best
    shares = dict(weigh(search, best).sets)
    names = max(others, key=lambda entry: shares.get(entry, 0.0))
    if shares.get(names, 0.0) <= DECIDED * shares.get(best.names, 0.0):
        return best
    entry, = (entry for entry in search.tried() if entry.names == names)
    found = standing(search, search.refine(entry))
    return found if found.names == names and not search.unexplained(found) else best


def _listed(search: Search, fitted: Fit) -> tuple[str, ...]:
    """Return the effects of the list in a fit of something that is not listed."""
    return tuple(sorted({name for name, _ in fitted.names} & {*search.candidates}))


def _bins(campaign: Campaign, place: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the samples of a column that count, and the number of the mean each is in."""
    column = campaign.columns[place]
    time = campaign.replays[column.log].run.time
    used = np.sort(np.concatenate([column.fit, column.judge]))
    return used, ((time[used] - time[0]) / BIN + 1e-6).astype(int)


def _means(campaign: Campaign, errors: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return the means of errors over ``BIN``, by column."""
    found = []
    for place, (error, column) in enumerate(zip(errors, campaign.columns)):
        used, number = _bins(campaign, place)
        count = np.bincount(number)
        found.append(np.bincount(number, (error * column.trust)[used]) / np.maximum(count, 1))
    return found


def _pieces(campaign: Campaign) -> Iterator[_Piece]:
    """Yield the stretches without a gap of all columns, none longer than ``PIECE``."""
    most = round(PIECE / BIN)
    for place in range(len(campaign.columns)):
        full = np.unique(_bins(campaign, place)[1])
        for stretch in np.split(full, np.flatnonzero(np.diff(full) > 1) + 1):
            for start in range(0, len(stretch), most):
                yield _Piece(place, stretch[start:start + most])


def _signals(campaign: Campaign, pieces: Sequence[_Piece], base: Sequence[np.ndarray],
             fitted: Fit) -> dict[str, Signal]:
    means = _means(campaign, fitted.errors)
    parts: dict[str, dict[int, list[np.ndarray]]] = {name: {} for name in campaign.signals}
    moved: dict[str, list[np.ndarray]] = {name: [np.zeros(0)] for name in campaign.signals}
    for place, bins in pieces:
        name = campaign.columns[place].signal
        parts[name].setdefault(len(bins), []).append(means[place][bins])
        moved[name].append(means[place][bins] - base[place][bins])
    return {name: Signal(tuple(map(np.array, lengths.values())),
                         float(np.sqrt(np.mean(np.concatenate(moved[name])**2))))
            for name, lengths in parts.items() if lengths}


def _sensors(campaign: Campaign) -> dict[str, Sensor]:
    """Return how each signal scatters: as the median of the logs has it."""
    known: dict[str, list[tuple[float, float, float]]] = {}
    part = isinstance(campaign, PartCampaign)
    for column in campaign.columns:
        replay = campaign.replays[column.log]
        # The errors of a part were smoothed: there no noise is white.
        white = 0.0 if part else min((replay.noise[column.signal] * column.scale)**2, 1.0)
        rows = max(BIN / replay.run.sample_time, 1.0)
        slow = not part and column.signal == replay.torque and replay.roughness.std > 0.0
        known.setdefault(column.signal, []).append((
            # What a slow record does not show of commands and load shakes the replay, too.
            white / rows + _ROUGH, 1.0 - white + campaign.scatter(column.signal),
            max(replay.roughness.time_constant, _QUICK) if slow else _QUICK))
    return {name: Sensor(*map(float, np.median(entries, axis=0)))
            for name, entries in known.items()}


def _penalty(campaign: Campaign, fitted: Fit) -> float:
    unknowns = Unknowns(campaign, fitted.model)
    known = {name: place for place, name in enumerate(unknowns.names)}
    place = np.array([known[name] for name in fitted.names], dtype=int)
    information = weight(len(campaign.signals)) * fitted.jacobian.T @ fitted.jacobian
    mode, scale = unknowns.pack(fitted.model)[place], unknowns.scale[place]
    ranges, neutral = (unknowns.high - unknowns.low)[place], np.full(len(mode), np.nan)
    for k, (name, key) in enumerate(fitted.names):
        if not name:
            continue
        off = campaign.off(name)
        if key == next(iter(off)):
            ranges[k] = range_of(mode[k] - off[key] / scale[k],
                                 bool(unknowns.low[place[k]] < off[key] / scale[k]))
        else:
            # What an effect is besides its size may be there or not.
            neutral[k] = off[key] / scale[k]
    return laplace(information, place < unknowns.factors, ranges, mode, neutral)
