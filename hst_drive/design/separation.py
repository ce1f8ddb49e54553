# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How well a test would tell rival explanations apart.

Expected: linearised, from one rehearsal. Of the difference between two rivals that part counts
which neither the second one's own parameters nor the unit's tolerances can take up, by the same
evidence as in a diagnosis. Verified: every rival in turn makes noisy records of
what is known and of the test, all are fitted to both, and weighed as in a diagnosis.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Container, Iterable, NamedTuple, Sequence

from hst_drive.design.rehearse import INPUTS, rehearse
from hst_drive.design.trials import SPIN_UP
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.evidence import CREDIBLE, expected_odds
from hst_drive.identify.fit import ended
from hst_drive.identify.linearised import Linearised
from hst_drive.identify.model import Model
from hst_drive.identify.search import Candidate, Search
from hst_drive.identify.unknowns import SIGMAS, Unknowns
from hst_drive.identify.weigh import formula_error, log_odds, Means
from hst_drive.load.scenario import Scenario
from hst_drive.measure.run import Run
from hst_drive.model import Drive
from hst_drive.rig import Rig
import numpy as np

CLEAR = (2 * CREDIBLE)**0.5     # sigma of the worst pair at which a diagnosis tells rivals apart
EMPTY = 0.015           # of the relief valve's set pressure: the line is not safely filled
_TRUTHS = 4             # explanations that make records of their own, the likeliest
_MOST = 99.0


class Difference(NamedTuple):
    """A predicted difference of one signal: rms (SI), in floors, and the largest (SI)."""

    rms: float
    floors: float
    largest: float


class Pair(NamedTuple):
    """What tells ``rival`` from ``truth``: expected significance (sigma) and differences."""

    truth: int
    rival: int
    significance: float
    differences: dict[str, Difference]


class Rehearsal:
    """
    A scenario rehearsed with one model, and what the others would do to its signals.

    Parameters
    ----------
    rig : Rig
        Baseline.
    scenario : Scenario
        The test.
    models : sequence of Model
        The rivals; they share their factors of the unit.
    seed : int
        Of noise and roughness.

    """

    def __init__(self, rig: Rig, scenario: Scenario, models: Sequence[Model], seed: int):
        self.models = tuple(models)
        run = rehearse(driver(rig, models[0]), scenario, seed)
        shared = set.intersection(*(set(model.effects) for model in models))
        common = Model({name: models[0].effects[name] for name in shared}, models[0].factors)
        self.highest = float(np.nanmax(_pressure(run)))
        # What a rival adds to the pressure may be the sensor's error: without any the line must
        # stay filled, too.
        self.empty = max(float(np.mean(_pressure(played) < EMPTY * rig.relief_valve.set_pressure))
                         for played in (run, rehearse(driver(rig, common), scenario, seed)))
        campaign = Campaign(rig, [run])
        self.unknowns = [Unknowns(campaign, model) for model in models]
        self.vectors = [unknowns.pack(model) for unknowns, model in zip(self.unknowns, models)]
        count = self.unknowns[0].factors
        base = campaign.errors(models[0])
        self._bare = campaign.errors(Model({}, models[0].factors))
        self._shifts = [campaign.errors(model) if place else base
                        for place, model in enumerate(models)]
        factors = [self._derivative(campaign, 0, k, base) for k in range(count)]
        # By model and unknown.
        self._moves = [[*factors, *(self._derivative(campaign, place, k, self._shifts[place])
                                    for k in range(count, len(self.vectors[place])))]
                       for place in range(len(models))]
        self._campaign, self._means = campaign, Means(campaign)

    def _derivative(self, campaign: Campaign, place: int, k: int, base) -> list[np.ndarray]:
        unknowns, vector = self.unknowns[place], self.vectors[place].copy()
        step = 0.5 if k < unknowns.factors else 0.1 * max(abs(vector[k]), 0.3)
        step = -step if vector[k] + step > unknowns.high[k] else step
        vector[k] += step
        return [(there - here) / step
                for there, here in zip(campaign.errors(unknowns.unpack(vector)), base)]

    def pair(self, truth: int, rival: int, channels: Iterable[str]) -> Pair:
        """Return what would tell a rival from the truth with these channels."""
        channels, columns = {*channels}, self._campaign.columns
        unknowns, vector = self.unknowns[rival], self.vectors[rival]
        apart = [other - own for other, own in zip(self._shifts[rival], self._shifts[truth])]
        *jacobian, off = self._vectors([*self._moves[rival], apart], channels)
        move = Linearised(off, np.array(jacobian).T, vector, unknowns.factors).step(
            unknowns.low - vector, unknowns.high - vector)
        left = [error + sum(step * moves[place] for step, moves in zip(move, self._moves[rival]))
                for place, error in enumerate(apart)]
        moved = [own - bare for own, bare in zip(self._shifts[rival], self._bare)]
        signals = self._means.signals(self._means.of(left), self._means.of(moved))
        odds = expected_odds({name: signal for name, signal in signals.items()
                              if name in channels}, self._means.sensors,
                             formula_error(self.models[rival].effects))
        # What the unit is asked for counts, too.
        asked = np.sum(((vector + move)**2 - vector**2)[:unknowns.factors])
        differences = {}
        for place, column in enumerate(columns):
            if column.signal in channels:
                error, floor = (left[place] * column.weight)[column.rows(None)], 1.0 / column.scale
                rms = float(np.sqrt(np.mean(error**2))) if len(error) else 0.0
                differences[column.signal] = Difference(
                    rms * floor, rms, float(np.max(np.abs(error), initial=0.0)) * floor)
        return Pair(truth, rival, min(float(np.sqrt(max(2.0 * odds + asked, 0.0))), _MOST),
                    differences)

    def _vectors(self, moves: Sequence[Sequence[np.ndarray]],
                 channels: Container[str]) -> list[np.ndarray]:
        """Return errors of all rows that count as vectors, weighted for their correlation."""
        return [np.concatenate([np.zeros(0), *(
            (move[place] * column.weight)[column.rows(None)] * self._campaign.thinning(column)
            for place, column in enumerate(self._campaign.columns)
            if column.signal in channels)]) for move in moves]

    def pairs(self, channels: Iterable[str], likely: int | None = None) -> list[Pair]:
        """Return the pairs of one of the first ``likely`` models (all) with one after it."""
        channels = tuple(channels)
        return [self.pair(truth, rival, channels) for truth in range(likely or len(self.models))
                for rival in range(truth + 1, len(self.models))]


