# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
One cause that is not listed, in the place of all that was found.

Two or three effects together imitate much: the wrong zero of a torque sensor looks like another
zero of the pressure sensor and a gear that takes its share. So where several effects were needed,
or they do not explain all, causes with one number or two are tried alone: a reading that is wrong
in zero and span, and a number of the datasheet that is off by more than its tolerance. Of what
explains the recordings as well the simpler is the better answer (H. Jeffreys, Theory of
Probability, Oxford 1939).
"""
from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
import copy
import os
from typing import Container

from hst_drive.diagnose.fit import Fit, fit, score
from hst_drive.diagnose.nameless import fitted_freer, Freer, much_left, sure, told_as, Trial
from hst_drive.diagnose.part import PartCampaign
from hst_drive.diagnose.result import Unknown
from hst_drive.diagnose.search import Candidate, Search
from hst_drive.diagnose.strangers import Stranger
from hst_drive.measure.run import CHANNELS
import numpy as np

_WIDER = 12.0       # times the tolerance that a wrong number of the datasheet may have
# Signal: its formula, the variable of that, and the unit.
_READINGS = {
    'load_torque': ('formula_torque_reading', 'torque', 'N.m'),
    'motor_speed': ('formula_speed_reading', 'speed', 'rad/s'),
    'pump_outlet_pressure': ('formula_pressure_reading', 'pressure', 'Pa'),
    'motor_inlet_flow': ('formula_flow_reading', 'flow', 'm^3/s'),
}
# Section of the rig, and the quantities of it that enter elsewhere.
_ENTERS = {'pump': 'pump_actuator', 'motor': 'torque', 'line': 'flow', 'loading': 'load',
           'pump.leakage': 'flow', 'motor.leakage': 'flow', 'motor.displacement': 'flow'}


def one_cause(search: Search, best: Candidate, left: Container[str]) -> Stranger | None:
    """
    Return the cause that explains alone what a set does, or more; None if there is none.

    Parameters
    ----------
    search : Search
        What was tried.
    best : Candidate
        The set that was found.
    left : collection of str
        Signals that it leaves unexplained.

    """
    if isinstance(search.campaign, PartCampaign) or not (left or len(best.names) > 1):
        return None
    with ThreadPoolExecutor(max(os.cpu_count() or 1, 1)) as pool:
        trials = [*pool.map(lambda name: _misread(search, name),
                            [name for name in _READINGS if name in search.campaign.signals]),
                  *pool.map(lambda key: _mistaken(search, key), search.campaign.tolerances)]
    found = [trial for trial in trials if trial and _explains(search, best, trial.fit, left)]
    if not found:
        return None
    trial = min(found, key=lambda trial: score(search.campaign, trial.fit))
    others = ' and '.join(best.names)
    return Stranger(f'{trial.what} alone explains more' if left else
                    f'{trial.what} alone explains as much as {others} do together',
                    told_as(search.campaign, search.base, trial))


def _explains(search: Search, best: Candidate, alone: Fit, left: Container[str]) -> bool:
    """Say whether a cause alone is the better answer."""
    if left:
        return sure(search, best, alone) is not None and not much_left(search, best, alone)
    cause = Candidate((), alone, score(search.campaign, alone))
    return not search.unexplained(cause) and not search.worthwhile(
        cause, best) and not search.agreed(cause, best)


def _misread(search: Search, signal: str) -> Trial | None:
    """Fit a reading that is wrong in zero and span."""
    formula, variable, unit = _READINGS[signal]
    title = CHANNELS[signal].title
    return fitted_freer(search.campaign, search.base.model, Freer(
        f'a wrong zero or span in the reading of {title}', formula, ((), (variable,)),
        Unknown('sensor', signal, (signal,), f'reading of {title} [{unit}]', (), 0.0)),
        known=search.factors)


def _mistaken(search: Search, key: str) -> Trial:
    """Fit the unit with a number of the datasheet that may be off beyond its tolerance."""
    campaign = copy.copy(search.campaign)
    campaign.tolerances = {**campaign.tolerances, key: _WIDER * campaign.tolerances[key]}
    known = search.factors.copy()
    known[:, list(campaign.tolerances).index(key)] *= _WIDER
    fitted = fit(campaign, search.base.model, iterations=8, known=known)
    value = fitted.model.factors[key]
    many = abs(value) / search.campaign.tolerances[key]
    enters = _ENTERS.get(key, _ENTERS[key.split('.')[0]])
    what = (f"a {key} {100 * abs(np.expm1(value)):.1f} % {'above' if value > 0 else 'below'} the "
            f"datasheet's ({many:.0f} times its tolerance)")
    return Trial(what, fitted, Unknown(enters, search.campaign.signals[0], (), what, (), 0.0))
