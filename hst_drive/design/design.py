# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The next test: a profile, or a sensor, that separates effects which the logs cannot.

Trials of all families, and mixtures of them, are rehearsed; those that set the likely
explanations furthest apart are improved by random search and then verified as a diagnosis will
judge. Where none is clear the same is tried with each sensor that could be added, and where that
still leaves rivals, with a second one.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, Iterable, Sequence

from hst_drive.design.designer import ANY, Designer, KEPT, Rated, Verified
from hst_drive.design.rivals import told_apart
from hst_drive.design.separation import CLEAR, driver, Pair
from hst_drive.design.trials import LONGEST, plain_drilling, scenario, Trial
from hst_drive.effects import catalogue
from hst_drive.errors import InputError
from hst_drive.identify.model import Model
from hst_drive.rig import Rig

_TOO_LITTLE = 2.0       # sigma beyond what any test is worth: below, a quick look found none
SHORTEST = 20.0         # s
_QUICK = 33.0           # s
_VERIFIED = 3           # tests that are verified
_SENSORS = 2            # sensors that are
EXTRA = ('motor_inlet_pressure', 'motor_outlet_pressure', 'case_drain_flow', 'pump_displacement',
         'pump_speed', 'motor_inlet_flow', 'motor_speed', 'load_torque', 'pump_outlet_pressure')


@dataclass(frozen=True)
class Design:
    """
    A test that separates rivals, or the reason why there is none.

    Attributes
    ----------
    rivals : tuple of tuple of str
        The effects of each explanation.
    advice : str
        'profile': the scenario separates, the best explanation at least; 'sensor': any test does
        with the added channels; 'both': the scenario does, with the channels; 'neither'.
    trial : Trial
        The best test.
    content : dict
        It, as the mapping of a scenario file.
    significance : float
        Verified, worst pair, sigma; with the sensors that are advised.
    without_sensor : float
        The same with the channels that are there.
    sensors : tuple of str
        Channels to add, at most two.
    options : dict of str to float
        What a test is expected to be worth with each channel added, sigma.
    pairs : tuple of Pair
        Expected for each pair, linearised.
    unclear : tuple of tuple of str
        Explanations that would not come out clearly if they were the truth.

    """

    rivals: tuple[tuple[str, ...], ...]
    advice: str
    trial: Trial
    content: dict
    significance: float
    without_sensor: float
    sensors: tuple[str, ...] = ()
    options: dict[str, float] = field(default_factory=dict)
    pairs: tuple[Pair, ...] = ()
    unclear: tuple[tuple[str, ...], ...] = ()

    @property
    def gauges(self) -> tuple[str, ...]:
        """What would measure by itself one of the explanations that stay unclear."""
        return tuple(dict.fromkeys(
            catalogue()[name].gauge for names in self.unclear for name in names
            if catalogue()[name].gauge))

    def difference(self, sensor: str) -> float:
        """Return the smallest difference between rivals, SI, that an added sensor has to show."""
        shown = [pair.differences[sensor] for pair in self.pairs if sensor in pair.differences]
        seen = [entry.rms for entry in shown if entry.floors >= 1.0]
        return min(seen or [max((entry.rms for entry in shown), default=0.0)])


def design(rig: Rig, models: Sequence[Model], channels: Iterable[str], *,
           duration: float = LONGEST, closed_loop: bool = False, likely: int = 0,
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
    likely : int
        So many of the models, the first, may be the truth; 0 for all.
    progress : callable
        Called with a text while the work goes on.

    Raises
    ------
    InputError
        If the rig lacks a section, or the duration is out of range.

    """
    if not SHORTEST <= duration <= LONGEST:
        raise InputError(f'duration {duration:g}: expected {SHORTEST:g} to {LONGEST:g} s')
    work = Designer(rig, models, channels, closed_loop=closed_loop, likely=likely,
                    progress=progress)
    rated = work.search(max(duration / 2, SHORTEST))
    plain = found = work.best(_different(rated), duration)
    advice, options = 'profile' if plain.apart[0] >= CLEAR else 'neither', {}
    if plain.clear < 1.0:
        options = _sensors(work, rated)
        for name in sorted(options, key=lambda name: -options[name].worth)[:_SENSORS]:
            tried = work.best([options[name]], duration, (name,))
            if tried.clear > found.clear:
                found = tried
        if found.sensors and found.clear < 1.0:
            found = _second(work, found)
    if found.sensors:
        any_test = work.verified(plain_drilling(found.trial.duration), found.sensors)
        advice = 'sensor' if any_test.clear >= found.clear else 'both'
    trial = found.trial
    names = tuple(tuple(model.effects) for model in models)
    title = 'Tell apart: ' + ', '.join(told_apart(models))
    return Design(
        names, advice, trial, {**scenario(trial, rig, closed_loop, title), 'seed': 1},
        min(found.apart), min(plain.apart), found.sensors,
        {name: entry.worth - ANY for name, entry in options.items()},
        tuple(work.rehearsal(trial).pairs((*work.channels, *found.sensors), work.likely)),
        tuple(entry for entry, sigma in zip(names, found.apart) if sigma < CLEAR))


def _different(rated: Sequence[Rated]) -> list[Rated]:
    """Return the best tests that differ in kind."""
    kinds: dict[tuple, Rated] = {}
    for entry in rated:
        kinds.setdefault((frozenset(part.family for part in entry.trial.segments),
                          entry.trial.warming), entry)
    return list(kinds.values())[:_VERIFIED]


def _sensors(work: Designer, rated: Sequence[Rated]) -> dict[str, Rated]:
    """Return, by channel, the test that suits it and what is expected."""
    shortlist = [entry.trial for entry in rated[:KEPT]]
    shortlist += [trial for trial in work.pure(shortlist[0].duration) if trial not in shortlist]
    found: dict[str, Rated] = {}
    for trial in shortlist:
        work.progress('trying sensors')
        if work.rate([trial])[0].worth == 0.0:
            continue
        rehearsal = work.rehearsal(trial)
        for name in EXTRA:
            if name not in work.channels:
                entry = Rated(trial, work.worth(trial, rehearsal, (*work.channels, name)))
                found[name] = max(found.get(name, entry), entry, key=lambda item: item.worth)
    return found


def _second(work: Designer, found: Verified) -> Verified:
    """
    Return a test with a second sensor if that leaves fewer rivals, else the test itself.

    All are verified: what is left is a pair or two, which the rating of a test hardly sees.
    """
    have = (*work.channels, *found.sensors)
    for name in EXTRA:
        if name not in have and found.clear < 1.0:
            tried = work.verified(found.trial, (*found.sensors[:1], name))
            found = max(found, tried, key=lambda entry: entry.clear)
    return found


def in_short(rig: Rig, models: Sequence[Model], channels: Iterable[str]) -> str:
    """Return in one sentence what kind of test would help, from a quick look."""
    pointer = "'hst-drive design' with this diagnosis writes the test"
    if rig.controller is None or rig.loading is None or not driver(rig, Model()).kernel.compiled:
        return f'{pointer}, or names the sensor, that separates them'
    work = Designer(rig, models, channels)
    best = work.rate(work.pure(_QUICK))[0]
    if best.worth < ANY + _TOO_LITTLE:
        return ("a quick look found no test with these channels; 'hst-drive design' with this "
                'diagnosis looks closer: it writes one, or names the sensor to add')
    return f'{best.trial.words}, about two minutes; {pointer}'
