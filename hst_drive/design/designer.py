# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The search for the test that sets rivals apart: rehearsed, improved, verified."""
from __future__ import annotations

from typing import Callable, Iterable, NamedTuple, Sequence

from hst_drive.design.families import FAMILIES
from hst_drive.design.separation import CLEAR, driver, Record, Rehearsal, verify
from hst_drive.design.trials import (
    ease, plain_drilling, scenario, Segment, SPIN_UP, Trial)
from hst_drive.identify.fit import each
from hst_drive.identify.model import Model
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.load.scenario import parse_scenario, Scenario
from hst_drive.model import usual_sensors
from hst_drive.rig import Rig
import numpy as np

KEPT = 4                # good tests that the search goes on from
ANY = 1.0               # sigma that any test is worth
_SEED = 20260101
_MIXED, _ROUNDS, _CHANGED = 12, 2, 8
_ENOUGH = 2 * CLEAR     # sigma; more makes a test no better
_KNOWN = 30.0           # s of plain drilling: so much is known before the test
_WARM_SHARE = 0.25      # of the mixtures
_RELIEF = 0.95          # of the relief valve's set pressure: what a rehearsal may reach
_MOST_EMPTY = 0.2       # of a test's time with a line that may run empty: then it is useless


class Rated(NamedTuple):
    """A trial and what it is expected to be worth."""

    trial: Trial
    worth: float


class Verified(NamedTuple):
    """
    A trial, the sensors added for it, and how far it sets each explanation apart.

    ``apart`` is in sigma, from the nearest rival.
    """

    trial: Trial
    sensors: tuple[str, ...]
    apart: tuple[float, ...]

    @property
    def clear(self) -> float:
        """In how many cases, as a share, the truth will come out."""
        return _by_chance([float(sigma >= CLEAR) for sigma in self.apart])


def _by_chance(values: Sequence[float]) -> float:
    """Return a mean in which the first, that fits best, has the weight of all others together."""
    return float(0.5 * values[0] + 0.5 * np.mean(values[1:] or values))


def worth(apart: Sequence[float]) -> float:
    """Return what a test is worth that sets explanations apart by so many sigma."""
    return _by_chance([min(sigma, _ENOUGH) for sigma in apart])


