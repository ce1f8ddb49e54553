# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What is not listed, tried in the place of what was found.

A listed effect may imitate one that nobody has listed nearly down to the noise: a drive that
slows down under load the oil that leaks with the command, a lag a dead time. So each effect found
is replaced by a form at the same place that is freer than any single effect, and fitted anew.
Whatever form the effect has on the machine, its own formula is about as good as the free one; only
where the evidence is for the free one the name is wrong (``better``).
"""
from __future__ import annotations

from dataclasses import replace
from typing import Collection, Container, Iterator, NamedTuple, Sequence

from hst_drive.diagnose.free_forms import (
    as_unknown, better, fitted_forms, FreeForm, how_much_better, Trial)
from hst_drive.diagnose.result import Unknown
from hst_drive.effects import catalogue
from hst_drive.effects.slots import SLOTS
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit, fit
from hst_drive.identify.model import Model
from hst_drive.identify.phases import once_a_turn
from hst_drive.identify.search import Candidate, Search
from hst_drive.identify.standing import without
from hst_drive.identify.timing import (
    DEAD_TIME, LATE_READINGS, ONE_MORE_LAG, ONE_WAY_SLOWER, reads_late, Timing, with_timing)
from hst_drive.measure.readings import best_delay, LONGEST_DELAY
from hst_drive.measure.where import WARMS
from hst_drive.rig.schema import ONE_SIDED
import numpy as np
from scipy.optimize import minimize_scalar

_ROUNDS = 2             # of the timing and the unit in turn
_RESOLVED = 2.5e-3      # of the span of a timing's number
# Slot of an effect: what is tried in its place.
_FREE_FORMS = {
    **dict.fromkeys(('pump_flow_loss', 'pump_speed'), (FreeForm(
        'a leakage that goes with pressure and pump command', 'formula_pump_flow',
        (('pressure',), ('pressure', 'pump'), ('pressure', 'pump', 'pump'))),)),
    'pump_command': (FreeForm(
        'a bent curve of the flow meter', 'formula_flow_reading', (('flow',), ('flow', 'flow')),
        Unknown('sensor', 'motor_inlet_flow', ('motor_inlet_flow',),
                'flow reading [m^3/s]')),),
}
_OF_WARMTH = (
    FreeForm('a torque that goes with the oil temperature alone', 'formula_torque',
             ((), ('warmth',), ('warmth', 'warmth')),
             Unknown('torque', 'pump_outlet_pressure', ('oil_temperature',),
                     'torque of the hydromotor [N.m]')),
    FreeForm('a reading of load torque that goes with the oil temperature',
             'formula_torque_reading', ((), ('warmth',), ('torque', 'warmth')),
             Unknown('sensor', 'load_torque', ('oil_temperature',), 'torque reading [N.m]')))
# What goes with a loss alike both ways, beside one that turns its sign, is lost one way only.
_FROM_ONE_LINE = tuple(
    FreeForm(f'oil that line {line.upper()} alone loses', formula,
             ((f'line_{line}',), ('pressure', f'line_{line}')),
             Unknown('flow', 'motor_speed', (f'line_{line}_pressure',), 'oil [m^3/s]'))
    for line in 'ab' for formula in ('formula_pump_flow', 'formula_motor_flow'))
_ONE_WAY = tuple(
    FreeForm(f'a torque that acts only when the hydromotor turns {way}', 'formula_torque',
             ((way,), ('speed', way)),
             Unknown('torque', 'motor_torque', ('motor_speed',), 'torque of the hydromotor [N.m]'))
    for way in ('forwards', 'backwards'))
# The same beside all that was found: rough rock hides what comes back with each turn.
_LOAD_BY_ANGLE = FreeForm('a load that goes with the angle of the shaft', 'formula_load',
                          (('torque', 'cosine'), ('torque', 'sine')))


class Unlisted(NamedTuple):
    """
    Something that is not listed, which fits better than an effect in its place.

    ``told`` says so for people; ``unknown`` is None if what is left without the effect says best
    what it is.
    """

    told: str
    unknown: Unknown | None


def unlisted_replacement(search: Search, best: Candidate,
                         left: Container[str]) -> dict[str, Unlisted]:
    """
    Return the effects of a set in whose place something fits better that is not listed.

    ``left`` are the signals that the set leaves unexplained.
    """
    found: dict[str, Unlisted] = {}
    for name in best.names:
        # Balance by balance there are few signals, which anything freer fits better.
        forms = () if search.campaign.by_balance else _FREE_FORMS.get(catalogue()[name].slot, ())
        trial = _best(search, best, [
            *fitted_forms(search.campaign, best.fit.model.without(name), forms),
            *_actuator(search, best, name)], left)
        found |= _withdrawn(search, best, [name], trial)
    return found or _together(search, best, left)


def _withdrawn(search: Search, best: Candidate, names: Sequence[str],
               trial: Trial | None) -> dict[str, Unlisted]:
    """Return effects of a set with what fits better in their place, if anything does."""
    if trial is None:
        return {}
    together, whose = ('together ', 'their') if len(names) > 1 else ('', 'its')
    come = 'come' if together else 'comes'
    return dict.fromkeys(names, Unlisted(
        f'{together}{come} near, but {trial.what} in {whose} place '
        f'{how_much_better(search, best, trial.fit)}',
        as_unknown(search.campaign, lambda: without(search, best, names).fit, trial)))


def _warms(campaign: Campaign) -> bool:
    """Say whether logs of a whole drive show what goes with the oil temperature."""
    return not campaign.by_balance and bool(WARMS <= np.ptp(np.concatenate(
        [replay.inputs['oil_temperature'] for replay in campaign.replays])))


def _reverses(campaign: Campaign) -> bool:
    """Say whether a log turns both ways."""
    return campaign.by_balance and any(replay.reverses for replay in campaign.replays)


# In the place of several effects, which together imitate much: slots that must be among theirs,
# others, what the logs must show, and what is tried.
_SEVERAL = (
    (set(), {'motor_torque_loss', 'back_pressure', 'line_drop', 'pressure_reading'}, _warms,
     _OF_WARMTH),
    ({'pump_command'}, {'pump_flow_loss', 'motor_flow_loss', 'cross_port_flow', 'pump_yield'},
     _reverses, _FROM_ONE_LINE),
    ({'motor_torque'}, {'motor_torque_loss'}, _reverses, _ONE_WAY))


def _together(search: Search, best: Candidate, left: Container[str]) -> dict[str, Unlisted]:
    """Return the effects in whose common place one thing that is not listed fits better."""
    slots = {name: catalogue()[name].slot for name in best.names}
    for needed, others, shown, tried in _SEVERAL:
        names = [name for name, slot in slots.items() if slot in needed | others]
        if len(names) > 1 and needed <= {*slots.values()} and shown(search.campaign):
            model = best.fit.model.without(*names)
            # Of what explains as much one cause is a better answer than several.
            trial = _best(search, best, fitted_forms(search.campaign, model, tried), left,
                          simpler=True)
            if trial:
                return _withdrawn(search, best, names, trial)
    return {}


def unlisted_addition(search: Search, best: Candidate,
                      left: Collection[str]) -> tuple[Candidate, Unlisted | None]:
    """
    Return a set, and what fits better beside it and is not listed; None if nothing does.

    ``left`` are the signals that the set leaves unexplained. Where nothing seems to be left, a
    rough load, or the unit's own lag, may still hide it from the noise ratio. A set whose fit had
    stopped in a bend of its valley comes back as good as the trials have shown that it can be.
    """
    trial = _best(search, best, [*_additions(search, best, left)], left)
    if trial is None:
        return best, None
    again = search.restarted(best, trial.fit)
    if again is not best and not better(
            search, again, trial.fit, search.campaign, search.unexplained(again)):
        return again, None
    return again, Unlisted(
        f'{trial.what} {how_much_better(search, again, trial.fit)}', trial.unknown)


def _best(search: Search, best: Candidate, trials: Sequence[Trial], left: Container[str],
          simpler: bool = False) -> Trial | None:
    """Return the best of trials that are better answers than a set; all are remembered."""
    search.unlisted += [(search.campaign, trial.fit.light()) for trial in trials]
    return next((trial for trial in sorted(trials, key=lambda item: search.score(item.fit))
                 if better(search, best, trial.fit, search.campaign, left, simpler)), None)


def _additions(search: Search, best: Candidate, left: Collection[str]) -> Iterator[Trial]:
    yield _timed(search, best.fit, ONE_WAY_SLOWER)
    if left:
        # A dead time of a few milliseconds may be the logger's.
        yield _timed(search, best.fit, DEAD_TIME)
        fitted = {column.signal for column in search.campaign.columns if len(column.fit)}
        # The torque's reading goes into the replay: late, it spoils the other signals.
        for name in LATE_READINGS:
            if name in fitted & {*left, *_torques(search.campaign)}:
                yield from (_timed(search, best.fit, timing) for timing in reads_late(name))
    turned = once_a_turn(search.campaign, best.fit, _of_the_load(search.campaign, best.fit))
    # The unit's own Jacobian will do: a load moves the unit's factors little, and this is asked
    # in every diagnosis.
    for trial in fitted_forms(turned, best.fit.model, [_LOAD_BY_ANGLE], search.base.columns):
        if not _torques(turned):
            # Where no load is recorded what is left cannot say that it is one.
            seen = trial._replace(unknown=Unknown(
                'load', turned.signals[0], ('motor_angle',), 'load torque [N.m]'))
            trial = trial._replace(unknown=as_unknown(turned, lambda: best.fit, seen))
        yield trial


def _torques(campaign: Campaign) -> set[str]:
    """Return the signals of the load's torque that these logs have."""
    return {replay.torque for replay in campaign.replays} & {*campaign.signals}


