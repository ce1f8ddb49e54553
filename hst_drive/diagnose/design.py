# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The next test: a profile, or a sensor, that separates effects which the logs cannot.

Trials of all families, and mixtures of them, are rehearsed; the one whose worst pair of rivals
is expected to come out furthest apart is improved by random search and then verified.
"""
from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
import os
from typing import Callable, Iterable, NamedTuple, Sequence

from hst_drive.diagnose.campaign import Model
from hst_drive.diagnose.rehearse import sensors
from hst_drive.diagnose.rivals import told_apart
from hst_drive.diagnose.separation import CLEAR, driver, Pair, Rehearsal, verify
from hst_drive.diagnose.trials import (
    ease, FAMILIES, LONGEST, plain_drilling, scenario, Segment, SPIN_UP, Trial)
from hst_drive.errors import InputError
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.load.scenario import parse_scenario, Scenario
from hst_drive.rig import Rig
import numpy as np

HOPELESS = 2.0
SHORTEST = 20.0         # s
_QUICK = 33.0           # s
_SEED = 20260101
_MIXED, _ROUNDS, _CHANGED, _KEPT = 12, 2, 8, 4
_WARM_SHARE = 0.25      # of the mixtures
_RELIEF = 0.95          # of the relief valve's set pressure: what a rehearsal may reach
EXTRA = ('motor_inlet_pressure', 'case_drain_flow', 'pump_displacement', 'pump_speed',
         'motor_inlet_flow', 'motor_speed', 'load_torque', 'pump_outlet_pressure')


class Rated(NamedTuple):
    """A trial and the expected significance of its worst pair."""

    trial: Trial
    worst: float


@dataclass(frozen=True)
class Design:
    """
    A test that separates rivals, or the reason why there is none.

    Attributes
    ----------
    rivals : tuple of tuple of str
        The effects of each explanation.
    advice : str
        'profile': the scenario separates; 'sensor': any test does with the added channel;
        'both': the scenario does, with the channel; 'neither'.
    trial : Trial
        The best test.
    content : dict
        It, as the mapping of a scenario file.
    significance : float
        Verified, worst pair, sigma; with ``sensor`` where one is advised.
    without_sensor : float
        The same with the channels that are there.
    sensor : str
        Channel to add; empty for none.
    options : dict of str to float
        Expected significance of the worst pair with each channel added.
    pairs : tuple of Pair
        Expected for each pair, linearised.

    """

    rivals: tuple[tuple[str, ...], ...]
    advice: str
    trial: Trial
    content: dict
    significance: float
    without_sensor: float
    sensor: str = ''
    options: dict[str, float] = field(default_factory=dict)
    pairs: tuple[Pair, ...] = ()


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
    progress : callable
        Called with a text.

    """

    def __init__(self, rig: Rig, models: Sequence[Model], channels: Iterable[str], *,
                 closed_loop: bool = False, progress: Callable[[str], None] = lambda text: None):
        self.rig, self.models = rig, tuple(models)
        self.channels = tuple(name for name in channels if name in sensors(rig))
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
        with ThreadPoolExecutor(max(os.cpu_count() or 1, 1)) as pool:
            for rated in pool.map(self._rate, todo):
                self._known[rated.trial] = rated
                self.progress(f'rehearsing tests: {len(self._known)}')
        return sorted((self._known[trial] for trial in dict.fromkeys(trials)),
                      key=lambda entry: -entry.worst)

    def _rate(self, trial: Trial) -> Rated:
        rehearsal = self.rehearsal(trial)
        if rehearsal.highest > _RELIEF * self.rig.relief_valve.set_pressure:
            return Rated(trial, 0.0)
        worst = self.worst(rehearsal, self.channels)
        return Rated(trial, worst * ease(trial))

    @staticmethod
    def worst(rehearsal: Rehearsal, channels: Iterable[str]) -> float:
        """Return the lowest expected significance of all pairs, the mean as a tie-break."""
        found = [pair.significance for pair in rehearsal.pairs(channels)]
        return min(found) + 0.05 * float(np.mean(found))

    def search(self, duration: float) -> list[Rated]:
        """Return tests of this duration (s), the best first."""
        random = np.random.default_rng(_SEED)
        pure = self.pure(duration)
        rated = self.rate(pure)
        if self.compiled:
            trials = pure + [entry.trial._replace(warming=True) for entry in rated[:_KEPT]] + [
                self._mixture(random, duration) for _ in range(_MIXED)]
            rated = self.rate(trials)
        for _ in range(_ROUNDS if self.compiled else 0):
            parents = rated[:_KEPT]
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
            other = rated[int(random.integers(min(2 * _KEPT, len(rated))))].trial
            family = other.segments[int(random.integers(len(other.segments)))].family
        segments[place] = segments[place]._replace(family=family,
                                                   seed=int(random.integers(1000)))
        return trial._replace(segments=tuple(segments))

    def verified(self, trial: Trial, channels: Iterable[str]) -> float:
        """Return the significance of the worst pair from noisy records of every rival."""
        self.progress('verifying the best test')
        return verify(self.rig, self.scenario(trial), self.models, channels, _SEED)

    def long_enough(self, trial: Trial, channels: Iterable[str], duration: float,
                    expected: float) -> tuple[Trial, float]:
        """Return the trial, played twice where once is not enough, and what it reaches."""
        twice = trial._replace(segments=trial.segments + trial.segments)
        fits = twice.duration <= duration + 1e-6
        if not fits or expected >= CLEAR:
            reached = self.verified(trial, channels)
            if not fits or reached >= CLEAR:
                return trial, reached
        return twice, self.verified(twice, channels)


