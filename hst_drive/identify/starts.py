# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the fit of an effect starts: the error may have several valleys."""
from __future__ import annotations

from typing import Mapping, Sequence

from hst_drive.effects import catalogue
from hst_drive.identify.campaign import Campaign, Model
from hst_drive.identify.fit import fit
from hst_drive.identify.linearised import Linearised
from hst_drive.identify.orders import strongest_orders
import numpy as np

_ALIKE = 1e-3   # of the cost: two starts that differ by less lead to the same place
_MANY, _NEAR, _STEPS = 10, 4, 8     # starts; of more the nearest are fitted to the load first
_FEW = 3        # starts that an effect declares which are tried beside others, too


def starts(campaign: Campaign, factors: np.ndarray, base: Model, name: str,
           alone: Mapping[str, float] | None) -> list[Model]:
    """
    Return models to fit from, those that promise most.

    Typical size and a third of it, of either sign, what the effect is alone, and where its
    declaration says, or the order of the swings that are left.

    Parameters
    ----------
    campaign : Campaign
        The data.
    factors : ndarray, shape (samples, factors)
        Jacobian of the unit's factors.
    base : Model
        Without the effect.
    name : str
        The effect.
    alone : mapping of str to float, optional
        Its parameters where it was fitted alone, SI.

    """
    effect, values = catalogue(everything=True)[name], campaign.typical(name)
    size = effect.parameters[0].name
    trials = []
    for share in (1.0, 0.3, -0.3):
        now = campaign.off(name)[size]
        start = now + share * (values[size] - now)
        if share < 0 and start < effect.parameters[0].low:
            continue
        trials.append(base.with_effect(name, {**values, size: start}))
    if effect.order:
        found = strongest_orders(campaign, campaign.errors(base, to_fit=True))
        return [base.with_effect(name, {**values, effect.order: float(entry)})
                for entry in found] or trials[:1]
    further = effect.starts if alone is None or len(effect.starts) <= _FEW else ()
    # In logs of a part what a whole drive alone can tell stays as it is.
    declared = [base.with_effect(name, {**values, **entry}) for entry in further
                if 'parts' not in campaign.searched
                or not any(effect.parameter(key).whole_drive for key in entry)]
    if len(declared) > _MANY:
        declared = _near(campaign, base, declared)
    trials += declared
    if alone is not None:
        trials.append(base.with_effect(name, dict(alone)))
    kept: dict[int, tuple[float, Model]] = {}
    for model in trials:
        promise = _promise(campaign, factors, model)
        # What is as good as one that comes before is not told from it by noise.
        kept.setdefault(round(np.log(promise) / _ALIKE), (promise, model))
    best = sorted(kept.values(), key=lambda entry: entry[0])
    chosen = [model for _, model in best[:2 if further else 1]]
    # Where the error has several valleys a start does not tell how deep its own is.
    return chosen if not further or trials[0] in chosen else [*chosen, trials[0]]


def _near(campaign: Campaign, base: Model, models: Sequence[Model]) -> list[Model]:
    """
    Return what the torque alone, at the measured speed, makes of many starts.

    Where a drive rings, only a start within some hundredths of the truth leads there; the load by
    itself hardly rings, and asks for no simulation. A unit that was calibrated without the effect
    has strayed to make up for it: here it is that of the datasheet.
    """
    load = campaign.of_load()
    if not load.ratios(load.errors(base, to_fit=True), False):
        return list(models)

    def left(model: Model) -> float:
        return max(load.ratios(load.errors(model, to_fit=True), False).values())

    bare = [Model(model.effects) for model in models]
    off = [left(model) for model in bare]
    return [fit(load, bare[place], iterations=_STEPS).model for place in np.argsort(off)[:_NEAR]
            if off[place] < left(base)]


def _promise(campaign: Campaign, factors: np.ndarray, model: Model) -> float:
    """Return the squared error left once the unit's factors are free to help (linearised)."""
    residual = campaign.training(campaign.errors(model, to_fit=True))
    linear = Linearised(residual, factors, np.zeros(factors.shape[1]), factors.shape[1])
    return linear.after(-np.linalg.solve(linear.normal, linear.gradient))
