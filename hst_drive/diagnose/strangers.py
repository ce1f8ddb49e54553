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

from typing import Callable, Collection, Container, Iterator, NamedTuple

from hst_drive.diagnose.answers import (
    Answer, answering, DEAD_TIME, LATE_READINGS, ONE_WAY_SLOWER, reads_late)
from hst_drive.diagnose.campaign import Campaign, Model
from hst_drive.diagnose.fit import Fit, fit, score
from hst_drive.diagnose.judge import (
    contribution, excess, FORM_SHARE, IN_EVENTS, PRACTICAL, SIGNIFICANT)
from hst_drive.diagnose.part import PartCampaign
from hst_drive.diagnose.phases import once_a_turn
from hst_drive.diagnose.result import Unknown
from hst_drive.diagnose.search import Candidate, Search
from hst_drive.diagnose.unknown import Carried, worth
from hst_drive.effects import catalogue
from hst_drive.effects.base import SLOTS
from hst_drive.effects.formula import FORMULAS, TEXTS, values
from hst_drive.measure.run import CHANNELS
import numpy as np
from scipy.optimize import minimize_scalar

# Standard errors: more than for an effect of the list, since a stranger has a freer form and is
# judged on what it was fitted to as well.
_SURE = 5.0
_DEARER = 3.0           # times what other signals lose: a stranger need not be right in all
_PATIENT = 8            # steps of the fit that gives an effect the same chance
_ROUNDS = 2             # of the answer and the unit in turn
_WARMED_UP = 3.0        # K, by which the oil must warm to explain anything
_FAINT = 1e-3           # of a formula's typical size: where its fit starts


class Freer(NamedTuple):
    """
    A formula that is tried: what it is, its effect, terms, and what it would be told as.

    ``unknown`` is None if what is left without the effect says best what it is.
    """

    what: str
    formula: str
    terms: tuple[tuple[str, ...], ...]
    unknown: Unknown | None = None


# Slot of an effect: what is tried in its place.
_FREER = {
    **dict.fromkeys(('pump_flow_loss', 'pump_speed'), Freer(
        'a leakage that goes with pressure and pump command', 'formula_pump_flow',
        (('pressure',), ('pressure', 'pump'), ('pressure', 'pump', 'pump')))),
    'pump_command': Freer(
        'a bent curve of the flow meter', 'formula_flow_reading', (('flow',), ('flow', 'flow')),
        Unknown('sensor', 'motor_inlet_flow', ('motor_inlet_flow',),
                'flow reading [m^3/s]', (), 0.0)),
}
# In the place of several effects that pressure shows: together they imitate much.
_SHOWN_BY_PRESSURE = ('motor_torque_loss', 'back_pressure', 'line_drop', 'pressure_reading')
_OF_WARMTH = Freer('a torque that goes with the oil temperature alone', 'formula_torque',
                   ((), ('warmth',), ('warmth', 'warmth')),
                   Unknown('torque', 'pump_outlet_pressure', ('oil_temperature',),
                           'torque of the hydromotor [N.m]', (), 0.0))
