# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
One cause that is not listed, in the place of all that was found.

Two or three effects together imitate much: the wrong zero of a torque sensor looks like another
zero of the pressure sensor and a gear that takes its share. So does one with a unit that is as far
off as its tolerances let it. So where several effects were needed, or such a unit, or they do not
explain all, causes with one number or two are tried alone: a reading that is wrong in zero and
span, and a number of the datasheet that is off by more than its tolerance. Of what explains the
recordings as well the simpler is the better answer (H. Jeffreys, Theory of Probability, Oxford
1939). A listed effect of the same sensor alone stays: the cause is only another formula of it.

So is what makes recordings unlike each other: one that is odd, or several drives.
"""
from __future__ import annotations

import copy
from typing import Callable, Container, Iterator, Mapping, NamedTuple

from hst_drive.channels import CHANNELS
from hst_drive.diagnose.dependence import STATIC
from hst_drive.diagnose.free_forms import (
    as_unknown, better, beyond_noise, FreeForm, Trial, with_start)
from hst_drive.diagnose.result import Unknown
from hst_drive.diagnose.unlisted import Unlisted
from hst_drive.effects import catalogue
from hst_drive.effects.formula import FORMULAS
from hst_drive.identify.calibrate import calibrated
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import at_limit, each, Fit, fit, limited, PATIENT
from hst_drive.identify.judge import parts, unexplained
from hst_drive.identify.model import Model
from hst_drive.identify.search import BEAM, Candidate, Search
import numpy as np

_WIDER = 12.0       # times the tolerance that a wrong number of the datasheet may have
_READINGS = ('load_torque', 'motor_speed', 'pump_outlet_pressure', 'motor_inlet_flow')
# Number of the datasheet, and where it enters. Leakage, lag and efficiency have effects of theirs.
_NUMBERS = {'motor.displacement': 'flow', 'motor.inertia': 'torque', 'line.bulk_modulus': 'flow',
            'pump.displacement_vs_command': 'pump_actuator', 'loading.pprv_pressure': 'load',
            'loading.pprv_lag': 'load', 'loading.pprv_override': 'load'}
# Numbers that act as their ratio: what is below for one may be above for the other.
_OR_ELSE = {'line.bulk_modulus': 'line.volume'}


class _Cause(NamedTuple):
    """
    Where the fit of a cause starts, in which campaign, and the unit's Jacobian if it holds.

    ``frees`` is the number of the datasheet that may be off by more than its tolerance.
    """

    campaign: Campaign
    start: Model
    known: Mapping[tuple[str, str], np.ndarray]
    told: Callable[[Fit], Trial]
    frees: str = ''


def one_cause(search: Search, best: Candidate, left: Container[str]) -> Unlisted | None:
    """
    Return the cause that explains alone what a set does, or more; None if there is none.

    ``left`` are the signals that the set leaves unexplained.
    """
    strained = limited(search.campaign, best.fit)
    if not left and len(best.names) < 2 and not strained:
        return None
    # Beside a unit at its limits that explains all, only what would take it off one.
    causes = [*_misread(search, best), *_mistaken(search)] if best.names or left else [
        cause for cause in _mistaken(search) if cause.frees in strained]
    fits = each(lambda cause: fit(cause.campaign, cause.start, known=cause.known,
                                  iterations=PATIENT), causes)
    near = sorted(zip(causes, fits), key=lambda pair: search.score(pair[1]))
    for cause, found in near[:BEAM]:
        found = fit(cause.campaign, found.model, iterations=PATIENT, refresh=True)
        search.unlisted.append((cause.campaign, found.light()))
        if _explains(search, best, found, left, cause.campaign):
            trial = cause.told(found)
            said = 'more' if left or not best.names else (
                f"as much as {' and '.join(best.names)} together" if len(best.names) > 1 else
                f'more than {best.names[0]}')
            return Unlisted(f'{trial.what} alone explains {said}',
                            as_unknown(search.campaign, lambda: search.base, trial))
    return None


def _explains(search: Search, best: Candidate, alone: Fit, left: Container[str],
              freed: Campaign) -> bool:
    """Say whether a cause alone is the better answer; ``freed`` has the tolerances beside it."""
    if left or len(best.names) > 1:
        return better(search, best, alone, freed, left, simpler=True)
    # Below the floor nothing is left that a number could be the cause of.
    return {*limited(freed, alone)} < {*limited(search.campaign, best.fit)} and beyond_noise(
        freed, alone) < beyond_noise(search.campaign, best.fit) and better(
        search, best, alone, freed, left)


def misreadings(campaign: Campaign) -> Iterator[FreeForm]:
    """Yield what the readings of a campaign may be off by: a zero and a span."""
    for signal in _READINGS:
        variable, title = STATIC[signal], CHANNELS[signal].title
        formula = f'formula_{variable}_reading'
        if signal in campaign.signals and formula not in campaign.rig.effects:
            yield FreeForm(
                f'a wrong zero or span in the reading of {title}', formula, ((), (variable,)),
                Unknown('sensor', signal, (signal,),
                        f'reading of {title} [{CHANNELS[signal].unit}]'))


def _misread(search: Search, best: Candidate) -> Iterator[_Cause]:
    """Yield readings that are wrong in zero and span, but for that of which an effect says so."""
    said = {catalogue()[name].slot for name in best.names} if len(best.names) == 1 else {}
    for form in misreadings(search.campaign):
        if FORMULAS[form.formula].slot in said:
            continue
        # From the datasheet: a unit calibrated without the cause has strayed to make up for it.
        yield _Cause(search.campaign, with_start(Model(), form), search.base.columns,
                     lambda found, form=form: Trial(form.what, found, form.unknown, form))


def _mistaken(search: Search) -> Iterator[_Cause]:
    """Yield numbers of the datasheet that may be off beyond their tolerances."""
    for key, tolerance in search.campaign.tolerances.items():
        if key not in _NUMBERS:
            continue
        campaign = copy.copy(search.campaign)
        campaign.tolerances = {**campaign.tolerances, key: _WIDER * tolerance}
        known, start = search.base.columns, Model()
        known['', key] = _WIDER * known['', key]
        if campaign.ties:
            known = {}      # what is tied to it changes, too
        if at_limit(search.campaign, key, search.base.model.factors[key]):
            # It wants to go on from there, and what it does changes on the way.
            known, start = {}, search.base.model
        yield _Cause(campaign, start, known,
                     lambda found, key=key, tolerance=tolerance: _off(
                         search, key, found, abs(found.model.factors[key]) / tolerance),
                     key)


def _off(search: Search, key: str, found: Fit, many: float) -> Trial:
    """Return what a wrong number of the datasheet would be told as."""
    against = 'what it was when commissioned' if search.campaign.commissioned_unit else \
        "the datasheet's"

    def said(name: str, change: float) -> str:
        share = np.expm1(change)
        side = 'above' if share > 0 else 'below'
        return f'a {name} {100 * abs(share):.1f} % {side} {against}'

    change = found.model.factors[key]
    what = f'{said(key, change)} ({many:.0f} times its tolerance)'
    if key in _OR_ELSE:
        what += f', or {said(_OR_ELSE[key], -change)},'
    return Trial(what, found, Unknown(
        _NUMBERS[key], search.campaign.signals[0], (), what))


def outlier_record(campaign: Campaign) -> tuple[int, str] | None:
    """
    Return the number of the odd recording and what is different there, if one is.

    Physics that a model lacks is there in all recordings that visit where it shows. Where all but
    one are explained, and that one is once a sensor's zero and span are set right, something was
    different there: the unit in a column's heading, a sensor that was changed, another machine.
    """
    if len(campaign.replays) < 3:   # of two nobody could tell which is odd
        return None
    for log in range(len(campaign.replays)):
        others = campaign.of_logs(lambda index: index != log)
        if not any(len(column.fit) for column in others.columns):
            continue
        unit = calibrated(others)
        if _left(others, unit):
            continue
        alone = campaign.of_logs(lambda index: index == log, all_to_fit=True)
        for form in misreadings(campaign):
            start = with_start(unit.model, form)
            if not _left(alone, fit(alone, start, iterations=PATIENT)):
                return log, form.what
    return None


def several_drives(campaign: Campaign) -> bool:
    """Say whether each recording alone is explained, though not all are by one unit."""
    alone = (campaign.of_logs(lambda index, log=log: index == log, all_to_fit=True)
             for log in range(len(campaign.replays)))
    return len(campaign.replays) > 1 and not any(_left(one, calibrated(one)) for one in alone)


def _left(campaign: Campaign, fitted: Fit) -> bool:
    return any(unexplained(campaign, fitted, {}, part) for part in parts(campaign))
