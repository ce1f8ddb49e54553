# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a search has fitted, as explanations that are weighed against each other (``evidence``)."""
from __future__ import annotations

from typing import Iterable, Iterator, Sequence, TYPE_CHECKING

from hst_drive.channels import PRESSURES
from hst_drive.effects import effect_of, flexible
from hst_drive.effects.base import FORMULA_ERROR
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.columns import Column
from hst_drive.identify.evidence import (
    BIN, evidence, Explanation, laplace, Probability, probability, range_of, Sensor, Signal,
    weight)
from hst_drive.identify.fit import ended, Fit
from hst_drive.identify.unknowns import Unknowns
from hst_drive.measure.run import BLOCK
import numpy as np

if TYPE_CHECKING:
    from hst_drive.identify.search import Candidate, Search

_QUICK = 0.03   # s: with the right model pressure, flow and speed are alike for 0.01 to 0.04
_ROUGH = 0.03   # of the squared floor: white noise that floors do not know


class Means:
    """How errors of a campaign are taken together: means over ``BIN``, pieces without a gap."""

    def __init__(self, campaign: Campaign):
        self.campaign = campaign
        self.sensors = _sensors(campaign)
        # By column: the samples that count, the number of the mean each is in, and its size.
        self._bins = [(used, number, np.maximum(np.bincount(number), 1))
                      for used, number in (_bins(campaign, column) for column in campaign.columns)]
        self._pieces = list(self._cut())

    def of(self, errors: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Return the means of errors, by column."""
        return self._of([error * column.weight
                         for error, column in zip(errors, self.campaign.columns)])

    def of_training(self, vector: np.ndarray) -> list[np.ndarray]:
        """Return the same of a vector of ``Campaign.training``; what is judged on is 0."""
        errors, start = [], 0
        for column in self.campaign.columns:
            error, stop = np.zeros(len(column.weight)), start + len(column.fit)
            error[column.fit] = vector[start:stop] / self.campaign.thinning(column)
            errors.append(error)
            start = stop
        return self._of(errors)

    def _of(self, errors: Sequence[np.ndarray]) -> list[np.ndarray]:
        return [np.bincount(number, error[used]) / count
                for error, (used, number, count) in zip(errors, self._bins)]

    def signals(self, left: Sequence[np.ndarray],
                moved: Sequence[np.ndarray]) -> dict[str, Signal]:
        """Return signals from means, by column, of what is left and of what effects move."""
        names = self.campaign.signals
        parts: dict[str, dict[int, list[np.ndarray]]] = {name: {} for name in names}
        powers: dict[str, list[np.ndarray]] = {name: [np.zeros(0)] for name in names}
        for index, bins in self._pieces:
            name = self.campaign.columns[index].signal
            parts[name].setdefault(len(bins), []).append(left[index][bins])
            powers[name].append(moved[index][bins]**2)
        return {name: Signal(tuple(map(np.array, lengths.values())),
                             float(np.sqrt(np.mean(np.concatenate(powers[name])))))
                for name, lengths in parts.items() if lengths}

    def _cut(self) -> Iterator[tuple[int, np.ndarray]]:
        """Yield stretches without a gap: index of a column, and which of its means."""
        most = round(3 * BLOCK / BIN)
        for index, (_, number, _) in enumerate(self._bins):
            full = np.unique(number)
            for stretch in np.split(full, np.flatnonzero(np.diff(full) > 1) + 1):
                for start in range(0, len(stretch), most):
                    yield index, stretch[start:start + most]


def weigh(search: Search, best: Candidate) -> Probability:
    """Return how probable each set is that a search has fitted, ``best`` among them."""
    campaign = search.campaign
    tried = [entry for entry in search.tried() if entry.names == best.names
             or not ended(campaign, entry.fit.model, entry.names)]
    found, sensors = _explanations(search, [
        *((entry.names, campaign, entry.fit, True) for entry in tried),
        *((_listed(search, fitted), own, fitted, False) for own, fitted in search.unlisted)])
    # Of whole drives with an open circuit they held (bench/README.md).
    return probability(found, sensors, len(search.candidates))._replace(
        calibrated=not campaign.by_balance)


def log_odds(search: Search, entries: Sequence[Candidate]) -> np.ndarray:
    """Return the logarithm of how much more probable fitted sets are than the first of them."""
    return _odds(search, [(entry.names, search.campaign, entry.fit, True) for entry in entries])


def log_odds_of(search: Search, best: Candidate, campaign: Campaign, fitted: Fit,
                listed: bool) -> float:
    """Return the log odds against a set of a fit in another campaign, with something unlisted."""
    return float(_odds(search, [(best.names, search.campaign, best.fit, True),
                                (_listed(search, fitted), campaign, fitted, listed)])[1])


def _odds(search: Search,
          fitted: Sequence[tuple[tuple[str, ...], Campaign, Fit, bool]]) -> np.ndarray:
    """Return the log odds of explanations, as ``_explanations`` has them, against the first."""
    explanations, sensors = _explanations(search, fitted)
    # What is not listed is weighed by itself, a set without anything unlisted beside it.
    found = np.array([evidence(entry, sensors, len(search.candidates))[not entry.listed]
                      for entry in explanations])
    return found - found[0]


def _explanations(search: Search, fitted: Sequence[tuple[tuple[str, ...], Campaign, Fit, bool]]
                  ) -> tuple[list[Explanation], dict[str, Sensor]]:
    """Return explanations of effects, campaign of the fit, fit, whether listed; and sensors."""
    campaign, means = search.campaign, Means(search.campaign)
    bare = means.of(search.bare.errors)

    def signals(fit: Fit) -> dict[str, Signal]:
        found = means.of(fit.errors)
        moved = [one - other for one, other in zip(found, bare)]
        own = means.of(_over_own(campaign, fit)) if flexible(fit.model.effects) else found
        return means.signals(own, moved)

    return [Explanation(names, signals(fit), _penalty(own, fit), listed,
                        len({*names} & {*campaign.faults}), formula_error(names))
            for names, own, fit, listed in fitted], means.sensors


def _over_own(campaign: Campaign, fit: Fit) -> Sequence[np.ndarray]:
    """
    Return the errors of a fit, over its own floors where these are lower.

    The load behind a flexible shaft is found with the measured speed, and follows rough rock
    better whether there is such a shaft or not.
    """
    own = campaign.floors_of(fit.model)
    return [error * max(campaign.floors[column.log][column.signal]
                        / own[column.log][column.signal], 1.0)
            for error, column in zip(fit.errors, campaign.columns)]


def formula_error(names: Iterable[str]) -> float:
    """Return by which share of what they do effects may be off their formulas."""
    return max((effect_of(name).formula_error for name in names), default=FORMULA_ERROR)


def _listed(search: Search, fitted: Fit) -> tuple[str, ...]:
    """Return the effects of the list in a fit of something that is not listed."""
    return tuple(sorted({name for name, _ in fitted.names} & {*search.candidates}))


def _bins(campaign: Campaign, column: Column) -> tuple[np.ndarray, np.ndarray]:
    """Return the samples of a column that count, and the number of the mean each is in."""
    run = campaign.replays[column.log].run
    time, used = run.time, np.sort(column.rows(None))
    if campaign.by_balance and round(run.sample_time / BIN) > 1:
        # Settled points: what a formula is off hangs on where they are, not on when.
        place = next((run[name] for name in (*PRESSURES, 'motor_speed', 'pump_speed')
                      if name in run and name != column.signal), time)
        return used, np.argsort(np.argsort(place[used]))
    return used, ((time[used] - time[0]) / BIN + 1e-6).astype(int)


def _sensors(campaign: Campaign) -> dict[str, Sensor]:
    """Return how each signal scatters: as the median of the logs has it."""
    known: dict[str, list[tuple[float, ...]]] = {}
    part = campaign.by_balance
    for column in campaign.columns:
        replay = campaign.replays[column.log]
        # The errors of a part were smoothed: there no noise is white.
        white = 0.0 if part else min((replay.noise[column.signal] * column.scale)**2, 1.0)
        rows = max(BIN / replay.run.sample_time, 1.0)
        rough, memory = campaign.rough_load[column.log].get(column.signal), _QUICK
        # What shakes slow records is no load, and quick.
        if rough and rough.std > 0.0 and not campaign.slow(column.signal):
            memory = max(rough.time_constant, _QUICK)
        known.setdefault(column.signal, []).append((
            # What a slow record does not show of commands and load shakes the replay, too.
            white / rows + _ROUGH, 1.0 - white + campaign.scatter(column.signal),
            memory, float(np.hypot(replay.sheet_error(column.signal) * column.scale,
                                   campaign.oil_error(column.signal))) if part else 0.0))
    return {name: Sensor(*map(float, np.median(entries, axis=0)))
            for name, entries in known.items()}


def _penalty(campaign: Campaign, fitted: Fit) -> float:
    unknowns = Unknowns(campaign, fitted.model)
    known = {name: index for index, name in enumerate(unknowns.names)}
    index = np.array([known[name] for name in fitted.names], dtype=int)
    information = weight(len(campaign.signals)) * fitted.information
    mode, scale = unknowns.pack(fitted.model)[index], unknowns.scale[index]
    ranges, neutral = (unknowns.high - unknowns.low)[index], np.full(len(mode), np.nan)
    for k, (name, key) in enumerate(fitted.names):
        if not name:
            continue
        off = campaign.off(name)
        if key == next(iter(off)):
            ranges[k] = range_of(mode[k] - off[key] / scale[k], campaign.either_way(name))
        else:
            # What an effect is besides its size may be there or not.
            neutral[k] = off[key] / scale[k]
    return laplace(information, index < unknowns.factors, ranges, mode, neutral)
