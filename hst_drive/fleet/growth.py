# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How a size grows over a machine's life, and until when it stays below a limit.

A life is cut into stretches by repairs and replaced parts. In each the size follows one law:
steady, linear, linear from some day on, or accelerating (exponential). All cuts, laws and amounts
of scatter are weighed by their evidence; sums over all cuts are exact (P. Fearnhead, Exact and
efficient Bayesian inference for multiple changepoint problems, Statistics and Computing 16, 2006).
What comes is told from draws of all of them, and not from the best alone.
"""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.fleet.jumps import History, jumps
from hst_drive.fleet.laws import ACCELERATING, at, inverse, Law, laws, ONSET, Stretch
import numpy as np
from scipy.special import softmax

FEWEST = 3              # dates from which something is told of growth
_CUT = 0.04             # chance of a cut between two dates
_SEASON = 0.15          # chance that a size goes with the oil's temperature
_WARMER = 3.0           # K that may change a size by half its scale; fewer by as much less
# Scatter from day to day beyond the sizes' own standard errors, in these: little is usual.
_SCATTER = np.array([0.0, 0.5, 1.0, 2.0, 4.0, 8.0])
_USUAL = np.array([0.3, 0.25, 0.2, 0.15, 0.07, 0.03])
_DRAWS = 4000
_SURE = 0.9             # chance from which growth is told as such


class Remaining(NamedTuple):
    """
    Days (as those of the history) on which a limit is reached: 95 % interval and the middle.

    Infinite: not at all as it goes now. ``reached``: chance that it is reached already.
    """

    low: float
    middle: float
    high: float
    reached: float


class Growth:
    """
    What a history tells.

    Parameters
    ----------
    history : History
        The sizes.
    form : float
        Relative standard deviation by which all of them may be off together: the formula's. As
        the history's ``offset`` it makes no trend, but who gives a limit means the true size.
    one_way : bool
        Whether the size grows upwards alone, also where it is less than none.

    Attributes
    ----------
    kind : str
        'grows', 'accelerates', 'falls', 'steady', 'not clear' or 'too few dates'.
    level : tuple of float
        Size on the last day: low, middle and high of a 95 % interval.
    rate : tuple of float
        Its growth a day then, likewise.
    since : float or None
        Day from which it grows or falls.
    jumps : tuple of Jump
        Sudden changes.
    season : float
        Chance that the size goes with the oil's temperature.
    usual : History
        The sizes without what they are off together, as far as that was found.

    """

    def __init__(self, history: History, form: float = 0.0, one_way: bool = False):
        self.history = history
        self.now = float(history.days[-1])
        evidence = _Evidence(history)
        self.season = evidence.season
        random = np.random.default_rng(0)
        self._draws = evidence.draws(random)
        off = self._draws.together
        self.usual = history._replace(
            values=history.values - off.mean() * history.together,
            sigmas=np.hypot(history.sigmas, off.std() * history.together))
        self.jumps = jumps(self.usual, evidence.cuts)
        self._true = np.exp(form * random.standard_normal(len(self._draws.kinds)))
        self._off = history.offset * random.standard_normal(len(self._draws.kinds))
        self.level = _quantiles(self._true * (self._draws.at(self.now) - self._off))
        rates = self._draws.rate(self.now)
        self.rate = _quantiles(rates)
        self.kind, self.since = self._kind(rates, one_way)

    def _kind(self, rates: np.ndarray, one_way: bool) -> tuple[str, float | None]:
        if len(self.history.days) < FEWEST:
            return 'too few dates', None
        # A size of no sign of its own, near zero, grows whichever way it goes.
        outward = 1.0 if one_way else np.sign(self.level[1]) or np.sign(
            np.median(rates[rates != 0.0]))
        away, back = (np.mean(rates * side > 0.0) for side in (outward, -outward))
        if max(away, back) < _SURE:
            return ('steady' if np.mean(rates == 0.0) > 0.5 else 'not clear'), None
        moving = rates * (outward if away > back else -outward) > 0.0
        since = float(np.median(self._draws.since()[moving]))
        if away < back:
            return 'falls', since
        faster = np.mean(self._draws.kinds[moving] == ACCELERATING) > 0.5
        return 'accelerates' if faster else 'grows', since

    def band(self, day: float) -> tuple[float, float, float]:
        """Return low, middle and high of a 95 % interval on a day."""
        return _quantiles(self._draws.at(day))

    def remaining(self, limit: float) -> Remaining | None:
        """Return when a limit is reached; None with too few dates."""
        if self.kind == 'too few dates':
            return None
        days = self._draws.reaches(limit / self._true + self._off, self.now)
        low, middle, high = np.quantile(days, (0.025, 0.5, 0.975), method='inverted_cdf')
        return Remaining(float(low), float(middle), float(high), float(np.mean(days <= self.now)))


def _quantiles(values: np.ndarray) -> tuple[float, float, float]:
    low, middle, high = np.quantile(values, (0.025, 0.5, 0.975))
    return float(low), float(middle), float(high)


class _Draws(NamedTuple):
    """Laws with their numbers, drawn by chance: one entry of each array is one of them."""

    kinds: np.ndarray
    shapes: np.ndarray
    starts: np.ndarray
    spans: np.ndarray
    levels: np.ndarray
    rises: np.ndarray
    together: np.ndarray

    def at(self, day: float) -> np.ndarray:
        place = (day - self.starts) / self.spans
        return self.levels + self.rises * at(self.kinds, self.shapes, place)

    def rate(self, day: float) -> np.ndarray:
        near = 1e-4 * self.spans
        return (self.at(day) - self.at(day - near)) / near

    def since(self) -> np.ndarray:
        return self.starts + self.spans * np.where(self.kinds == ONSET, self.shapes, 0.0)

    def reaches(self, limit: np.ndarray, now: float) -> np.ndarray:
        size = self.at(now)
        outward = np.where(limit < 0.0, -1.0, 1.0)
        with np.errstate(divide='ignore', invalid='ignore'):
            rise = (limit - self.levels) / self.rises
            day = self.starts + self.spans * inverse(self.kinds, self.shapes, rise)
        grows = (self.rises * outward > 0.0) & np.isfinite(day)
        day = np.where(grows, np.maximum(day, now), np.inf)
        return np.where((size - limit) * outward >= 0.0, now, day)


class _Evidence:
    """Evidence of all cuts, laws and scatters of a history; sizes are scaled to about one."""

    def __init__(self, history: History):
        self.history = history
        self.scale = float(max(np.abs(history.values).max(), 3.0 * np.median(history.sigmas)))
        sigma = history.sigmas / self.scale
        self.variances = sigma**2 + np.outer(_SCATTER * np.median(sigma), np.ones(len(sigma)))**2
        count = len(history.days)
        warm = history.temperatures
        season = len(warm) == count and np.ptp(warm) > 0.0
        self.ways = [history.together / self.scale]
        if season:
            self.ways.append(0.5 * (warm - np.median(warm)) / max(np.ptp(warm), _WARMER))
        self.stretches: list[dict[tuple[int, int], tuple[Stretch, tuple[Law, ...]]]] = []
        forward, total, cuts = [], [], []
        for way in self.ways:
            table = self._table(way)
            self.stretches.append(table)
            ahead, behind = _sums(count, {key: np.logaddexp.reduce(entry.evidence, axis=1)
                                          for key, (entry, _) in table.items()})
            forward.append(ahead)
            total.append(ahead[count])
            cuts.append(np.exp(ahead[1:count] + np.log(_CUT) + behind[1:count] - ahead[count]))
        prior = np.log([1.0 - _SEASON, _SEASON][:len(self.ways)]) if season else np.zeros(1)
        self.forward = forward
        self.weights = softmax(np.array(total) + np.log(_USUAL) + prior[:, None])
        self.season = float(self.weights[1].sum()) if season else 0.0
        # Chance of a cut before each date but the first.
        self.cuts = np.einsum('wm,wdm->d', self.weights, np.array(cuts)) if count > 1 \
            else np.empty(0)

    def _table(self, way: np.ndarray):
        days, values = self.history.days, self.history.values / self.scale
        table = {}
        for first in range(len(days)):
            for end in range(first + 1, len(days) + 1):
                part = slice(first, end)
                span = float(np.ptp(days[part])) or 1.0
                places = (days[part] - days[first]) / span
                tried = laws(places)
                table[first, end] = Stretch.of(
                    tried, places, values[part], self.variances[:, part], way[part]), tried
        return table

    def draws(self, random: np.random.Generator) -> _Draws:
        """Return laws of the last stretch, drawn by their weight."""
        days, count = self.history.days, len(self.history.days)
        places, weights = [], []
        for way, table in enumerate(self.stretches):
            for first in range(count):
                found, tried = table[first, count]
                ahead = self.forward[way][first] + (np.log(_CUT) if first else 0.0)
                share = self.weights[way] * np.exp(
                    ahead[:, None] + found.evidence - self.forward[way][count][:, None]
                    + (count - first - 1) * np.log1p(-_CUT)).T
                for law, entry in enumerate(share):
                    for scatter, weight in enumerate(entry):
                        places.append((way, first, law, scatter))
                        weights.append(weight)
        counts = random.multinomial(_DRAWS, np.array(weights) / np.sum(weights))
        columns: list[list[np.ndarray]] = [[] for _ in _Draws._fields]
        for place in np.flatnonzero(counts):
            way, first, law, scatter = places[place]
            found, tried = self.stretches[way][first, count]
            level, rise, off = found.draw(law, scatter, counts[place], random).T
            span = float(np.ptp(days[first:])) or 1.0
            for column, value in zip(columns, (
                    tried[law].kind, tried[law].shape, days[first], span, self.scale * level,
                    self.scale * rise if tried[law].kind else 0.0, 0.0 if way else off)):
                column.append(np.broadcast_to(value, counts[place]))
        return _Draws(*(np.concatenate(column) for column in columns))


def _sums(count: int, evidence: dict[tuple[int, int], np.ndarray]) -> tuple[np.ndarray,
                                                                            np.ndarray]:
    """Return the logarithms of the sums over all cuts before and after each date."""
    width = len(_SCATTER)
    ahead, behind = (np.full((count + 1, width), -np.inf) for _ in range(2))
    ahead[0] = behind[count] = 0.0
    inner = {key: value + (key[1] - key[0] - 1) * np.log1p(-_CUT)
             for key, value in evidence.items()}
    for end in range(1, count + 1):
        ahead[end] = np.logaddexp.reduce([
            ahead[first] + inner[first, end] + (np.log(_CUT) if first else 0.0)
            for first in range(end)], axis=0)
    for first in range(count - 1, -1, -1):
        behind[first] = np.logaddexp.reduce([
            inner[first, end] + behind[end] + (np.log(_CUT) if end < count else 0.0)
            for end in range(first + 1, count + 1)], axis=0)
    return ahead, behind
