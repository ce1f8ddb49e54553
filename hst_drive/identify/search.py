# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The search for what is missing: every candidate is fitted, the best are combined.

Forward with a small beam: an effect more as long as the evidence decides for it. What stands of
that is asked afterwards (``standing``), and what could stand in its place (``alternatives``).
"""
from __future__ import annotations

from dataclasses import replace
from math import inf, log
from typing import Callable, Iterable, NamedTuple, Sequence

from hst_drive.effects import effect_of, flexible
from hst_drive.identify.calibrate import calibrated
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.conditions import learnt
from hst_drive.identify.evidence import CREDIBLE, DECIDED, STRONG
from hst_drive.identify.fit import each, ended, Fit, fit, score
from hst_drive.identify.judge import (
    contribution, matters, parts, PRACTICAL, taken, unexplained)
from hst_drive.identify.phases import in_step
from hst_drive.identify.score_test import score_test
from hst_drive.identify.shapes import shapes_of, with_usual_shapes
from hst_drive.identify.starts import starts
from hst_drive.identify.weigh import log_odds
import numpy as np

MOST_EFFECTS = 4
BEAM = 2            # candidates that are fitted with a Jacobian of their own
_SHORTLIST = 8
_PROMISING = 0.7    # of the baseline's cost: then every near start is fitted to its end
_NEAR = 1.5         # of the best start's cost
_ROUNDS = 5
_NEW_VALLEY = 0.95      # of the score: usual shapes that gain more opened the way for others


class Candidate(NamedTuple):
    """A fitted set of effects and its score; lower is better."""

    names: tuple[str, ...]
    fit: Fit
    score: float


class Search:
    """Fits and remembers sets of effects; ``candidates`` are those to try."""

    def __init__(self, campaign: Campaign, candidates: Sequence[str],
                 progress: Callable[[str], None] = lambda text: None):
        self.campaign = campaign
        self.candidates = tuple(candidates)
        self.progress = progress
        self.base = calibrated(campaign)
        # The same unit without what logs told of it: all that is taken away is off its formulas.
        told = {name: effect_of(name).neutral for name in learnt(campaign.rig)}
        self.bare = self.base._replace(errors=campaign.errors(replace(
            self.base.model, effects=told))) if told else self.base
        self.campaign = in_step(campaign, self.base.model, self.base.errors)
        self.baseline = Candidate((), self.base, self.score(self.base))
        self._known: dict[tuple[str, ...], Candidate] = {(): self.baseline}
        self._refined: dict[tuple[str, ...], Candidate] = {}
        #: What is not listed and was fitted, each with the campaign that it was fitted in.
        self.unlisted: list[tuple[Campaign, Fit]] = []

    def score(self, fitted: Fit) -> float:
        """Return the score of a fit (``fit.score``); lower is better."""
        return score(self.campaign, fitted)

    def try_all(self, sets: Sequence[tuple[tuple[str, ...], Fit]], what: str,
                again: bool = False) -> list[Candidate]:
        """
        Fit sets of effects on all cores, each from a fit's model and Jacobian.

        Known sets not, or if ``again`` the better counts.
        """
        todo = [(tuple(sorted(names)), start) for names, start in sets
                if again or tuple(sorted(names)) not in self._known]
        # The long ones first, so that no core waits for them at the end.
        todo.sort(key=lambda task: -sum(len(effect_of(name).starts)
                                        for name in task[0]))

        def fitted(task: tuple[tuple[str, ...], Fit]) -> Candidate:
            found = self._fit(task)
            return found if len(sets) == 1 else found._replace(fit=found.fit.light())

        for done, found in enumerate(each(fitted, todo)):
            self._known[found.names] = min(
                found, self._known.get(found.names, found), key=lambda item: item.score)
            self.progress(f'{what}: {done + 1} of {len(todo)}')
        return [self._known[tuple(sorted(names))] for names, _ in sets]

    def _fit(self, task: tuple[tuple[str, ...], Fit]) -> Candidate:
        names, start = task
        new = next((name for name in names if name not in start.model.effects), None)
        alone = self._known.get((new,))
        models = [start.model] if new is None else starts(
            self.campaign, self.base.jacobian, start.model, new,
            alone.fit.model.effects[new] if alone else None)
        if not models:
            typical = start.model.with_effect(new, self.campaign.typical(new))
            return self.candidate(names, fit(self.campaign, typical, iterations=0,
                                             known=start.columns).light())
        # Sizes first: a shape that is free from the start may end far from what it could be.
        shapes = shapes_of(names)
        found = [fit(self.campaign, model, known=start.columns, kept=shapes) for model in models]
        best = min(found, key=lambda item: item.cost)
        if len(found) > 1 and best.cost < _PROMISING * self.base.cost:
            # Where valleys are deep the first steps do not tell which is the deepest.
            best = min((fit(self.campaign, item.model, iterations=3, known=item.columns,
                            kept=shapes)
                        for item in found if item.cost < _NEAR * best.cost),
                       key=lambda item: item.cost)
        sized = self.candidate(names, best)
        if not shapes:
            return sized
        free = self.candidate(names, fit(self.campaign, best.model, known=best.columns))
        return min(sized, free, key=lambda item: item.score)

    def candidate(self, names: tuple[str, ...], found: Fit) -> Candidate:
        """Return a fit of these effects with its score."""
        total = self.score(found)
        if ended(self.campaign, found.model, names):
            # A shape at the end of its range stands for another effect.
            total = max(total, self.baseline.score)
        return Candidate(names, found, total)

    def whole(self, candidate: Candidate) -> Candidate:
        """Return a candidate with the Jacobian of its fit, formed anew where it was dropped."""
        if len(candidate.fit.columns) == len(candidate.fit.names):
            return candidate
        return candidate._replace(fit=fit(
            self.campaign, candidate.fit.model, iterations=0, refresh=True))

    def taken(self, before: Candidate, after: Candidate,
              held_out: bool | None = True) -> dict[str, float]:
        """Return the share of the squared error that the second takes, events and all."""
        return taken(*(self.campaign.blocks(entry.fit.errors, held_out)
                       for entry in (before, after)))

    def odds(self, before: Candidate, after: Sequence[Candidate]) -> np.ndarray:
        """Return the log odds of candidates against another; -inf with an effect at its end."""
        found = np.full(len(after), -np.inf)
        held = [index for index, entry in enumerate(after)
                if not ended(self.campaign, entry.fit.model, entry.names)]
        found[held] = log_odds(self, [before, *(after[index] for index in held)])[1:]
        return found

    def asked(self, before: Candidate, after: Candidate) -> bool:
        """
        Say whether the logs ask for what the second candidate has more: they are likelier.

        What leaves nothing unexplained need not be likelier, if the evidence does not speak
        against it. Where nothing was, it must be far likelier (``Campaign.odds_asked``), and what
        is named first by a datasheet must matter. There short events may ask for it as well, for
        which the evidence is too careful; but strong it must be.
        """
        odds = float(self.odds(before, [after])[0])
        if self.unexplained(before):
            return odds > log(DECIDED) or (
                odds > -log(DECIDED) and not self.unexplained(after))
        asked = CREDIBLE if before.names else self.campaign.odds_asked
        if before.names or self.campaign.commissioned_unit or odds <= STRONG:
            return odds > asked
        if odds > asked and any(matters(*(self.campaign.ratios(entry.fit.errors, part)
                                          for entry in (before, after)))
                                for part in parts(self.campaign)):
            return True
        fitted, held_out = (self.taken(before, after, part) for part in (False, True))
        shares = [min(fitted[name], held_out[name]) for name in fitted.keys() & held_out.keys()]
        # The load of a flexible shaft follows rough rock better whether it is there or not.
        return not flexible(after.names) and bool(shares) and (
            max(shares) >= PRACTICAL and min(shares) > -0.5 * PRACTICAL)

    def unexplained(self, candidate: Candidate) -> dict[str, float]:
        """Return the signals that the candidate leaves unexplained."""
        left: dict[str, float] = {}
        for part in parts(self.campaign):
            done = contribution(self.campaign, self.bare, candidate.fit, part)
            left |= unexplained(self.campaign, candidate.fit, done, part)
        return left

    def refine(self, candidate: Candidate) -> Candidate:
        """Fit a candidate with a Jacobian of its own; go on while that explains more."""
        before, self.campaign = self.campaign, in_step(self.campaign, candidate.fit.model)
        if self._refined.get(candidate.names) is candidate and self.campaign is before:
            return candidate
        refined = self._patient(candidate)
        usual = with_usual_shapes(self, refined)
        if usual.score < _NEW_VALLEY * refined.score:
            usual = min(usual, with_usual_shapes(self, self._patient(usual)),
                        key=lambda item: item.score)
        self._known[candidate.names] = self._refined[candidate.names] = usual
        return usual

    def restarted(self, candidate: Candidate, elsewhere: Fit) -> Candidate:
        """Return a candidate, or what it becomes from where another fit ended; the better one."""
        again = self._patient(candidate._replace(fit=elsewhere.only(candidate.names)))
        if again.score >= candidate.score:
            return candidate
        self._known[candidate.names] = self._refined[candidate.names] = again
        return again

    def anew(self, candidate: Candidate, names: Iterable[str]) -> Candidate:
        """
        Return a candidate, or what it becomes where effects start anew; the better one.

        Beside the others another of their forms may be right than alone.
        """
        for name in names:
            found = self.try_all([(candidate.names, candidate.fit.without(name))],
                                 'starting anew', again=True)[0]
            if found.score < candidate.score:
                candidate = self.refine(found)
        return candidate

    def _patient(self, candidate: Candidate) -> Candidate:
        known: dict[tuple[str, str], np.ndarray] = {}
        for _ in range(_ROUNDS):
            before = candidate.fit.cost
            found = fit(self.campaign, candidate.fit.model, iterations=3, known=known,
                        refresh=True)
            known = found.columns
            candidate = self.candidate(candidate.names, found)
            if found.cost > 0.98 * before:
                break
        return candidate

    def tried(self) -> list[Candidate]:
        """Return every set that was fitted, the empty one among them."""
        return list(self._known.values())

    def single(self, name: str) -> Candidate:
        """Return the fit with one effect alone."""
        return self.try_all([((name,), self.base)], 'fitting effects')[0]

    def singles(self) -> list[Candidate]:
        """Return every effect alone, the best first."""
        found = self.try_all([((name,), self.base) for name in self.candidates], 'fitting effects')
        return sorted(found, key=lambda item: item.score)

    def extend(self, candidate: Candidate, least: float = 0.0,
               most: int = _SHORTLIST) -> list[Candidate]:
        """
        Return the candidate with one effect more, the best first.

        At ``most`` so many effects are tried that may move the signals as what is left does;
        ``least`` is the share of its square that such a move must take away.
        """
        candidate = self.whole(candidate)
        likely = sorted(score_test(self, candidate), reverse=True)[:most]
        found = self.try_all([((*candidate.names, name), candidate.fit)
                              for share, name in likely if share >= least],
                             f'fitting {len(candidate.names) + 1} effects together')
        return sorted(found, key=lambda item: item.score)

    def _extended(self, best: Candidate, beam: Sequence[Candidate]) -> list[Candidate]:
        """Return what leads on from ``best`` by way of a beam, the most probable first."""
        # Events, or much data, may ask for one more though the whole is near the noise. A machine
        # that is off its formulas has more that takes a hundredth than the evidence knows.
        least = 0.0 if self.unexplained(best) else 0.2 * PRACTICAL
        if least:
            # What evidence does not rule out may lead to what is likelier than all.
            beam = [beam[0], *(entry for entry, value in zip(beam[1:], self.odds(
                beam[0], beam[1:])) if value >= -CREDIBLE)]
        # What stands at an end of its range leads on only where nothing else does.
        standing = [entry for entry in beam if entry.score < self.baseline.score] or beam
        return [*{entry.names: entry for candidate in standing
                  for entry in self.extend(candidate, least)}.values()]

    def run(self) -> Candidate:
        """Return the set of effects that the data ask for; it may be empty."""
        best, level = self.baseline, self.singles()
        while level:
            beam = self._beam(best, level)
            if not self.asked(best, beam[0]):
                # What resonates with the other (ripple on a soft shaft) shows only beside it.
                level = [] if len(beam[0].names) == MOST_EFFECTS else self._extended(best, beam)
                if not level:
                    break
                beam = self._beam(best, level)
                if not self.asked(best, beam[0]):
                    break
            beam[0] = best = self.refine(beam[0])
            if len(best.names) == MOST_EFFECTS:
                break
            level = self._extended(best, beam)
        return best

    def _beam(self, best: Candidate, level: Sequence[Candidate]) -> list[Candidate]:
        """
        Return the most probable candidates, each as good as its own Jacobian makes it.

        That tells which of two that are near each other is the better one, and finds what only a
        Jacobian of its own shows: ripple on a soft shaft. What is at its end stays as it is.
        """
        beam, odds = self.likeliest(best, level)
        return self.likeliest(best, [
            self.refine(entry) if value > -inf and value >= odds[0] - CREDIBLE else entry
            for entry, value in zip(beam, odds)])[0]

    def likeliest(self, best: Candidate, level: Sequence[Candidate]
                  ) -> tuple[list[Candidate], np.ndarray]:
        """Return the most probable candidates, and the log odds of each against ``best``."""
        odds = self.odds(best, level)
        order = np.argsort(-odds)[:BEAM]
        return [level[index] for index in order], odds[order]
