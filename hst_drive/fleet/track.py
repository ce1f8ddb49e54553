# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The size of the same effects on every date, also where nothing is named: what growth is told from.

A diagnosis names what stands out. Before that an effect has a size as well, and a standard error.
Forms stay as they were found once, so that sizes of different dates are of the same thing. The
stiffness of the oil is followed too: a machine keeps its own, its oil is changed.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Collection, Iterable, Mapping, NamedTuple, Sequence

from hst_drive.effects import catalogue, effect_of
from hst_drive.effects.leakage_temperature import OIL_LAW, POWER
from hst_drive.effects.oil import viscosity
from hst_drive.effects.slots import LEAKS
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.conditions import faults_of, reach_of
from hst_drive.identify.fit import fit
from hst_drive.identify.intervals import FORM, Spread, spread
from hst_drive.identify.model import Model
from hst_drive.identify.part import campaign_of
from hst_drive.measure.run import Run
from hst_drive.rig import Rig
from hst_drive.units import from_si
import numpy as np

OIL = 'line.bulk_modulus'
CHANGE = 'change'       # of the oil's stiffness, as a share
_OILS = 0.2             # one sigma of the logarithm: how far stiffnesses of oils lie apart
# What does to a drive what a softer oil does.
_LIKE_OIL = {'entrained_air', 'compressibility_flow', 'accumulator', 'line_inertance'}
_MOST = 3               # effects that are followed on one machine
POWERS = (0.0, POWER, 1.0)  # of the viscosity: orifices, any, laminar gaps

Sizes = dict[str, dict[str, object]]


class Tracked(NamedTuple):
    """
    Sizes by effect, each with parameter, unit, value and standard deviation.

    ``offset``: what is not known of the machine itself moves all its sizes by so much, together.
    Of a leak it is the one in the oil as it was; ``by_power``: if all leakages follow its
    viscosity by each of ``POWERS``, and ``misfits`` how ill the logs fit then, squared and in
    standard deviations. ``law`` is that power and one sigma of it, if the machine's file has it.
    Temperature (degC) and viscosity (m^2/s) of the oil are None if they are not known.
    """

    sizes: Sizes
    oil_temperature: float | None
    viscosity: float | None
    misfits: tuple[float, ...]
    law: tuple[float, float] | None


def track(rig: Rig, runs: Sequence[Run],
          effects: Mapping[str, Mapping[str, float]]) -> Tracked:
    """
    Return the sizes of effects in the logs of a campaign.

    Parameters
    ----------
    rig : Rig
        The machine; its own file, if there is one.
    runs : sequence of Run
        The logs.
    effects : mapping of str to mapping of str to float
        Effects to follow, with parameters (SI) for their form.

    """
    warm, = reach_of('oil_temperature', runs, (50.0,)) or (None,)
    thick = None if warm is None else viscosity(warm, rig.oil_grade)
    law = (rig.effects[OIL_LAW]['exponent'], rig.fingerprint.oil_law) if (
        OIL_LAW in rig.effects and rig.fingerprint and rig.fingerprint.oil_law) else None
    told_by_make = OIL_LAW in rig.effects and not law
    if thick is None or told_by_make or not any(map(leaks, effects)):
        sizes, misfits = _sizes(rig, runs, effects)[0], ()
    else:
        each, misfits = zip(*(_sizes(replace(rig, effects={**rig.effects, OIL_LAW: {
            'exponent': power}}), runs, effects) for power in POWERS))
        sizes = each[POWERS.index(POWER)]
        for name in effects:
            if name in sizes and leaks(name):
                sizes[name]['by_power'] = [other[name]['value'] for other in each]
    return Tracked(sizes, None if warm is None else float(from_si(warm, 'degC')),
                   None if thick is None else float(thick), misfits, law)


def _sizes(rig: Rig, runs: Sequence[Run],
           effects: Mapping[str, Mapping[str, float]]) -> tuple[Sizes, float]:
    campaign = campaign_of(rig, runs).of_logs(all_to_fit=True)
    campaign.signed, campaign.open_forms = True, False
    known = {name: campaign.oil.within(values) for name, values in effects.items()
             if not campaign.out_of_reach(name)}
    # Of what is adopted the form is known, and the size is fitted.
    campaign.adopted = {**campaign.adopted, **known}
    oil = _free_oil(campaign, rig, known)
    fitted = fit(campaign, Model(known), iterations=6, refresh=True)
    found = spread(campaign, fitted, between_points=0.0)
    unknowns = found.unknowns
    values, variances = found.values, np.diag(found.covariances)
    # That no machine follows a formula exactly is the same on all dates.
    form = FORM * (values - found.before)
    form[:unknowns.factors] = 0.0
    offsets = _offsets(found, rig, oil)
    sizes: Sizes = {}
    for name, value, variance, offset in zip(
            unknowns.names, values, variances - form**2 - offsets**2, offsets):
        if name[0]:
            parameter = campaign.parameter(*name)
            sizes[name[0]] = _size(parameter.name, parameter.unit, value - parameter.neutral,
                                   variance, offset)
        elif oil and name[1] == OIL:
            sizes[OIL] = _size(CHANGE, '1', np.expm1(value), variance * np.exp(2.0 * value))
    return sizes, fitted.cost


