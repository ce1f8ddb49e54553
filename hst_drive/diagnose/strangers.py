# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What is not listed, tried in the place of what was found.

A listed effect may imitate one that nobody has listed nearly down to the noise: a drive that
slows down under load the oil that leaks with the command, a lag a dead time. So each effect found
is replaced by a stranger at the same place that is freer than any single effect, and fitted anew.
Whatever form the effect has on the machine, its own formula is about as good as the stranger; only
where the stranger is clearly better, by more than formulas are off machines, the name is wrong.
"""
from __future__ import annotations

import copy
from typing import Callable, Collection, NamedTuple, Sequence

from hst_drive.diagnose.campaign import Campaign, Model
from hst_drive.diagnose.fit import Fit, fit, score
from hst_drive.diagnose.judge import contribution, FORM_SHARE, PRACTICAL
from hst_drive.diagnose.part import PartCampaign
from hst_drive.diagnose.result import Unknown
from hst_drive.diagnose.search import Candidate, Search
from hst_drive.effects import catalogue
from hst_drive.effects.base import SLOTS
from hst_drive.effects.formula import FORMULAS, values
from hst_drive.measure.run import CHANNELS
import numpy as np
from scipy.optimize import minimize_scalar

# Standard errors: more than for an effect of the list, since a stranger has a freer form and is
# judged on what it was fitted to as well.
_SURE = 5.0
_DEARER = 3.0           # times what other signals lose: a stranger need not be right in all
_LONGEST = 0.4          # s, dead time
_RESOLVED = 2e-3        # s
_PATIENT = 8            # steps of the fit that gives an effect the same chance
_ROUNDS = 2             # of delay and unit in turn
_FAINT = 1e-3           # of a formula's typical size: where its fit starts
# Slot of an effect: what is tried there, its formula and terms.
_FREER = {slot: ('a leakage that goes with pressure and pump command', 'formula_pump_flow',
                 (('pressure',), ('pressure', 'pump'), ('pressure', 'pump', 'pump')))
          for slot in ('pump_flow_loss', 'pump_speed')}


# The same beside all that was found: rough rock hides what comes back with each turn.
_BESIDE = ('a load that goes with the angle of the shaft', 'formula_load',
           (('torque', 'cosine'), ('torque', 'sine')))


class Stranger(NamedTuple):
    """
    Something that is not listed, which fits better than an effect in its place.

    ``told`` says so for people; ``unknown`` is None if what is left without the effect says best
    what it is.
    """

    told: str
    unknown: Unknown | None


class Trial(NamedTuple):
    """A stranger in the place of an effect: what it is, its fit, and what it would be told as."""

    what: str
    fit: Fit
    unknown: Unknown | None


def strangers(search: Search, best: Candidate) -> dict[str, Stranger]:
    """
    Return the effects of a set in whose place something fits better that is not listed.

    Logs of a part of the drive are left out: they are judged balance by balance, each with few
    signals, where anything freer fits better.
    """
    found: dict[str, Stranger] = {}
    if isinstance(search.campaign, PartCampaign):
        return found
    for name in best.names:
        for trial in (_formula(search, best, name), _dead_time(search, best, name)):
            if trial is None or not _beaten(search, best, trial.fit):
                continue
            # The fit may have ended in another valley: the effect gets the same chance.
            beaten = _beaten(search, _again(search, best, name, trial.fit), trial.fit)
            if beaten:
                found[name] = Stranger(f'comes near, but {trial.what} in its place leaves '
                                       f'{_share(beaten)}', trial.unknown)
    return found


def _again(search: Search, best: Candidate, name: str, stranger: Fit) -> Candidate:
    """Fit a set from where the stranger ended that stood in the place of one of its effects."""
    effects = {key: stranger.model.effects.get(key, own)
               for key, own in best.fit.model.effects.items()}
    fitted = fit(search.campaign, Model(effects, stranger.model.factors), iterations=_PATIENT)
    again = Candidate(best.names, fitted, score(search.campaign, fitted))
    return min(best, again, key=lambda item: item.score)


def beside(search: Search, best: Candidate) -> str:
    """
    Say what fits better beside a set, though nothing seems to be left; empty if nothing does.

    A rough load scatters so much that its noise ratio hides what a formula shows clearly.
    """
    # The unit's own Jacobian will do: a load moves the unit's factors little, and this is asked
    # in every diagnosis.
    trial = None if isinstance(search.campaign, PartCampaign) else _fitted(
        search.campaign, best.fit.model, *_BESIDE, known=search.factors)
    beaten = _beaten(search, best, trial.fit) if trial else None
    return f'{trial.what} leaves {_share(beaten)}' if beaten else ''


def _share(beaten: tuple[str, float]) -> str:
    signal, share = beaten
    return f'{100 * share:.0f} % less squared error of {CHANNELS[signal].title}'


def without(search: Search, best: Candidate, out: Collection[str]) -> Candidate:
    """Return the fit without some of the effects of a set."""
    kept = tuple(name for name in best.names if name not in out)
    if not kept or not out:
        return best if kept else search.baseline
    start = Model({name: best.fit.model.effects[name] for name in kept}, best.fit.model.factors)
    return search.refine(search.try_all([(kept, start)], 'taking effects out')[0])


def _beaten(search: Search, best: Candidate, fitted: Fit) -> tuple[str, float] | None:
    """Return the signal in which a stranger is clearly better, and by what share of its square."""
    trial = Candidate((), fitted, score(search.campaign, fitted))
    if trial.score >= best.score:
        return None
    shares: dict[str, float] = {}
    for held_out in (False, True):
        found = search.gain(best, trial, held_out)
        done = contribution(search.campaign, search.base, best.fit, held_out)
        lost = -sum(min(amount, 0.0) for amount in found.amount.values())
        for name, share in found.share.items():
            if share >= PRACTICAL and found.sigma[name] >= _SURE and found.amount[name] >= max(
                    (FORM_SHARE * done[name])**2, _DEARER * lost):
                shares[name] = max(share, shares.get(name, 0.0))
    return max(shares.items(), key=lambda item: item[1], default=None)


def _formula(search: Search, best: Candidate, name: str) -> Trial | None:
    """Fit a formula in the place of an effect; None if there is none for its place."""
    freer = _FREER.get(catalogue()[name].slot)
    return _fitted(search.campaign, best.fit.model.without(name), *freer) if freer else None


def _fitted(campaign: Campaign, model: Model, what: str, formula: str,
            terms: Sequence[Sequence[str]], known: np.ndarray | None = None) -> Trial | None:
    if formula in campaign.rig.effects:
        return None
    faint = _FAINT * FORMULAS[formula].parameters[0].typical
    start = model.with_effect(formula, values(formula, [(faint, term) for term in terms]))
    return Trial(what, fit(campaign, start, known=known), None)


def _dead_time(search: Search, best: Candidate, name: str) -> Trial | None:
    """Fit a pure delay of the pump command in the place of an effect of the pump's actuator."""
    campaign = search.campaign
    if SLOTS[catalogue()[name].slot].enters != 'pump actuator':
        return None
    fitted, delay = best.fit._replace(model=best.fit.model.without(name)), 0.0
    for _ in range(_ROUNDS):
        delay = minimize_scalar(_cost_of_delay(campaign, fitted.model), bounds=(0.0, _LONGEST),
                                method='bounded', options={'xatol': _RESOLVED}).x
        fitted = fit(_later(campaign, delay), fitted.model, known=search.factors)
    return Trial(f'a dead time of {1e3 * delay:.0f} ms', fitted, Unknown(
        'pump_actuator', campaign.signals[0], ('pump_command',),
        f'the pump follows its command {delay:.3f} s later, by a dead time', (), 0.0))


def _cost_of_delay(campaign: Campaign, model: Model) -> Callable[[float], float]:
    def cost(delay: float) -> float:
        later = _later(campaign, delay)
        return float(np.sum(later.training(later.errors(model, to_fit=True))**2))

    return cost


def _later(campaign: Campaign, delay: float) -> Campaign:
    """Return the campaign with a pump that follows each command after a dead time (s)."""
    changed = copy.copy(campaign)
    changed.replays = [copy.copy(replay) for replay in campaign.replays]
    for replay in changed.replays:
        time, command = replay.run.time, replay.inputs['pump_command']
        replay.inputs = {**replay.inputs, 'pump_command': np.interp(time - delay, time, command)}
    return changed
