# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How probable each explanation of the same recordings is.

Errors are means over a tenth of a second, over the floor, in pieces without a gap. Three things
make them: sensors (white), what the noise of the recorded inputs does to the replay (coloured,
with its own time), and formulas that no machine follows exactly: a smooth discrepancy whose size
is not known (M. Kennedy, A. O'Hagan, Bayesian calibration of computer models, JRSS B 63, 2001).
The discrepancy of a listed set is a share of what its effects do. Something that is not listed is
the same with a discrepancy of any size: it explains all, at the price of its freedom. The scale
of a piece is known no better than a few samples tell (a Student-t over the piece), so that single
events weigh little. Parameters are integrated out by Laplace's method (R. Kass, A. Raftery, Bayes
factors, JASA 90, 1995). The signals of a replay see the same error, so that together they count
as one, and that to a power below 1, since no noise is known as well as its formula has it
(C. Holmes, S. Walker, Assigning a value to a power likelihood, Biometrika 104, 2017).
"""
from __future__ import annotations

from functools import lru_cache
from math import log
from typing import Collection, Mapping, NamedTuple, Sequence

from hst_drive.effects.base import FORMULA_ERROR
from hst_drive.measure.run import BLOCK
import numpy as np
from scipy.linalg import cholesky, solve_triangular, toeplitz
from scipy.special import erf

BIN = 0.1           # s; errors are means over it, and a discrepancy is alike over ``BLOCK``
_TAIL = 30.0        # samples by which the scale of a piece is known
BASELINE = 0.2     # floors, by which the datasheet's curves are off between their points
# The next two were chosen by the log score of 89 simulated campaigns (bench/README.md), the third
# so that healthy drives are told with about 0.95.
_POWER = 0.25       # of the likelihood of a replay
USUAL = 3.0         # typical sizes, within which half of all effects lie
_UNLISTED = 0.08    # prior odds of something unlisted against one listed effect or none
DECIDED = 3.0       # odds below which evidence is hardly worth a mention (Kass and Raftery)
# Log odds from which on an effect is named, and a rival is told no more; and a first effect
# against a machine's own past, which is off its formulas as the new logs are (Kass and Raftery).
CREDIBLE, STRONG = log(1000.0), log(20.0)
# Sizes that a discrepancy may have, in floors.
_SIZES = np.concatenate([[0.0], np.geomspace(0.05, 60.0, 22)])
# The prior of what is not listed: each order of magnitude from what curves are off.
_ANY_SIZE = np.where(_SIZES >= BASELINE, -np.log(np.sum(_SIZES >= BASELINE)), -np.inf)
_EDGES = np.array([0.0, 0.5 * _SIZES[1], *np.sqrt(_SIZES[1:-1] * _SIZES[2:]), np.inf])


class Sensor(NamedTuple):
    """
    How errors of one signal scatter under a perfect model, over the squared floor.

    ``white`` is the variance of a mean over ``BIN`` that the sensor makes, ``coloured`` that of
    what the inputs make of the replay, alike for ``memory`` s. ``sheet`` is what a datasheet is
    declared to be off there, in floors.
    """

    white: float
    coloured: float
    memory: float
    sheet: float = 0.0


class Signal(NamedTuple):
    """
    One signal of an explanation.

    ``pieces`` are errors over the floor, means over ``BIN``, a row for each piece; those of one
    length make one array. ``moved`` is what the effects do to the signal, root mean square over
    the floor.
    """

    pieces: tuple[np.ndarray, ...]
    moved: float


class Explanation(NamedTuple):
    """
    A fitted set of effects; if not ``listed``, with something beside them that no effect lists.

    ``penalty`` is the logarithm of the priors' density at the fit times the volume of its
    posterior (``laplace``). So many of the effects are ``known``: of a machine that has a fault it
    is likelier that this grows than that any other one comes up. Machines are off their formulas
    by the ``share`` of what they do.
    """

    effects: tuple[str, ...]
    signals: Mapping[str, Signal]
    penalty: float
    listed: bool = True
    known: int = 0
    share: float = FORMULA_ERROR


class Probability(NamedTuple):
    """
    How probable explanations are, given these recordings; all add up to 1.

    ``sets`` holds the sets of listed effects, the most probable first. ``calibrated`` says whether
    such probabilities held on simulated machines (bench/README.md).
    """

    none: float
    unknown: float
    sets: tuple[tuple[tuple[str, ...], float], ...]
    calibrated: bool = False

    @property
    def effects(self) -> dict[str, float]:
        """The probability of each effect, over the sets that hold it; the highest first."""
        total: dict[str, float] = {}
        for names, share in self.sets:
            for name in names:
                total[name] = total.get(name, 0.0) + share
        return dict(sorted(total.items(), key=lambda item: -item[1]))


def weight(signals: int) -> float:
    """Return the power of each signal's likelihood in a replay of so many."""
    return _POWER / signals


