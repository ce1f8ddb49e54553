# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How probable each explanation of the same recordings is.

Squared errors over their floors are weighed block by block with as many independent samples as
their own correlation time leaves. The scale of each block is known no better than a few samples
tell (a Student-t over the block): single events and ringing weigh little. What an effect does is
off its formula by a share that is integrated out (M. Kennedy, A. O'Hagan, JRSS B 63, 2001), the
parameters by Laplace's method (R. Kass, A. Raftery, JASA 90, 1995). 'Unknown' is a smooth function
of one variable that takes away what is left, at the price of its freedom.
"""
from __future__ import annotations

from typing import Collection, Mapping, NamedTuple, Sequence

import numpy as np
from scipy.special import logsumexp

_TAIL = 5.0         # independent samples by which the scale of one block is known
_SHARES = (0.0, 0.03, 0.1, 0.2)     # of what effects do, by which a formula may be off
_FORM = 4           # numbers that another formula of an effect differs by
_FREEDOM = 12       # bins over which a smooth unknown is free, as those that describe it
_EVENTS = 0.07      # share of the blocks that single events may spoil (``campaign``)
_UNLISTED = 0.1     # prior odds of something unlisted against one listed effect or none
_CORRELATED = 0.05  # an autocorrelation below this is noise of its estimate
# Power of the evidence: blocks are alike from one to the next (correlation 0.4 to 0.8) and signals
# see the same error. Chosen on four frozen campaigns; not calibrated (bench/README.md).
_SHARPNESS = 0.1
# Odds that the tests over held-out blocks are right: of seven frozen campaigns six were
# (bench/README.md), rounded down.
_DECIDED = 5.0


class Signal(NamedTuple):
    """
    One signal of an explanation, block by block of all logs.

    ``squares`` are mean squared errors and ``moved`` mean squares of what the effects do, over the
    squared floor; ``clean`` is the square up to which nothing is left to explain.
    """

    squares: np.ndarray
    moved: np.ndarray
    clean: float


class Explanation(NamedTuple):
    """
    A fitted set of effects.

    ``penalty`` is the logarithm of the priors' density at the fit times the volume of its
    posterior (``laplace``).
    """

    effects: tuple[str, ...]
    signals: Mapping[str, Signal]
    penalty: float


class Probability(NamedTuple):
    """
    How probable explanations are, given these recordings; all add up to 1.

    ``sets`` holds the sets of listed effects, the most probable first.
    """

    none: float
    unknown: float
    sets: tuple[tuple[tuple[str, ...], float], ...]

    @property
    def effects(self) -> dict[str, float]:
        """The probability of each effect, over the sets that hold it; the highest first."""
        total: dict[str, float] = {}
        for names, share in self.sets:
            for name in names:
                total[name] = total.get(name, 0.0) + share
        return dict(sorted(total.items(), key=lambda item: -item[1]))


def independent(errors: np.ndarray, most: float) -> float:
    """
    Return how many independent samples errors of one signal are worth.

    Parameters
    ----------
    errors : ndarray, shape (n,)
        Evenly sampled.
    most : float
        Not more than these.

    """
    count = len(errors)
    if count < 3 or not np.ptp(errors):
        return min(float(count), most)
    # A single peak would hide how the rest goes on.
    clipped = np.clip(errors, *np.percentile(errors, (0.5, 99.5)))
    spectrum = np.fft.rfft(clipped - clipped.mean(), 2 * count)
    lagged = np.fft.irfft(np.abs(spectrum)**2)[:count // 2]
    if lagged[0] <= 0.0:
        return min(float(count), most)
    lagged /= lagged[0]
    below = np.flatnonzero(lagged < _CORRELATED)
    memory = 1.0 + 2.0 * float(lagged[1:below[0] if len(below) else len(lagged)].sum())
    return min(count / memory, most)


def likelihood(signal: Signal, samples: float, share: float = 0.0) -> float:
    """
    Return the log likelihood of a signal, up to a number that all explanations share.

    ``samples`` are the independent ones of a block, ``share`` is that of what the effects do by
    which their formulas may be off: so much error is taken as theirs, as far as something is left
    beyond the floor.
    """
    left = np.maximum(signal.squares - share**2 * signal.moved, np.minimum(signal.squares, 1.0))
    return -0.5 * (samples + _TAIL) * float(np.log1p(samples * left / _TAIL).sum())


def laplace(information: np.ndarray, normal: np.ndarray, ranges: np.ndarray,
            mode: np.ndarray) -> float:
    """
    Return the logarithm of prior density times posterior volume at a fit.

    Parameters
    ----------
    information : ndarray, shape (n, n)
        Jacobian squared, of errors over their floors.
    normal : ndarray of bool, shape (n,)
        Which unknowns have a standard normal prior; the others an even one over ``ranges``.
    ranges : ndarray, shape (n,)
        Widths of the even priors.
    mode : ndarray, shape (n,)
        The fit.

    """
    if not len(mode):
        return 0.0
    width = np.where(normal, 1.0, ranges / np.sqrt(2 * np.pi))
    # An even prior has the precision that makes a still parameter cost nothing.
    root = np.linalg.slogdet(np.eye(len(mode)) + width[:, None] * information * width)[1]
    return float(-0.5 * root - 0.5 * np.sum(mode[normal]**2))


def probability(explanations: Sequence[Explanation], samples: Mapping[str, float],
                candidates: int, sharpness: float = _SHARPNESS) -> Probability:
    """
    Return how probable explanations are.

    Parameters
    ----------
    explanations : sequence of Explanation
        The empty set among them.
    samples : mapping of str to float
        Independent samples of a block, by signal.
    candidates : int
        Effects that were searched for: each is as probable before.
    sharpness : float
        Power of the evidence.

    """
    before = np.array([-len(entry.effects) * np.log(max(candidates, 1)) for entry in explanations])
    own = before + sharpness * np.array([_evidence(entry, samples) for entry in explanations])
    smooth = before + sharpness * np.array([_smoothed(entry, samples) for entry in explanations])
    # Whatever listed effects stand beside it, it is one hypothesis.
    unknown = float(smooth.max()) + np.log(_UNLISTED)
    shares = np.exp(np.array([*own, unknown]) - logsumexp([*own, unknown]))
    found = sorted(zip((entry.effects for entry in explanations), map(float, shares)),
                   key=lambda item: -item[1])
    return Probability(sum(share for names, share in found if not names), float(shares[-1]),
                       tuple(entry for entry in found if entry[0]))


def decided(found: Probability, verdict: str,
            named: Collection[tuple[str, ...]]) -> Probability:
    """
    Return probabilities that know what the tests over held-out blocks decided.

    The likelihood does not know which logs judged; ``verdict`` and the sets that are ``named`` do.
    They multiply the odds of what they say, and make it at least as probable as not.
    """
    unknown = verdict == 'unknown'
    held = [not unknown and names in named for names, _ in found.sets]
    none = not unknown and () in named
    said = found.unknown * unknown + found.none * none + sum(
        share for (_, share), own in zip(found.sets, held) if own)
    if not 0.0 < said < 1.0:
        return found
    share = max(_DECIDED * said / (_DECIDED * said + 1.0 - said), 0.5)
    yes, no = share / said, (1.0 - share) / (1.0 - said)
    sets = sorted(((names, (yes if own else no) * value)
                   for (names, value), own in zip(found.sets, held)), key=lambda item: -item[1])
    return Probability(found.none * (yes if none else no),
                       found.unknown * (yes if unknown else no), tuple(sets))


def _evidence(entry: Explanation, samples: Mapping[str, float]) -> float:
    return float(logsumexp([
        sum(likelihood(signal, samples[name], share) for name, signal in entry.signals.items())
        - price(_FORM, share**2 * sum(samples[name] * signal.moved.sum()
                                      for name, signal in entry.signals.items()))
        for share in _SHARES]) - np.log(len(_SHARES))) + entry.penalty


def _smoothed(entry: Explanation, samples: Mapping[str, float]) -> float:
    """Return the evidence with something smooth and unlisted that takes away what is left."""
    quiet = {}
    # It moves a floor at least: what does nothing is no explanation.
    power = sum(samples[name] * len(signal.squares) for name, signal in entry.signals.items())
    for name, signal in entry.signals.items():
        # Of all blocks but the worst: single events are no smooth function.
        square = float(np.sort(signal.squares)[:max(round((1 - _EVENTS) * len(signal.squares)),
                                                    1)].mean())
        rest = signal.clean / max(square, signal.clean)
        quiet[name] = signal._replace(squares=rest * signal.squares)
        power += samples[name] * float((signal.squares - quiet[name].squares).sum())
    return _evidence(entry._replace(signals=quiet), samples) - price(_FREEDOM, power)


def price(freedom: int, power: float) -> float:
    """
    Return what a smooth function costs that is free in so many bins.

    ``power`` is the squared size that it may have, over that of the noise; all bins alike.
    """
    return 0.5 * freedom * float(np.log1p(power / freedom))