class Designer:
    """
    Searches for the test.

    Parameters
    ----------
    rig : Rig
        Baseline that was diagnosed.
    models : sequence of Model
        The rivals, with the sizes that they would have.
    channels : sequence of str
        Signals that the rig records.
    closed_loop : bool
        Speed held by the controller; else its commands are given.
    likely : int
        So many of the models, the first, may be the truth; the others are near twins of those.
        0 for all.
    progress : callable
        Called with a text.

    """

    def __init__(self, rig: Rig, models: Sequence[Model], channels: Iterable[str], *,
                 closed_loop: bool = False, likely: int = 0,
                 progress: Callable[[str], None] = lambda text: None):
        self.rig, self.models = rig, tuple(models)
        self.likely = likely or len(self.models)
        known = usual_sensors(rig)
        self.channels = tuple(name for name in channels if name in known)
        self.closed_loop, self.progress = closed_loop, progress
        self.unit = LoadingUnit.of(rig.loading)
        self.compiled = driver(rig, Model()).kernel.compiled
        self._known: dict[Trial, Rated] = {}

    def scenario(self, trial: Trial) -> Scenario:
        """Return a trial as a scenario."""
        return parse_scenario(scenario(trial, self.rig, self.closed_loop), self.unit)

    def rehearsal(self, trial: Trial) -> Rehearsal:
        """Rehearse a trial."""
        return Rehearsal(self.rig, self.scenario(trial), self.models, _SEED)

    def rate(self, trials: Sequence[Trial]) -> list[Rated]:
        """Rate trials, the best first."""
        todo = [trial for trial in dict.fromkeys(trials) if trial not in self._known]
        for rated in each(self._rate, todo):
            self._known[rated.trial] = rated
            self.progress(f'rehearsing tests: {len(self._known)}')
        return sorted((self._known[trial] for trial in dict.fromkeys(trials)),
                      key=lambda entry: -entry.worth)

    def _rate(self, trial: Trial) -> Rated:
        return Rated(trial, self.worth(trial, self.rehearsal(trial), self.channels))

    def worth(self, trial: Trial, rehearsal: Rehearsal, channels: Iterable[str]) -> float:
        """Return what a rehearsed test is worth; its mean over all pairs as a tie-break."""
        if rehearsal.highest > _RELIEF * self.rig.relief_valve.set_pressure:
            return 0.0
        pairs = rehearsal.pairs(channels, self.likely)
        apart = [min(pair.significance for pair in pairs if place in (pair.truth, pair.rival))
                 for place in range(self.likely)]
        mean = float(np.mean([pair.significance for pair in pairs]))
        # Where no test helps much none is worth going to extremes for.
        return (ANY + worth(apart) + 0.05 * mean) * ease(trial) * max(
            1.0 - rehearsal.empty / _MOST_EMPTY, 0.0)

    def search(self, duration: float) -> list[Rated]:
        """Return tests of this duration (s), the best first."""
        random = np.random.default_rng(_SEED)
        pure = self.pure(duration)
        rated = self.rate(pure)
        if self.compiled:
            trials = pure + [entry.trial._replace(warming=True) for entry in rated[:KEPT]] + [
                self._mixture(random, duration) for _ in range(_MIXED)]
            rated = self.rate(trials)
        for _ in range(_ROUNDS if self.compiled else 0):
            parents = rated[:KEPT]
            changed = [self._change(random, parents[k % len(parents)].trial, rated)
                       for k in range(_CHANGED)]
            rated = self.rate([entry.trial for entry in rated] + changed)
        return rated

    @staticmethod
    def pure(duration: float) -> list[Trial]:
        """Return one trial of each family."""
        return [Trial((Segment(family, k, duration - SPIN_UP),))
                for k, family in enumerate(FAMILIES)]

    @staticmethod
    def _mixture(random: np.random.Generator, duration: float) -> Trial:
        count = int(random.integers(2, 4))
        families = random.choice(list(FAMILIES), count, replace=False)
        return Trial(tuple(Segment(str(family), int(random.integers(1000)),
                                   (duration - SPIN_UP) / count) for family in families),
                     bool(random.random() < _WARM_SHARE))

    @staticmethod
    def _change(random: np.random.Generator, trial: Trial, rated: Sequence[Rated]) -> Trial:
        """Redraw a segment, or put one of another good trial in its place."""
        segments = list(trial.segments)
        place = int(random.integers(len(segments)))
        family = segments[place].family
        if random.random() < 0.5:
            other = rated[int(random.integers(min(2 * KEPT, len(rated))))].trial
            family = other.segments[int(random.integers(len(other.segments)))].family
        segments[place] = segments[place]._replace(family=family,
                                                   seed=int(random.integers(1000)))
        return trial._replace(segments=tuple(segments))

    def verified(self, trial: Trial, added: tuple[str, ...] = ()) -> Verified:
        """
        Try a test on noisy records of every rival.

        Judged as a diagnosis will: together with what is known, a plain drilling log without
        the added sensors.
        """
        self.progress('verifying the best tests')
        known = Record(self.scenario(plain_drilling(_KNOWN)), self.channels)
        test = Record(self.scenario(trial), (*self.channels, *added))
        return Verified(trial, added, tuple(
            verify(self.rig, [known, test], self.models, self.likely, _SEED)))

    def best(self, rated: Sequence[Rated], duration: float,
             added: tuple[str, ...] = ()) -> Verified:
        """
        Return the first test that is clear once verified, else the best.

        It is played twice if there is time: the more blocks to judge on.
        """
        found = []
        for trial, _ in rated:
            twice = trial._replace(segments=trial.segments + trial.segments)
            trial = twice if twice.duration <= duration + 1e-6 else trial
            found.append(self.verified(trial, added))
            if found[-1].clear == 1.0:
                break
        return max(found, key=lambda entry: (entry.clear, worth(entry.apart)))