def covariance(sensor: Sensor, count: int) -> np.ndarray:
    """Return the covariance of so many means over ``BIN`` in a row, under a perfect model."""
    apart = np.arange(count)
    short = BIN / sensor.memory
    # Means of an Ornstein-Uhlenbeck process: its correlation integrated over both.
    gone = -np.expm1(-short) / short
    alike = np.where(apart == 0, 2.0 * (1.0 - gone) / short,
                     gone**2 * np.exp(-short * np.maximum(apart - 1, 0)))
    return toeplitz(sensor.white * (apart == 0) + sensor.coloured * alike)


def likelihoods(pieces: Sequence[np.ndarray], sensor: Sensor,
                expected: bool = False) -> np.ndarray:
    """
    Return the log likelihood of a signal for each size that a discrepancy may have (``_SIZES``).

    A multivariate Student-t over each piece, up to a number that all explanations share; with
    ``expected`` of errors that come on top of such noise as there will be.
    """
    total = np.zeros(len(_SIZES))
    for errors in pieces:
        count, length = errors.shape
        power, whiten, volume = _modes(sensor, length)
        grown = 1.0 + _SIZES[:, None]**2 * power
        squares = ((errors @ whiten.T)**2 + expected) @ (1.0 / grown).T
        total -= 0.5 * ((_TAIL + length) * np.log1p(squares / _TAIL).sum(axis=0)
                        + count * (np.log(grown).sum(axis=1) + volume))
    return total


