# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How well a test would tell rival explanations apart.

Expected: linearised, from one rehearsal. Of the difference between two rivals that part counts
which neither the second one's own parameters nor the unit's tolerances can take up, and that is
more than a real machine is off any formula. Verified: every rival in turn makes noisy records of
what is known and of the test, all are fitted to both, and weighed as in a diagnosis.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Iterable, NamedTuple, Sequence

from hst_drive.design.rehearse import INPUTS, rehearse
from hst_drive.design.trials import SPIN_UP
from hst_drive.effects import catalogue
from hst_drive.identify.alternatives import CREDIBLE
from hst_drive.identify.campaign import BLOCK, Campaign, Model
from hst_drive.identify.search import at_its_end, Candidate, Search
from hst_drive.identify.unknowns import SIGMAS, Unknowns
from hst_drive.identify.weigh import log_odds
from hst_drive.load.scenario import Scenario
from hst_drive.measure.run import Run
from hst_drive.model import Drive
from hst_drive.rig import Rig
import numpy as np
from scipy.optimize import lsq_linear

CLEAR = (2 * CREDIBLE)**0.5     # sigma of the worst pair at which a diagnosis tells rivals apart
# Times the squared difference that another formula could make: a machine is off in its own way.
_SAFE = 2.0
_OFF = 0.06             # of what an effect does, by which its formula is off
EMPTY = 0.015           # of the relief valve's set pressure: the line is not safely filled
_TRUTHS = 4             # explanations that make records of their own, the likeliest
_HELD_OUT = 1 / 3       # share of the blocks that will judge
_INDEPENDENT = 20.0     # independent samples in a block of noise
_SHOWN = 0.06           # of the squared error: less shows nothing surely
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


@dataclass
class _Part:
    """One signal: rows in time, block of each row, one over its floor and the weights."""

    signal: str
    blocks: np.ndarray
    floor: float
    thin: float
    shifts: np.ndarray      # (models, rows) reading of each model, in floors
    bare: np.ndarray        # (rows,) the same without what the models differ in
    factors: np.ndarray     # (rows, factors)
    own: list[np.ndarray]   # per model (rows, parameters)


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
        bare = campaign.errors(common)
        moved = [campaign.errors(model) if place else base for place, model in enumerate(models)]
        factors = [self._derivative(campaign, 0, k, base) for k in range(count)]
        own = [[self._derivative(campaign, place, k, moved[place])
                for k in range(count, len(self.vectors[place]))]
               for place in range(len(models))]
        self.parts = []
        for index, column in enumerate(campaign.columns):
            rows = np.sort(np.concatenate([column.fit, column.judge]))
            trust = column.trust[rows]

            def taken(errors, index=index, rows=rows, trust=trust):
                return errors[index][rows] * trust

            time = campaign.replays[0].run.time
            self.parts.append(_Part(
                column.signal, ((time[rows] - time[0]) / BLOCK).astype(int),
                1.0 / column.scale, campaign.thinning(column),
                np.array([taken(errors) for errors in moved]), taken(bare),
                np.array([taken(entry) for entry in factors]).T,
                [np.array([taken(entry) for entry in group]).T if group
                 else np.zeros((len(rows), 0)) for group in own]))

    def _derivative(self, campaign: Campaign, place: int, k: int, base) -> list[np.ndarray]:
        unknowns, vector = self.unknowns[place], self.vectors[place].copy()
        step = 0.5 if k < unknowns.factors else 0.1 * max(abs(vector[k]), 0.3)
        step = -step if vector[k] + step > unknowns.high[k] else step
        vector[k] += step
        return [(there - here) / step
                for there, here in zip(campaign.errors(unknowns.unpack(vector)), base)]

    def pair(self, truth: int, rival: int, channels: Iterable[str]) -> Pair:
        """Return what would tell a rival from the truth with these channels."""
        chosen = [part for part in self.parts if part.signal in set(channels)]
        unknowns, vector = self.unknowns[rival], self.vectors[rival]
        count = len(vector)
        normal, gradient = np.zeros((count, count)), np.zeros(count)
        for part in chosen:
            columns = np.hstack([part.factors, part.own[rival]]) * part.thin
            normal += columns.T @ columns
            gradient += columns.T @ (part.shifts[rival] - part.shifts[truth]) * part.thin
        prior = np.zeros(count)
        prior[:unknowns.factors] = 1.0
        gradient += prior * vector
        root = np.linalg.cholesky(normal + np.diag(prior) + np.diag(1e-9 * np.diag(normal) + 1e-9))
        move = lsq_linear(root.T, np.linalg.solve(root, -gradient),
                          (unknowns.low - vector - 1e-9, unknowns.high - vector + 1e-9)).x
        energy, sigmas, amount, form, differences = 0.0, [0.0], 0.0, 0.0, {}
        for part in chosen:
            left = (part.shifts[rival] - part.shifts[truth] + np.hstack(
                [part.factors, part.own[rival]]) @ move)
            energy += float(left @ left) * part.thin**2
            count = np.bincount(part.blocks)
            blocks = (np.bincount(part.blocks, left**2) / np.maximum(count, 1))[count > 0]
            sigmas.append(expected_sigma(blocks))
            amount += float(blocks.mean())
            form += float(np.mean((part.shifts[truth] - part.bare)**2))
            rms = float(np.sqrt(np.mean(left**2))) if len(left) else 0.0
            differences[part.signal] = Difference(
                rms * part.floor, rms, float(np.max(np.abs(left), initial=0.0)) * part.floor)
        form *= _uncertainty(self.models[truth], self.models[rival])**2
        return Pair(truth, rival, float(min(
            max(sigmas) * min(amount / (_SAFE * form + 1e-9), 1.0), np.sqrt(energy), _MOST)),
            differences)

    def pairs(self, channels: Iterable[str], likely: int | None = None) -> list[Pair]:
        """Return the pairs of one of the first ``likely`` models (all) with one after it."""
        channels = tuple(channels)
        return [self.pair(truth, rival, channels) for truth in range(likely or len(self.models))
                for rival in range(truth + 1, len(self.models))]


