# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
When no listed effect explains the data: where the error enters, on what it depends, a formula.

The location and the size over time come from ``isolate``, the dependence and the terms from
``dependence``. Terms of what the drive knows at every instant are then put into the model as an
effect and fitted anew: what that gains on held-out data is what the formula is worth.
"""
from __future__ import annotations

from typing import Sequence

from hst_drive.diagnose.dependence import (
    depends_on, expression, regress, samples, STATIC)
from hst_drive.diagnose.isolate import locate, only_read, sizes
from hst_drive.diagnose.result import Formula, Unknown, Value
from hst_drive.effects.formula import FORMULAS, values
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit, fit, score
from hst_drive.identify.intervals import intervals
from hst_drive.identify.judge import over_own_floors, PRACTICAL
from hst_drive.identify.phases import once_a_turn
import numpy as np

_READING = 'formula_pressure_reading'


def describe(campaign: Campaign, model: Fit) -> Unknown | None:
    """
    Say where the remaining error enters and on what it depends; None if no place stands out.

    ``model`` is the best that listed effects can do, which leaves something.
    """
    campaign, model = over_own_floors(campaign, model)
    location = locate(campaign, model)
    if location is None:
        return None
    found, used = sizes(campaign, model, location)
    campaign = once_a_turn(campaign, model, found)
    data = samples(campaign, model, location, found, used)
    if data.held_out.all() or not data.held_out.any():
        # Too few to tell on what it hangs.
        return Unknown(location.enters, location.signal, (), '')
    depends = depends_on(data)
    terms, explained = regress(data, lambda name: True)
    static = terms
    if any(name not in STATIC for term in terms for name in term['variables']):
        static = regress(data, STATIC.__contains__)[0]
    name = location.formula
    carried = _carry(campaign, model, name, static) if name else None
    if carried and name == 'formula_torque' and not campaign.by_balance and only_read(
            campaign, model, location.moves):
        per_torque = location.moves[location.signal]
        reading = _carry(campaign, model, _READING, _scaled(static, per_torque))
        if reading and score(campaign, reading) < score(campaign, carried):
            # The same error with the leakage unmoved: the reading is off, not the torque.
            name, carried, terms = _READING, reading, _scaled(terms, per_torque)
            location = location._replace(name='pressure reading', enters='sensor', unit='Pa')
    enters = location.enters
    if location.formula == 'formula_pump_flow' and _by_command(depends, terms):
        enters = 'pump_actuator'
    return Unknown(enters, location.signal, depends, expression(location, terms), tuple(terms),
                   explained, worth(campaign, model, name, carried) if carried else None)


def _by_command(depends: Sequence[str], terms: Sequence[dict]) -> bool:
    """Say whether the command's motion, or the command alone, tells the missing oil."""
    moving = any(name.startswith('pump_command_') for term in terms[:1]
                 for name in term['variables'])
    return moving or tuple(depends) == ('pump_command',)


def _scaled(terms: Sequence[dict], factor: float) -> list[dict]:
    """Return terms times a factor below 0."""
    return [{**term, 'coefficient': factor * term['coefficient'], 'low': factor * term['high'],
             'high': factor * term['low']} for term in terms]


def _carry(campaign: Campaign, model: Fit, name: str, terms: Sequence[dict]) -> Fit | None:
    """Fit the model with a formula as an effect; None if there is nothing to carry."""
    if not terms or name in campaign.rig.effects:
        return None
    try:
        start = values(name, [(term['coefficient'], [STATIC[key] for key in term['variables']])
                              for term in terms])
    except KeyError:
        # A variable that is not known where the formula enters.
        return None
    return fit(campaign, model.model.with_effect(name, start), iterations=4, refresh=True)


def worth(campaign: Campaign, model: Fit, name: str, carried: Fit) -> Formula | None:
    """Return the formula to adopt; None if it does not lower the held-out error enough."""
    before, after = (sum(float(np.nanmean(squares))
                         for squares in campaign.blocks(entry.errors).values()
                         if np.isfinite(squares).any()) for entry in (model, carried))
    if after > (1.0 - PRACTICAL) * before:
        return None
    limits = intervals(campaign, carried)
    units = {entry.name: entry.unit for entry in FORMULAS[name].parameters}
    return Formula(
        name, {key: Value(value, *limits.get((name, key), (value, value)), units[key])
               for key, value in carried.model.effects[name].items()},
        campaign.ratios(model.errors, True), campaign.ratios(carried.errors, True),
        carried.model.scales, {other: dict(parameters) for other, parameters
                               in carried.model.without(name).effects.items()})