def _pressure(run: Run) -> np.ndarray:
    return run['pump_outlet_pressure'][run.time > SPIN_UP]


def driver(rig: Rig, model: Model) -> Drive:
    """Return a drive with a model's effects and factors."""
    return Drive(rig, max_step=5e-3).changed(model.effects, model.scales)


def recorded(run: Run, channels: Iterable[str]) -> Run:
    """Return what a rig with these channels would have recorded."""
    kept = {*channels, *INPUTS}
    return replace(run, channels={name: values for name, values in run.channels.items()
                                  if name in kept})


class Record(NamedTuple):
    """A scenario and the channels that are recorded of it."""

    scenario: Scenario
    channels: tuple[str, ...]


def verify(rig: Rig, records: Sequence[Record], models: Sequence[Model], likely: int,
           seed: int) -> list[float]:
    """
    Return how far each explanation would come out above the others, in sigma.

    The first ``likely`` models (four at most) make noisy records in turn; all are fitted to
    those, the unit's factors free, and weighed as in a diagnosis. The nearest rival counts.
    """
    apart = []
    for truth, model in enumerate(models[:min(likely, _TRUTHS)]):
        campaign = Campaign(rig, [
            recorded(rehearse(driver(rig, model), play, seed + len(records) * truth + place),
                     channels) for place, (play, channels) in enumerate(records)])
        search = Search(campaign, [])
        best = search.try_all([(tuple(model.effects), search.base._replace(model=model))], '')[0]
        rivals = []
        for rival in (*models[:truth], *models[truth + 1:]):
            names = tuple(rival.effects)
            kept = best.fit.only(names)
            found, = search.try_all([(names, search.base._replace(model=rival))], '')
            if len(names) == len(kept.model.effects) + 1:
                found, = search.try_all([(names, kept)], '', again=True)
            rivals.append(found)
        apart.append(_apart(search, best, rivals))
    return apart


def _apart(search: Search, best: Candidate, rivals: Sequence[Candidate]) -> float:
    """Return in sigma how far a diagnosis would see the best above the nearest rival."""
    lost = [ended(search.campaign, rival.fit.model, {*rival.names} - {*best.names})
            for rival in rivals]
    odds = log_odds(search, [best, *rivals])[1:]
    return float(np.where(lost, _MOST, np.sqrt(2.0 * np.maximum(-odds, 0.0))).min())


def within_limits(factors: dict[str, float], tolerances: dict[str, float]) -> dict[str, float]:
    """Return a unit's factors (natural logarithms) held within their limits."""
    return {key: float(np.clip(value, -SIGMAS * tolerances[key], SIGMAS * tolerances[key]))
            for key, value in factors.items() if key in tolerances}
