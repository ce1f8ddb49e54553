# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a search has fitted, as explanations that are weighed against each other (``evidence``)."""
from __future__ import annotations

from typing import Mapping, Sequence

from hst_drive.diagnose.campaign import Campaign
from hst_drive.diagnose.evidence import (
    decided, Explanation, independent, laplace, Probability, probability, Signal)
from hst_drive.diagnose.fit import at_its_end, Fit
from hst_drive.diagnose.judge import CLEAN_RATIO
from hst_drive.diagnose.result import UNIT_ALONE
from hst_drive.diagnose.search import Candidate, Search
from hst_drive.diagnose.unknowns import Unknowns
import numpy as np


def weigh(search: Search, best: Candidate, rivals: Mapping[str, Sequence[str]],
          verdict: str) -> Probability:
    """
    Return how probable each set is that a search has fitted.

    Parameters
    ----------
    search : Search
        What was tried; a set with an effect at the end of its range is no explanation.
    best : Candidate
        The set that was found.
    rivals : mapping of str to sequence of str
        What could stand in the place of each of its effects.
    verdict : str
        What was decided.

    """
    campaign = search.campaign
    tried = [entry for entry in search.tried() if entry.names == best.names or not any(
        at_its_end(campaign, entry.fit.model, name) for name in entry.names)]
    lead = best if best.names else min((entry for entry in tried if entry.names),
                                       key=lambda entry: entry.score, default=best)
    most = _counted(campaign)
    worth = _independent(campaign, search.base, lead.fit, most)
    share = sum(worth.values()) / sum(most.values())
    found = [Explanation(entry.names, _signals(campaign, search.base, entry.fit),
                         _penalty(campaign, entry.fit, share)) for entry in tried]
    samples = {name: worth[name] / max(len(signal.squares), 1)
               for name, signal in found[0].signals.items()}
    named = [best.names, *(
        tuple(sorted({*best.names} - {name} | {rival} - {UNIT_ALONE}))
        for name, group in rivals.items() for rival in group)]
    return decided(probability(found, samples, len(search.candidates)), verdict, named)


def _blocks(campaign: Campaign, errors: Sequence[np.ndarray]) -> dict[str, np.ndarray]:
    """Return the mean squared errors of all blocks, fitted and judged, by signal."""
    parts = [campaign.blocks(errors, held_out) for held_out in (False, True)]
    found = {name: np.concatenate([part[name] for part in parts]) for name in campaign.signals}
    return {name: values[np.isfinite(values)] for name, values in found.items()}


def _signals(campaign: Campaign, base: Fit, fitted: Fit) -> dict[str, Signal]:
    moved = _blocks(campaign, [one - other for one, other in zip(fitted.errors, base.errors)])
    return {name: Signal(squares, moved[name], CLEAN_RATIO**2 + campaign.scatter(name))
            for name, squares in _blocks(campaign, fitted.errors).items()}


def _counted(campaign: Campaign) -> dict[str, float]:
    """Return the samples of each signal, those closer than 0.1 s counted as one."""
    most = dict.fromkeys(campaign.signals, 0.0)
    for column in campaign.columns:
        most[column.signal] += (len(column.fit) + len(column.judge)) * campaign.thinning(
            column)**2
    return most


def _independent(campaign: Campaign, base: Fit, lead: Fit,
                 most: Mapping[str, float]) -> dict[str, float]:
    """
    Return the independent samples of each signal: as often as what effects do to it changes.

    By its size, since a replay that rings is not the freer for that.
    """
    moved: dict[str, list[np.ndarray]] = {name: [] for name in campaign.signals}
    for one, other, column in zip(lead.errors, base.errors, campaign.columns):
        used = np.sort(np.concatenate([column.fit, column.judge]))
        moved[column.signal].append(np.abs((one - other) * column.trust)[used])
    return {name: independent(np.concatenate(parts), most[name])
            for name, parts in moved.items()}


def _penalty(campaign: Campaign, fitted: Fit, share: float) -> float:
    unknowns = Unknowns(campaign, fitted.model)
    known = {name: place for place, name in enumerate(unknowns.names)}
    place = np.array([known[name] for name in fitted.names], dtype=int)
    jacobian = fitted.jacobian
    return laplace(share * jacobian.T @ jacobian, place < unknowns.factors,
                   (unknowns.high - unknowns.low)[place], unknowns.pack(fitted.model)[place])