@lru_cache(maxsize=256)
def _modes(sensor: Sensor, count: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Return a discrepancy's power in independent modes of the noise, these, and its volume."""
    root = cholesky(covariance(sensor, count), lower=True)
    smooth = solve_triangular(root, toeplitz(np.exp(-BIN / BLOCK * np.arange(count))), lower=True)
    power, modes = np.linalg.eigh(solve_triangular(root, smooth.T, lower=True))
    whiten = solve_triangular(root, modes, lower=True, trans='T').T
    return np.maximum(power, 0.0), whiten, 2.0 * float(np.log(np.diag(root)).sum())


def range_of(size: float, both_ways: bool) -> float:
    """
    Return how wide an even prior would be that is as dense at a size as the prior of all sizes.

    That is a Cauchy's, or half of one: an effect is of a few typical sizes, and may be of many.
    Bounds of what is plausible would make one effect less probable than its look-alike.
    """
    return float(np.pi * USUAL * (1.0 + (size / USUAL)**2)) * (1.0 if both_ways else 0.5)


def laplace(information: np.ndarray, normal: np.ndarray, ranges: np.ndarray,
            mode: np.ndarray, neutral: np.ndarray | float = np.nan) -> float:
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
    neutral : ndarray, shape (n,)
        Where an unknown is as probably as anywhere in its range together: a spike beside the slab
        (T. Mitchell, J. Beauchamp, JASA 83, 1988). NaN: nowhere.

    """
    width = np.where(normal, 1.0, ranges / np.sqrt(2 * np.pi))
    # An even prior has the precision that makes a still parameter cost nothing.
    precision = np.eye(len(mode)) + width[:, None] * information * width
    root = np.linalg.slogdet(precision)[1]
    # Density of posterior over prior at the spike (J. Dickey, Annals of Mathematical Statistics
    # 42, 1971): the odds of the spike.
    variance = np.diag(np.linalg.inv(precision))
    spike = np.nan_to_num(-0.5 * np.log(variance) - 0.5 * ((neutral - mode) / width)**2 / variance,
                          nan=0.0)
    return float(-0.5 * root - 0.5 * np.sum(mode[normal]**2)
                 + np.sum(np.logaddexp(0.0, spike) - np.log(2.0)))


def probability(explanations: Sequence[Explanation], sensors: Mapping[str, Sensor],
                candidates: int) -> Probability:
    """
    Return how probable explanations are.

    Parameters
    ----------
    explanations : sequence of Explanation
        The empty set among them.
    sensors : mapping of str to Sensor
        How each signal scatters.
    candidates : int
        Effects that were searched for: each that is not known is as probable before.

    """
    listed, unlisted = np.array([evidence(entry, sensors, candidates)
                                 for entry in explanations]).T
    # Whatever listed effects stand beside it, it is one hypothesis.
    unknown = _added(unlisted) + np.log(_UNLISTED)
    shares = np.exp(np.array([*listed, unknown]) - _added([*listed, unknown]))
    found = sorted(zip((entry.effects for entry in explanations), map(float, shares)),
                   key=lambda item: -item[1])
    return Probability(
        sum(share for names, share in found if not names), float(shares[-1]),
        tuple((names, share) for names, share in found if names and share > 0.0))


def evidence(entry: Explanation, sensors: Mapping[str, Sensor],
             candidates: int) -> tuple[float, float]:
    """Return the evidence of a set alone, and with something unlisted beside it."""
    power = weight(len(entry.signals))
    # What is not listed and was fitted is one more of as many.
    count = len(entry.effects) - entry.known + (not entry.listed)
    alone = beside = entry.penalty - count * float(np.log(max(candidates, 1)))
    for name, signal in entry.signals.items():
        likely = power * likelihoods(signal.pieces, sensors[name])
        formula = likely + _as_share(signal, entry.share, sensors[name].sheet)
        alone += _added(formula)
        # Each signal shows it or does not.
        beside += _added([*formula, *(likely + _ANY_SIZE)])
    return (alone, beside) if entry.listed else (-np.inf, alone)


def expected_odds(signals: Mapping[str, Signal], sensors: Mapping[str, Sensor],
                  share: float) -> float:
    """Return the expected log odds of the truth over a model that leaves ``signals``."""
    if not signals:
        return 0.0
    total, power = 0.0, weight(len(signals))
    for name, signal in signals.items():
        sensor = sensors[name]
        own = _as_share(signal, share, sensor.sheet)
        right = sum(len(errors) * _of_truth(sensor, errors.shape[1]) for errors in signal.pieces)
        total += (_added(own + power * right)
                  - _added(own + power * likelihoods(signal.pieces, sensor, True)))
    return total


@lru_cache(maxsize=256)
def _of_truth(sensor: Sensor, count: int) -> np.ndarray:
    """Return ``likelihoods`` that are expected of the truth, for a piece of so many means."""
    return likelihoods([np.zeros((1, count))], sensor, True)


def _added(logarithms: np.ndarray | Sequence[float]) -> float:
    """Return the logarithm of a sum; SciPy's takes ten times as long for a few numbers."""
    return float(np.logaddexp.reduce(logarithms))


def _as_share(signal: Signal, share: float, sheet: float) -> np.ndarray:
    """Return the logarithm of the prior of the sizes of a discrepancy: half a normal one."""
    scale = float(np.linalg.norm([BASELINE, sheet, share * signal.moved]))
    return np.asarray(np.log(np.diff(erf(_EDGES / (np.sqrt(2.0) * scale))) + 1e-300))


def decided(found: Probability, named: Collection[tuple[str, ...]]) -> Probability:
    """
    Return probabilities that know the answer: the sets that are ``named``, or *unknown* if none.

    The likelihood does not know which rows were held out; the answer does, and is at least as
    probable as not.
    """
    said = found.none * (() in named) + sum(
        share for names, share in found.sets if names in named) if named else found.unknown
    if not 0.0 < said < 0.5:
        return found
    yes, no = 0.5 / said, 0.5 / (1.0 - said)
    sets = sorted(((names, (yes if names in named else no) * value)
                   for names, value in found.sets), key=lambda item: -item[1])
    return found._replace(none=found.none * (yes if () in named else no),
                          unknown=found.unknown * (no if named else yes), sets=tuple(sets))
