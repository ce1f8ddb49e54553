# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The explanations that a test has to tell apart."""
from __future__ import annotations

from typing import Iterable, NamedTuple, Sequence

from hst_drive.design.rehearse import rehearse
from hst_drive.design.separation import (
    CLEAR, driver, recorded, Rehearsal, within_limits)
from hst_drive.design.trials import plain_drilling, scenario
from hst_drive.effects import catalogue, unknown_effect
from hst_drive.errors import InputError
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import fit
from hst_drive.identify.model import Model
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.load.scenario import parse_scenario, Scenario
from hst_drive.rig import Rig

_TWINS = 2
_WIDEST = 8     # explanations, with their twins
_STANDS_IN = 0.5          # of what the lead explains: less is no explanation of the same logs


class Rivals(NamedTuple):
    """
    Explanations of the same logs.

    ``models`` holds the sizes where they are known; ``channels`` the recorded signals; ``asked``
    whether the user named them.
    """

    names: tuple[tuple[str, ...], ...]
    models: tuple[Model | None, ...]
    channels: tuple[str, ...]
    asked: bool = False


def by_name(names: Sequence[str], channels: Iterable[str] = (),
            beside: Model | None = None) -> Rivals:
    """
    Return single effects as rivals.

    Parameters
    ----------
    names : sequence of str
        At least two effects.
    channels : sequence of str
        Recorded signals.
    beside : Model, optional
        What else the drive has; its sizes are kept.

    Raises
    ------
    InputError
        If an effect is not known, or there are fewer than two.

    """
    for name in names:
        if name not in catalogue():
            raise InputError(f'effects: {unknown_effect(name)}')
    names = tuple(dict.fromkeys(names))
    if len(names) < 2:
        raise InputError('effects: expected at least two effects to tell apart, with commas '
                         'between them')
    beside = beside or Model()
    others = tuple(name for name in beside.effects if name not in names)
    models = [beside if name in beside.effects else None for name in names]
    return Rivals(tuple((*others, name) for name in names), tuple(models), tuple(channels), True)


def told_apart(models: Sequence[Model]) -> tuple[str, ...]:
    """Return the effects that not all explanations share."""
    shared = set.intersection(*(set(model.effects) for model in models))
    return tuple(dict.fromkeys(name for model in models for name in model.effects
                               if name not in shared))


def matched(rig: Rig, rivals: Rivals) -> list[Model]:
    """
    Return the rivals with sizes that look alike on a plain drilling log.

    The first whose sizes are known, else the first at its typical size, makes the log that the
    others are fitted to.
    """
    lead = next((model for model in rivals.models if model is not None), None) or Model(
        {name: catalogue()[name].sized(*rig.sizes).typical for name in rivals.names[0]})
    lead = Model(lead.effects, within_limits(lead.factors, rig.scatter))
    place, models = None, []
    for names, model in zip(rivals.names, rivals.models):
        if model is None and tuple(names) == tuple(lead.effects):
            model = lead
        if model is None:
            place = place or _Place(rig, lead, rivals.channels)
            # One that could not take the other's place at all keeps its typical size.
            model = place.taken(names) or Model(place.start(names).effects)
        models.append(Model(model.effects, lead.factors))
    return models


class _Place:
    """What an explanation does on a plain drilling log, for others to take its place there."""

    def __init__(self, rig: Rig, lead: Model, channels: Iterable[str]):
        played = rehearse(driver(rig, lead), _plain_drilling(rig), 0)
        self.lead, self.campaign = lead, Campaign(rig, [recorded(played, channels)])
        self.explained = self._cost(lead)

    def start(self, names: Sequence[str]) -> Model:
        """Return a model with these effects, those of the lead with its sizes."""
        sizes = self.campaign.sizes
        return Model({name: self.lead.effects.get(name, catalogue()[name].sized(*sizes).typical)
                      for name in names}, self.lead.factors)

    def taken(self, names: Sequence[str]) -> Model | None:
        """Return the sizes at which effects do the same, None if they cannot."""
        shared = {name: values for name, values in self.lead.effects.items() if name in names}
        bare = self._cost(Model(shared, self.lead.factors))
        found = fit(self.campaign, self.start(names), iterations=3)
        enough = bare - found.cost >= _STANDS_IN * (bare - self.explained) > 0
        return found.model if enough else None

    def _cost(self, model: Model) -> float:
        return fit(self.campaign, model, iterations=3, kept=_sizes(model)).cost


def widened(rig: Rig, models: Sequence[Model], channels: Iterable[str]) -> list[Model]:
    """
    Return the rivals and the effects nearest to the first on a plain drilling log.

    No machine follows one formula exactly, so that what beat a near twin of the effect found by
    a hair may be its form. A test should separate the twin as well.
    """
    models = list(models)
    shared = set.intersection(*(set(model.effects) for model in models))
    tried = {*rig.effects, *(name for model in models for name in model.effects)}
    room = min(_WIDEST - len(models), _TWINS)
    if room <= 0 or len(models[0].effects) != len(shared) + 1:
        return models
    kept = {name: models[0].effects[name] for name in models[0].effects if name in shared}
    others = [Model({**kept, name: effect.sized(*rig.sizes).typical}, models[0].factors)
              for name, effect in catalogue().items()
              if name not in tried and effect.searched == 'always']
    rehearsal = Rehearsal(rig, _plain_drilling(rig), [models[0], *others], 0)
    found = sorted((rehearsal.pair(0, place, channels).significance, place)
                   for place in range(1, len(others) + 1))
    near = [tuple(others[place - 1].effects) for sigma, place in found[:2 * _TWINS]
            if sigma < CLEAR]
    place = _Place(rig, models[0], channels)
    # What fits as well without being there is no twin: no test could tell it from nothing.
    twins = [Model(taken.effects, models[0].factors)
             for taken in map(place.taken, near) if taken]
    return models + twins[:room]


def _plain_drilling(rig: Rig) -> Scenario:
    return parse_scenario(scenario(plain_drilling(60.0), rig, False), LoadingUnit.of(rig.loading))


def _sizes(model: Model) -> list[tuple[str, str]]:
    return [(name, key) for name, values in model.effects.items() for key in values]