def expected_sigma(blocks: np.ndarray) -> float:
    """
    Return the significance that held-out blocks would give, as ``judge.gain`` forms it.

    Parameters
    ----------
    blocks : ndarray, shape (blocks,)
        Mean squared difference of the models in each block, in squared floors.

    """
    held = max(len(blocks) * _HELD_OUT, 3.0)
    spread = np.abs(blocks - np.median(blocks))
    limit = 4 * np.median(spread) * 1.48 + 0.1
    clipped = np.clip(blocks, None, np.median(blocks) + limit)
    noise = 4 * clipped.mean() / _INDEPENDENT
    error = np.sqrt((clipped.var() + noise) / held) + 1e-9
    share = blocks.mean() / (1.0 + blocks.mean())
    return float(min(clipped.mean() / error, _MOST) * min(share / _SHOWN, 1.0))


def _pressure(run: Run) -> np.ndarray:
    return run['pump_outlet_pressure'][run.time > SPIN_UP]


def driver(rig: Rig, model: Model) -> Drive:
    """Return a drive with a model's effects and factors."""
    drive = Drive(rig, model.effects, max_step=5e-3)
    drive.scale({key: float(np.exp(value)) for key, value in model.factors.items()})
    return drive


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
    ended = [any(at_its_end(search.campaign, rival.fit.model, name) for name in rival.names
                 if name not in best.names) for rival in rivals]
    odds = log_odds(search, [best, *rivals])[1:]
    return float(np.where(ended, _MOST, np.sqrt(2.0 * np.maximum(-odds, 0.0))).min())


def _uncertainty(first: Model, second: Model) -> float:
    """Return by which share of what they do the formulas of effects that differ may be off."""
    known = catalogue()
    return max((max(known[name].formula_error, known[other].formula_error)
                for name in first.effects for other in second.effects
                if other in known[name].alike and name not in second.effects
                and other not in first.effects), default=_OFF)


def within_limits(factors: dict[str, float], tolerances: dict[str, float]) -> dict[str, float]:
    """Return a unit's factors (natural logarithms) held within their limits."""
    return {key: float(np.clip(value, -SIGMAS * tolerances[key], SIGMAS * tolerances[key]))
            for key, value in factors.items() if key in tolerances}
