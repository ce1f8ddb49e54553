# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the fit of an effect starts: the error may have several valleys."""
from __future__ import annotations

from functools import partial
from typing import Iterator, Mapping, Sequence

from hst_drive.effects import effect_of
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import fit, PATIENT
from hst_drive.identify.linearised import Linearised
from hst_drive.identify.model import Model
from hst_drive.identify.phases import strongest_orders
import numpy as np

_ALIKE = 1e-3   # of the cost: two starts that differ by less lead to the same place
_MANY, _NEAR = 10, 4     # starts; of more the nearest are fitted to the load first
_LESS = 0.3     # of its typical size, where it is tried, too
_SOFT = np.geomspace(0.03, 0.6, 12)     # of it, where starts from rest ring by how soft oil is
_SHARES = 0.1, 3.0      # of where it was tried, between which it starts


def starts(campaign: Campaign, factors: np.ndarray, base: Model, name: str,
           alone: Mapping[str, float] | None) -> list[Model]:
    """
    Return models to fit from: the two that promise most, and the first.

    Tried are its typical size and a third of it (of what makes oil soft more, where starts from
    rest count); each form that it declares, at the one of these
    that leaves less; and what the effect is alone. Or the orders of the swings that are left.
    What is not fitted yet starts at the size that would leave least if errors grew in proportion
    to it. A resonance starts where the torque alone says; if the torque is nearer without the
    effect, nowhere. Of an effect that declares no form the best is enough.

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
    effect, values = effect_of(name).sized(*campaign.sizes), campaign.typical(name)
    size = effect.size.name
    off = campaign.off(name)[size]
    # What is adopted keeps its form: only its size is fitted.
    form = {key: value for key, value in values.items()
            if name in campaign.adopted and key != size}

    def shaped(entry: Mapping[str, float]) -> Model:
        return base.with_effect(name, {**values, **entry, **form})

    if effect.order:
        found = strongest_orders(campaign, campaign.errors(base, to_fit=True))
        return [shaped({effect.order: float(entry)}) for entry in found] or [shaped({})]
    # In logs of a part what a whole drive alone can tell stays as it is, elsewhere what it lacks.
    declared = [entry for entry in effect.starts if all(
        not part.whole_drive if campaign.by_balance else
        part.whole_drive or part.recorded_in(campaign.signals)
        for part in map(effect.parameter, entry))]
    fitted = [] if alone is None else [base.with_effect(name, dict(alone))]
    many = len(declared) > _MANY
    near = _near(campaign, base, [shaped(entry) for entry in declared]) if many else []
    if many and not near:
        return []
    promising = partial(_promising, campaign, factors,
                        campaign.training(campaign.errors(base, to_fit=True)), name)
    if many:
        # Without a torque all are near: beside others so many simulations take too long.
        told = near if alone is None or len(near) <= _NEAR else []
        tried = [*promising([], [*told, *fitted])]
    else:
        sizes = [off + share * (values[size] - off) for share in (1.0, _LESS)]
        if campaign.starts_known and effect.slot == 'compliance':
            fitted += [shaped({size: off + share * (values[size] - off)}) for share in _SOFT]
        tried = [*promising([shaped({size: entry}) for entry in sizes], [])]
        # A size that stalls the drive in the model says nothing of a form; nor does a form that
        # takes nothing away say anything of the size.
        (_, nearer), turns = min(zip(tried, sizes), key=lambda entry: entry[0][0])
        turns = max(turns, nearer.effects[name][size], key=lambda entry: abs(entry - off))
        tried += promising([shaped({size: turns, **entry}) for entry in declared], fitted)
    kept: dict[int, tuple[float, Model]] = {}
    for promise, model in tried:
        # What is as good as one that comes before is not told from it by noise.
        kept.setdefault(round(np.log(max(promise, 1.0)) / _ALIKE), (promise, model))
    first = next(iter(kept.values()))[1]
    best = [model for _, model in sorted(kept.values(), key=lambda entry: entry[0])]
    if not effect.starts:
        return best[:1]
    # Where the error has several valleys a start does not tell how deep its own is.
    return best[:2] if first in best[:2] else [*best[:2], first]


def _promising(campaign: Campaign, factors: np.ndarray, residual: np.ndarray, name: str,
               free: Sequence[Model], fitted: Sequence[Model]) -> Iterator[tuple[float, Model]]:
    """
    Yield what squared error models may leave (linearised), and where their fits then start.

    The unit's factors are free to help, and so is the effect's size where it is not fitted yet.
    """
    size = campaign.parameter(name, effect_of(name).size.name)
    off, wide = campaign.off(name)[size.name], np.full(factors.shape[1], np.inf)

    def around(errors: np.ndarray) -> Linearised:
        return Linearised(errors, factors, np.zeros(len(wide)), len(wide))

    known = around(residual)
    for index, model in enumerate((*free, *fitted)):
        moved = campaign.training(campaign.errors(model, to_fit=True))
        far = model.effects[name][size.name] - off
        if index >= len(free) or not far:
            yield around(moved).least(), model
            continue
        low, high = sorted((end - off) / far for end in (size.low, size.high))
        both = known.beside(moved - residual)
        step = both.step(np.append(-wide, low), np.append(wide, high))
        share = np.clip(abs(step[-1]), *_SHARES) * (-1.0 if step[-1] < 0.0 > low else 1.0)
        yield both.after(step), model.with_effect(name, {
            **model.effects[name], size.name: float(off + np.clip(share, low, high) * far)})


def _near(campaign: Campaign, base: Model, models: Sequence[Model]) -> list[Model]:
    """
    Return what the torque alone, at the measured speed, makes of many starts.

    Where a drive rings, only a start within some hundredths of the truth leads there; the load by
    itself hardly rings, and asks for no simulation. A unit that was calibrated without the effect
    has strayed to make up for it: here it is that of the datasheet. The list is empty where
    the torque is nearer without any of them.
    """
    load = campaign.of_load()
    if not load.ratios(load.errors(base, to_fit=True), False):
        return list(models)

    def left(model: Model) -> float:
        return max(load.ratios(load.errors(model, to_fit=True), False).values())

    bare, without = [Model(model.effects) for model in models], left(Model(base.effects))
    off = [left(model) for model in bare]
    return [fit(load, bare[index], iterations=PATIENT).model for index in np.argsort(off)[:_NEAR]
            if off[index] < without]
