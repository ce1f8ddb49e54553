# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a model leaves of the recordings, and how surely another leaves less.

Errors of a replay are correlated over many samples, so that statistics of independent samples
find effects everywhere. Here a sample is a block (``Campaign.block``), and models are compared
block by block.
"""
from __future__ import annotations

from typing import Mapping

from hst_drive.effects.base import FORMULA_ERROR
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit
from hst_drive.identify.recording import at_zero, in_time, lasting
import numpy as np

PRACTICAL = 0.10        # share of the squared error that is worth a name
CLEAN_RATIO = 1.25      # noise ratio up to which a signal counts as explained
CLEAN_FITTED = 1.3      # the same on data that was fitted
REST = 0.25     # of the excess squared error: what leaves more is not what explains it


def taken(before: Mapping[str, np.ndarray], after: Mapping[str, np.ndarray]) -> dict[str, float]:
    """
    Return the share of the squared error that a model takes, by signal, from its blocks.

    Where less than the floor is left, it is a share of that.
    """
    return {name: float((np.nanmean(first) - np.nanmean(after[name]))
                        / max(np.nanmean(first), 1.0))
            for name, first in before.items() if np.isfinite(first).any()}


def excess(ratios: Mapping[str, float]) -> float:
    """Return the squared error beyond the noise, over all signals, in squared floors."""
    return sum(max(value**2 - 1.0, 0.0) for value in ratios.values())


def contribution(campaign: Campaign, base: Fit, model: Fit,
                 held_out: bool | None = True) -> dict[str, float]:
    """Return what the effects of a model do to each signal, rms in floors."""
    total: dict[str, list[float]] = {}
    for first, second, column in zip(base.errors, model.errors, campaign.columns):
        chosen = column.rows(held_out)
        moved = ((first - second) * column.weight)[chosen]
        entry = total.setdefault(column.signal, [0.0, 0.0])
        entry[0] += float(moved @ moved)
        entry[1] += len(moved)
    return {name: float(np.sqrt(power / count)) if count else 0.0
            for name, (power, count) in total.items()}


def matters(before: Mapping[str, float], after: Mapping[str, float]) -> bool:
    """
    Say whether a model takes a tenth of a signal's squared error, from its noise ratios.

    By less a make is off its formulas.
    """
    shares = taken(*({name: np.array([ratio**2]) for name, ratio in ratios.items()}
                     for ratios in (before, after)))
    return max(shares.values(), default=0.0) >= PRACTICAL


def over_own_floors(campaign: Campaign, model: Fit) -> tuple[Campaign, Fit]:
    """
    Return a campaign and a fit in it with the floors of the fitted model itself.

    Models are compared over the same floors. But a shaft that rings answers to the noise of what
    was recorded otherwise than a stiff one, and rock is what the better model does not explain: a
    model is right if it is down to its own floor.
    """
    own = campaign.judging(model.model)
    return own, model._replace(errors=[
        error * (mine.scale / common.scale)
        for error, mine, common in zip(model.errors, own.columns, campaign.columns)])


def parts(campaign: Campaign) -> tuple[bool | None, ...]:
    """
    Return what a model must explain: fitted and held-out rows, each by themselves; or all (None).

    A machine's own numbers were learnt on other logs: then no row of these was fitted, and the
    more rows are judged the less is left to chance.
    """
    return (None,) if campaign.commissioned_unit else (False, True)


def unexplained(campaign: Campaign, model: Fit, done: Mapping[str, float],
                held_out: bool | None = True) -> dict[str, float]:
    """
    Return the signals whose noise ratio, over the model's own floors, is not explained.

    Held-out logs may not visit where something is missing: then the logs that were fitted show
    it. These hold what is hard to replay, so that more may remain on them. What a model may leave
    beyond its floor does not grow with that: ringing hides no error. When between two rows a
    command stepped, and what a sensor reads at zero, is not known; and what no two rows have in
    common is noise, more of it than the floors know (``recording``).
    """
    own, fitted = over_own_floors(campaign, model)
    own = own.without_starts()
    left = _beyond(campaign, own, own.ratios(fitted.errors, held_out), done, held_out)
    if not left:
        return left
    errors = at_zero(own, in_time(own, fitted.errors))
    return _beyond(campaign, own, {
        name: min(ratio, np.sqrt(1.0 + lasting(own, errors, name, held_out)))
        for name, ratio in own.ratios(errors, held_out).items()}, done, held_out)


def _beyond(campaign: Campaign, own: Campaign, ratios: Mapping[str, float],
            done: Mapping[str, float], held_out: bool | None) -> dict[str, float]:
    clean = CLEAN_FITTED if held_out is False else CLEAN_RATIO
    left = {}
    for name, ratio in ratios.items():
        common = _squared_floors(campaign, own, name, held_out)
        if ratio**2 > (1.0 + (clean**2 - 1.0) * min(common, 1.0) + own.scatter(name, held_out)
                       + common * (FORMULA_ERROR * done.get(name, 0.0))**2
                       + own.oil_error(name)**2):
            left[name] = ratio
    return left


def _squared_floors(campaign: Campaign, own: Campaign, name: str,
                    held_out: bool | None) -> float:
    """Return the squared floor of a signal over that of a model with floors of its own."""
    samples, squares = np.array([
        (len(mine.rows(held_out)), (mine.scale / common.scale)**2)
        for common, mine in zip(campaign.columns, own.columns) if common.signal == name]).T
    return float(samples @ squares / max(samples.sum(), 1))