def _size(parameter: str, unit: str, value: float, variance: float,
          offset: float = 0.0) -> dict[str, object]:
    return {'parameter': parameter, 'unit': unit, 'value': float(value),
            'sigma': float(np.sqrt(max(variance, 1e-300))), 'offset': float(offset)}


def _offsets(found: Spread, rig: Rig, oil: bool) -> np.ndarray:
    """Return one standard deviation of what the machine's own numbers do to all its sizes."""
    unknowns, moved = found.unknowns, found.unit
    mixed = unknowns.mix(np.eye(len(moved)))[:unknowns.factors, :unknowns.factors]
    # What differs from day to day is in each size by itself, and so is the oil if it is free.
    share = rig.fingerprint.day_to_day if rig.fingerprint else 0.0
    daily = np.array([unknowns.tolerances[name] if oil and name == OIL
                      else share * rig.tolerances.get(name, 0.0)
                      for _, name in unknowns.names[:unknowns.factors]])
    by_day = np.linalg.solve(mixed.T, moved.T).T * daily
    offsets = np.sqrt(np.maximum((moved**2).sum(axis=1) - (by_day**2).sum(axis=1), 0.0))
    return np.where(np.arange(len(moved)) < unknowns.factors, 0.0, offsets)


def _free_oil(campaign: Campaign, rig: Rig, effects: Iterable[str]) -> bool:
    """Let the oil's stiffness be that of any oil; say whether it can be told."""
    if rig.fingerprint is None or OIL not in campaign.tolerances or _LIKE_OIL & {
            *effects, *rig.effects}:
        return False
    campaign.tolerances = {**campaign.tolerances, OIL: _OILS}
    campaign.ties = {pair: share for pair, share in campaign.ties.items()
                     if pair[0] == pair[1] or OIL not in pair}
    return True


def leaks(effect: str) -> bool:
    """Tell whether an effect is a leakage."""
    known = catalogue(everything=True)
    return effect in known and known[effect].slot in LEAKS


def one_way(effect: str) -> bool:
    """Tell whether the size of an effect is of one sign, so that it grows upwards alone."""
    known = catalogue(everything=True)
    return effect in known and known[effect].size.low >= 0.0


def to_follow(rows: Sequence[dict], rig: Rig,
              limited: Collection[str] = ()) -> dict[str, dict[str, float]]:
    """
    Return the effects that a machine is followed by, with parameters for their form.

    What the logs do not tell apart may be named one way on one date and another on the next: the
    name that fits most dates is taken, the form from where it was largest. Where one of them has
    a limit and fits half of the dates, that is the name. A name that is told beside another on no
    date is a second one for it if they were look-alikes once or act at the same place; what is
    declared as alike is so in any case. What a machine's oil does as well is followed as ``OIL``;
    ``OIL_LAW`` was learnt and is not followed. Where nothing was named, what has a limit is
    followed all the same: many dates may show together what none shows alone.

    Parameters
    ----------
    rows : sequence of dict
        Of the machine's campaigns (``task.row_of``).
    rig : Rig
        Its file; what that has adopted is followed as well.
    limited : collection of str
        Effects that the user has given a limit for.

    """
    known = catalogue(everything=True)
    # An effect of one's own may not be installed any more.
    each = [[entry for entry in (row.get('diagnosis') or {}).get('effects') or []
             if entry['id'] in known] for row in rows]
    told = [{entry['id'] for entry in entries} for entries in each]
    found = [entry for entries in each for entry in entries]
    chosen = faults_of(rig)
    most = _MOST + len(chosen)
    of_oil = {*_LIKE_OIL, OIL_LAW} - {*limited} if rig.fingerprint else set()
    # What the oil may do counts as that, but where it may as well be what has a limit.
    left = [names for entry in found if entry['id'] not in chosen and (names := [
        name for name in (entry['id'], *entry['indistinguishable_from'])
        if name in known and (name in limited if entry['id'] in of_oil else name not in of_oil)])]
    while left and len(chosen) < most:
        votes: dict[str, float] = {}
        for first, *others in left:
            # Between look-alikes the one that came first most often.
            votes[first] = votes.get(first, 0.0) + 1.01
            for other in others:
                votes[other] = votes.get(other, 0.0) + 1.0
        named = {names[0] for names in left} | {
            name for name in limited if votes.get(name, 0.0) >= 0.5 * len(left)}
        best = max(sorted(named), key=lambda name: (name in limited) * len(left) + votes[name])
        own = [_values(entry) for entry in found if entry['id'] == best] or [_typical(best)]
        chosen[best] = max(own, key=lambda values: abs(values[_first(best)]))
        alike = {entry['id'] for entry in found if best in entry['indistinguishable_from']} | {
            name for name in named if known[name].slot == known[best].slot}
        alike -= set().union(*(names for names in told if best in names))
        alike |= {name for name in named
                  if name in known[best].alike or best in known[name].alike}
        left = [names for names in left if names[0] not in alike and best not in names]
    return chosen or {name: _typical(name) for name in [
        name for name in limited if name in known][:_MOST]}


def _typical(effect: str) -> dict[str, float]:
    known = effect_of(effect)
    return {**known.neutral, _first(effect): known.size.typical}


def _values(entry: dict) -> dict[str, float]:
    return {**effect_of(entry['id']).neutral,
            **{key: float(value['value']) for key, value in entry['parameters'].items()}}


def _first(effect: str) -> str:
    return effect_of(effect).size.name
