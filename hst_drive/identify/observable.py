# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What these logs can show at all.

An effect that the channels cannot show, or that the log never exercised, is 'not observable
here', not absent; and where nothing is found, the smallest size that would have been found
says what 'none' is worth.
"""
from __future__ import annotations

from math import log
from typing import Callable, NamedTuple, Sequence

from hst_drive.effects import catalogue
from hst_drive.effects.base import arguments
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.evidence import (
    DECIDED, expected_odds, laplace, range_of, Signal, weight)
from hst_drive.identify.fit import Fit
from hst_drive.identify.judge import PRACTICAL
from hst_drive.identify.linearised import Linearised
from hst_drive.identify.unknowns import SIGMAS, Unknowns
from hst_drive.identify.weigh import Means
from hst_drive.rig.rig import OPEN
import numpy as np
from scipy.optimize import brentq

# What an effect may read that a replay takes from a recording: the channel that it comes from.
_FROM = {'oil_temperature': 'oil_temperature', 'viscosity_ratio': 'oil_temperature',
         'motor_angle': 'motor_speed'}


class Visibility(NamedTuple):
    """
    How well an effect shows in a campaign.

    Attributes
    ----------
    id : str
        The effect.
    smallest : float
        Size (first parameter, SI) from which on their evidence is expected to decide for it;
        inf if none. What an effect does is taken to go with its size.
    reason : str
        Why it cannot be seen; empty if it can.
    tried : bool
        Whether it is worth a search: beside others, or in events, less may do for a name.

    """

    id: str
    smallest: float
    reason: str
    tried: bool


def visibility(campaign: Campaign, base: Fit, names: Sequence[str]) -> list[Visibility]:
    """
    Judge how large each effect would have to be to be found.

    ``base`` is the calibrated model with its Jacobian: an effect that the unit's tolerances can
    imitate does not show.
    """
    start, shows = campaign.training(base.errors), _Shows(campaign, base)
    found = []
    for name in names:
        effect = catalogue()[name]
        unseen = campaign.out_of_reach(name)
        if unseen:
            found.append(Visibility(name, np.inf, unseen, False))
            continue
        size = campaign.parameter(name, effect.size.name)
        model = base.model.with_effect(name, campaign.typical(name))
        move = campaign.training(campaign.errors(model, to_fit=True)) - start
        odds = shows.odds(move, campaign.either_way(name))
        asked = campaign.odds_asked + (0.0 if name in campaign.faults else log(len(names)))
        largest = max(abs(size.low), abs(size.high))
        smallest = abs(size.typical) * _crossing(lambda log_share: _named(
            *odds(log_share), asked, campaign.commissioned_unit))
        reason = '' if smallest <= largest else unread(campaign, name) or (
            'in these logs even the largest one would hardly show')
        found.append(Visibility(name, smallest, reason, not reason or odds(
            log(largest / abs(size.typical)))[0] > log(DECIDED)))
    return found


def unread(campaign: Campaign, name: str) -> str:
    """Say what an effect follows that no log has, or the rig file; empty if there is none."""
    effect = catalogue()[name]
    rig = campaign.rig
    if 'rated_pressure' in arguments(effect.function) and rig.circuit == OPEN and (
            not rig.relief_valve):
        return "needs the rig file's relief_valve"
    missing = sorted({_FROM[entry] for _, function in effect.terms
                      for entry in arguments(function) if entry in _FROM
                      and effect.own == effect.parameters
                      and not any(_FROM[entry] in replay.run for replay in campaign.replays)})
    return f'needs the channel {" and ".join(missing)}' if missing else ''


class _Shows:
    """From which size on logs are expected to tell an effect, beside a unit that takes it up."""

    def __init__(self, campaign: Campaign, base: Fit):
        self._means = Means(campaign)
        # Logs to judge on tell as much as those that are fitted.
        self._more = sum(len(column.rows(None)) for column in campaign.columns) / max(
            sum(len(column.fit) for column in campaign.columns), 1)
        self._weight = self._more * weight(len(campaign.signals))
        unknowns = Unknowns(campaign, base.model)
        self._factors = base.jacobian[:, :unknowns.factors]
        self._moved = [self._signals(column) for column in self._factors.T]
        self._held = unknowns.pack(base.model)[:unknowns.factors]
        self._room = -SIGMAS - self._held - 1e-6, SIGMAS - self._held + 1e-6

    def _signals(self, vector: np.ndarray) -> dict[str, Signal]:
        means = self._means.of_training(vector)
        return self._means.signals(means, means)

    def odds(self, move: np.ndarray,
             both_ways: bool) -> Callable[[float], tuple[float, float, float]]:
        """
        Return a function of the logarithm of an effect's size over the typical one.

        It gives the expected log odds, what the size costs of them, and the greatest share of a
        signal's squared error that the effect takes. The typical size moves errors by ``move``.
        """
        still = np.zeros(len(self._held))
        quadratic = Linearised(move, self._factors, still, len(still))
        # By signal the pieces that the effect moves, each with those that the unit does.
        moved = {name: [(own, np.array(unit).reshape(-1, *own.shape)) for own, *unit in zip(
                     signal.pieces, *(entry[name].pieces for entry in self._moved))]
                 for name, signal in self._signals(move).items()}

        def odds(log_share: float) -> tuple[float, float, float]:
            share = np.exp(log_share)
            # Of what the typical size moves the unit takes up so much.
            off = quadratic.step(*(limit / share for limit in self._room)) if (
                len(still)) else still
            taken = share * off
            left = {name: Signal(tuple(share * own + np.tensordot(taken, known, 1)
                                       for own, known in pieces), 0.0)
                    for name, pieces in moved.items()}
            strained = (self._held + taken) @ (self._held + taken) - self._held @ self._held
            rest = quadratic.after(off) - off @ off
            # What is judged on counts as 0 there.
            power = self._more * max((float(np.mean(np.concatenate(
                [*map(np.ravel, entry.pieces)])**2)) for entry in left.values()), default=0.0)
            return 0.5 * float(strained) + self._more * expected_odds(
                left, self._means.sensors, 0.0), -laplace(
                    self._weight * np.array([[rest]]), np.array([False]),
                    np.array([range_of(share, both_ways)]), np.array([share])), (
                        power / (1.0 + power))

        return odds


def _named(expected: float, price: float, share: float, asked: float, own: bool) -> float:
    """Return how far an effect is beyond what ``Search.asked`` asks; ``own``: of a file."""
    beyond = expected - price - asked
    return beyond if own else min(beyond, float(np.log(max(share, 1e-30) / PRACTICAL)))


def _crossing(odds: Callable[[float], float]) -> float:
    """Return the share of a typical size from which on odds are above 0; inf if they never are."""
    low, high = np.log(1e-4), np.log(1e3)
    if odds(high) <= 0.0:
        return np.inf
    return float(np.exp(low if odds(low) >= 0.0 else brentq(odds, low, high, xtol=0.02)))