# The same beside all that was found: rough rock hides what comes back with each turn.
_BESIDE = Freer('a load that goes with the angle of the shaft', 'formula_load',
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
    """
    A stranger in the place of an effect: what it is, its fit, and what it would be told as.

    ``formula`` is the effect that carries it, if one does.
    """

    what: str
    fit: Fit
    unknown: Unknown | None
    formula: str = ''


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
        trials = [trial for trial in (*_formula(search, best, name),
                                      *_actuator(search, best, name))
                  if _beaten(search, best, trial.fit)]
        if not trials:
            continue
        trial = min(trials, key=lambda item: score(search.campaign, item.fit))
        if beaten := _sure(search, best, trial.fit):
            found[name] = Stranger(
                f'comes near, but {trial.what} in its place leaves {_share(beaten)}',
                _told_as(search, best, [name], trial, _FREER.get(catalogue()[name].slot)))
    return found or _of_warmth(search, best)


def _of_warmth(search: Search, best: Candidate) -> dict[str, Stranger]:
    """Return the effects in whose common place a torque of the oil's temperature fits better."""
    names = [name for name in best.names if catalogue()[name].slot in _SHOWN_BY_PRESSURE]
    if len(names) < 2 or not _WARMED_UP <= np.ptp(np.concatenate(
            [replay.inputs['oil_temperature'] for replay in search.campaign.replays])):
        return {}
    model = best.fit.model
    for name in names:
        model = model.without(name)
    trial = _fitted(search.campaign, model, _OF_WARMTH)
    beaten = trial and _sure(search, best, trial.fit)
    if not beaten:
        return {}
    unknown = _told_as(search, best, names, trial, _OF_WARMTH)
    return dict.fromkeys(names, Stranger(
        f'together come near, but {trial.what} in their place leaves {_share(beaten)}', unknown))


def _told_as(search: Search, best: Candidate, names: Collection[str], trial: Trial,
             freer: Freer | None) -> Unknown | None:
    """Return what a trial would be told as, with the formula to adopt."""
    if trial.unknown is None or not trial.formula or not freer:
        return trial.unknown
    bare = without(search, best, names).fit
    own = trial.fit.model.effects[trial.formula]
    summed = ' + '.join(' * '.join([f"{own[f'coefficient_{place}']:.3g}",
                                    *(TEXTS[variable] for variable in term)])
                        for place, term in enumerate(freer.terms, 1))
    return trial.unknown._replace(
        expression=f'{trial.unknown.expression} += {summed}',
        formula=worth(search.campaign, bare, Carried(trial.formula, trial.fit)))


def _sure(search: Search, best: Candidate, stranger: Fit) -> tuple[str, float] | None:
    """Ask ``_beaten`` once the set has had the same chance: fitted from where that ended."""
    if not _beaten(search, best, stranger):
        return None
    effects = {key: stranger.model.effects.get(key, own)
               for key, own in best.fit.model.effects.items()}
    fitted = fit(search.campaign, Model(effects, stranger.model.factors), iterations=_PATIENT)
    again = Candidate(best.names, fitted, score(search.campaign, fitted))
    return _beaten(search, min(best, again, key=lambda item: item.score), stranger)


def beside(search: Search, best: Candidate, left: Container[str]) -> Stranger | None:
    """
    Return what fits better beside a set and is not listed; None if nothing does.

    ``left`` are the signals that the set leaves unexplained. Where nothing seems to be left, a
    rough load, or the unit's own lag, may still hide it from the noise ratio.
    """
    if isinstance(search.campaign, PartCampaign):
        return None
    for trial in _beside(search, best, left):
        beaten = _beaten(search, best, trial.fit)
        # Who says better what is left than its place and a formula do explains it.
        if beaten and not (trial.unknown and left and _much_left(search, best, trial.fit)):
            return Stranger(f'{trial.what} leaves {_share(beaten)}', trial.unknown)
    return None


def _beside(search: Search, best: Candidate, left: Container[str]) -> Iterator[Trial]:
    late = [reads_late(name) for name in LATE_READINGS if name in left]
    # A dead time of a few milliseconds may be the logger's.
    for answer in (ONE_WAY_SLOWER, *([DEAD_TIME, *late] if left else [])):
        yield _answered(search, best.fit, answer)
    turned = once_a_turn(search.campaign, best.fit, _of_the_load(search.campaign, best.fit))
    # The unit's own Jacobian will do: a load moves the unit's factors little, and this is asked
    # in every diagnosis.
    trial = _fitted(turned, best.fit.model, _BESIDE, known=search.factors)
    if trial:
        yield trial


def _of_the_load(campaign: Campaign, fitted: Fit) -> list[np.ndarray]:
    """Return how far the load torque is off, log by log, over its floor."""
    found = [np.zeros(len(replay.run)) for replay in campaign.replays]
    for error, column in zip(fitted.errors, campaign.columns):
        if column.signal == campaign.replays[column.log].torque:
            read = np.concatenate([column.fit, column.judge])
            found[column.log][read] = -(error * column.trust)[read]
    return found


def _much_left(search: Search, best: Candidate, fitted: Fit) -> bool:
    if not search.unexplained(best._replace(fit=fitted)):
        return False
    before, after = (excess(search.campaign.ratios(entry.errors, True))
                     for entry in (best.fit, fitted))
    return after > FORM_SHARE * before


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
            # A few quick steps may be all that shows how a pump answers: then blocks count.
            sure = found.sigma[name] >= _SURE or (
                share >= IN_EVENTS and found.votes[name] >= SIGNIFICANT)
            if share >= PRACTICAL and sure and found.amount[name] >= max(
                    (FORM_SHARE * done[name])**2, _DEARER * lost):
                shares[name] = max(share, shares.get(name, 0.0))
    return max(shares.items(), key=lambda item: item[1], default=None)


def _formula(search: Search, best: Candidate, name: str) -> list[Trial]:
    """Fit a formula in the place of an effect, if there is one for its place."""
    freer = _FREER.get(catalogue()[name].slot)
    if freer is None or (freer.unknown and freer.unknown.signal not in search.campaign.signals):
        return []
    trial = _fitted(search.campaign, best.fit.model.without(name), freer)
    return [trial] if trial else []


def _fitted(campaign: Campaign, model: Model, freer: Freer, known: np.ndarray | None = None
            ) -> Trial | None:
    formula = freer.formula
    if formula in campaign.rig.effects:
        return None
    faint = _FAINT * FORMULAS[formula].parameters[0].typical
    start = model.with_effect(formula, values(formula, [(faint, term) for term in freer.terms]))
    return Trial(freer.what, fit(campaign, start, known=known), freer.unknown, formula)


def _actuator(search: Search, best: Candidate, name: str) -> list[Trial]:
    """Fit what a pump may do with its command in the place of an effect of its actuator."""
    if SLOTS[catalogue()[name].slot].enters != 'pump actuator':
        return []
    model = best.fit.model.without(name)
    return [_answered(search, best.fit._replace(model=model), answer)
            for answer in (DEAD_TIME, ONE_WAY_SLOWER)]


def _answered(search: Search, fitted: Fit, answer: Answer) -> Trial:
    """Fit a way to answer, and the unit, in turn."""
    campaign, number = search.campaign, 0.0
    for _ in range(_ROUNDS):
        number = minimize_scalar(_cost_of(campaign, fitted.model, answer), bounds=answer.bounds,
                                 method='bounded', options={'xatol': answer.resolved}).x
        fitted = fit(answering(campaign, answer, number), fitted.model, known=search.factors)
    what = answer.told(number)
    return Trial(what, fitted, Unknown(answer.enters, answer.signal or campaign.signals[0],
                                       (answer.depends_on,), answer.where + what, (), 0.0))


def _cost_of(campaign: Campaign, model: Model, answer: Answer) -> Callable[[float], float]:
    def cost(number: float) -> float:
        changed = answering(campaign, answer, number)
        return float(np.sum(changed.training(changed.errors(model, to_fit=True))**2))

    return cost