def _of_the_load(campaign: Campaign, fitted: Fit) -> list[np.ndarray]:
    """Return how far the load torque is off, log by log, over its floor."""
    found = [np.zeros(len(replay.run)) for replay in campaign.replays]
    for error, column in zip(fitted.errors, campaign.columns):
        if column.signal == campaign.replays[column.log].torque:
            found[column.log] = -column.weighed(error)
    return found


def _actuator(search: Search, best: Candidate, name: str) -> list[Trial]:
    """Fit what a pump may do with its command in the place of an effect of its actuator."""
    if SLOTS[catalogue()[name].slot].enters != 'pump actuator' or any(
            replay.static or 'pump_command' not in replay.inputs
            for replay in search.campaign.replays):
        return []
    bare = best.fit._replace(model=best.fit.model.without(name))
    late, slower = (_timed(search, bare, timing) for timing in (DEAD_TIME, ONE_WAY_SLOWER))
    score = search.score(late.fit)
    # A row of lags is nearly a dead time, and still the effect.
    if score < best.score and search.score(
            _timed(search, best.fit, ONE_MORE_LAG).fit) < score:
        return [slower]
    return [late, slower]


def _timed(search: Search, fitted: Fit, timing: Timing) -> Trial:
    """Fit a timing, and the unit, in turn."""
    campaign, number, kept = search.campaign, 0.0, set()
    if not timing.signal:
        # What is tried says all of what stands before the plate.
        kept = {('', key) for key in ONE_SIDED}
        fitted = fitted._replace(model=replace(fitted.model, factors={
            key: value for key, value in fitted.model.factors.items() if key not in ONE_SIDED}))
    for _ in range(_ROUNDS):
        number = (_best_number if timing.bounds else _late)(campaign, timing, number, fitted.model)
        fitted = fit(with_timing(campaign, timing, number), fitted.model,
                     known=search.base.columns, kept=kept)
    what = timing.told(number)
    return Trial(what, fitted, Unknown('sensor', timing.signal, (timing.signal,), what)
                 if timing.signal else Unknown(
                     'pump_actuator', campaign.signals[0], ('pump_command',),
                     f'the pump follows its command with {what}'))


def _best_number(campaign: Campaign, timing: Timing, _: float, model: Model) -> float:
    """Return the number of a timing with which the rows that are fitted fit best."""
    def cost(number: float) -> float:
        changed = with_timing(campaign, timing, number)
        return float(np.sum(changed.training(changed.errors(model, to_fit=True))**2))

    return float(minimize_scalar(cost, bounds=timing.bounds, method='bounded',
                                 options={'xatol': _RESOLVED * np.ptp(timing.bounds)}).x)


def _late(campaign: Campaign, timing: Timing, number: float, model: Model) -> float:
    """Return how late (s) a signal is read, as most logs have it in the rows that are fitted."""
    changed, found = with_timing(campaign, timing, number), []
    drive = changed.driver(model)
    for column in changed.columns:
        if column.signal == timing.signal and len(column.fit):
            replay, read = changed.replays[column.log], np.full(len(column.weight), np.nan)
            read[column.fit] = replay.run[timing.signal][column.fit]
            found.append(best_delay(
                replay.run.time, replay.predict(drive)[timing.signal], read))
    return float(np.clip(number + np.median(found), -LONGEST_DELAY, LONGEST_DELAY))