def design(rig: Rig, models: Sequence[Model], channels: Iterable[str], *,
           duration: float = LONGEST, closed_loop: bool = False,
           progress: Callable[[str], None] = lambda text: None) -> Design:
    """
    Find the test that separates rivals.

    Parameters
    ----------
    rig : Rig
        Baseline that was diagnosed.
    models : sequence of Model
        At least two explanations, with the sizes that they would have (``matched``).
    channels : sequence of str
        Signals that the rig records.
    duration : float
        Longest test, s.
    closed_loop : bool
        Whether the controller holds the speed; else its commands are given.
    progress : callable
        Called with a text while the work goes on.

    Raises
    ------
    InputError
        If the rig lacks a section, or the duration is out of range.

    """
    if not SHORTEST <= duration <= LONGEST:
        raise InputError(f'--duration {duration:g}: expected {SHORTEST:g} to {LONGEST:g} s')
    work = Designer(rig, models, channels, closed_loop=closed_loop, progress=progress)
    # Half the time, played twice where once is not enough: more blocks to judge on.
    half = max(duration / 2, SHORTEST)
    rated = work.search(half)
    trial = rated[0].trial
    trial, reached = work.long_enough(trial, work.channels, duration, rated[0].worst)
    advice, sensor, alone, options = 'profile', '', reached, {}
    if reached < CLEAR:
        options = _sensors(work, rated, duration)
        sensor, trial, reached, advice = _with_sensor(work, options, duration, trial, reached)
    pairs = work.rehearsal(trial).pairs((*work.channels, sensor))
    names = tuple(tuple(model.effects) for model in models)
    title = 'Tell apart: ' + ', '.join(told_apart(models))
    return Design(names, advice, trial, {**scenario(trial, rig, closed_loop, title),
                                         'seed': 1}, reached, alone, sensor,
                  {name: entry[0] for name, entry in options.items()}, tuple(pairs))


def _sensors(work: Designer, rated: Sequence[Rated],
             duration: float) -> dict[str, tuple[float, Trial]]:
    """Return, by channel, the expected significance with it and the test that suits it."""
    shortlist = [entry.trial for entry in rated[:_KEPT]]
    shortlist += [trial for trial in work.pure(shortlist[0].duration) if trial not in shortlist]
    found: dict[str, tuple[float, Trial]] = {}
    for trial in shortlist:
        work.progress('trying sensors')
        if work.rate([trial])[0].worst == 0.0:
            continue
        rehearsal = work.rehearsal(trial)
        for name in EXTRA:
            if name not in work.channels and name in sensors(work.rig):
                worst = work.worst(rehearsal, (*work.channels, name))
                if name not in found or worst > found[name][0]:
                    found[name] = worst, trial
    return found


def _with_sensor(work: Designer, options, duration: float, trial: Trial,
                 reached: float) -> tuple[str, Trial, float, str]:
    """Return the sensor to add, the test, what both reach, and the advice."""
    name = max(options, key=lambda key: options[key][0], default='')
    if name:
        suited = options[name][1]
        channels = (*work.channels, name)
        suited, value = work.long_enough(suited, channels, duration, options[name][0])
        if value >= CLEAR:
            plain = work.verified(plain_drilling(suited.duration), channels)
            return name, suited, value, 'sensor' if plain >= CLEAR else 'both'
    # A sensor that does not suffice is not advised.
    return '', trial, reached, 'neither'


def in_short(rig: Rig, models: Sequence[Model], channels: Iterable[str]) -> str:
    """Return in one sentence what kind of test would help, from a quick look."""
    pointer = "'hst-drive design' with this diagnosis writes the test"
    if rig.controller is None or rig.loading is None or not driver(rig, Model()).kernel.compiled:
        return f'{pointer}, or names the sensor, that separates them'
    work = Designer(rig, models, channels)
    best = work.rate(work.pure(_QUICK))[0]
    if best.worst < HOPELESS:
        return ('no simple load and command profile separates them with these channels; '
                f'{pointer} or names the sensor to add')
    return f'{best.trial.words}, about two minutes; {pointer}'
