# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a recording's readings are: their noise, their resolution, the ends of their range."""
from __future__ import annotations

from typing import Mapping

from hst_drive.channels import CHANNELS
from hst_drive.measure.noise import noise_std
from hst_drive.measure.run import Run
from hst_drive.rig.rig import Sensor
import numpy as np
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

_LOOKED_AT, _ROUNDED = 20_000, 1e-9     # values, and of their range what rounding makes
_COARSE, _AGAIN = 12, 0.1   # values of a coarse reading, and what share of its rows they are
_SLOW = 1.0     # s: slower parts of a signal are taken as they are
_MIXED = 0.3, 1.7    # of a delay: their mean is late as two filters of half of it in a row are
LONGEST_DELAY, _TRIALS, _STEPS = 0.2, 41, 3     # s; delays that are tried, steps from the best
_LAG_SHARE = 0.7    # of a lag: half the window of the slope that undoes it


class Readings:
    """
    The readings of a recording as its sensors make them.

    Parameters
    ----------
    run : Run
        The recording.
    sensors : mapping of str to Sensor
        By channel; a channel may have none.

    Attributes
    ----------
    lags : dict of str to float
        First-order lag (s) of a channel's reading.

    """

    def __init__(self, run: Run, sensors: Mapping[str, Sensor]):
        self.run, self.sensors = run, sensors
        self.lags: dict[str, float] = {}

    def step(self, name: str) -> float:
        """Return the deviation (SI) that the sensor's resolution alone makes."""
        stated = self.sensors.get(name, Sensor(0.0)).step_std
        return max(stated, _seen_step(self.run[name]) / np.sqrt(12.0), 1e-12)

    def noise(self, name: str, values: np.ndarray) -> float:
        """Tell how large the white part of a signal is, or of what is left of it (SI)."""
        low, high = self.at_ends(name)
        # A reading that stands at the end of its range shows no noise.
        moving = np.where(low | high, np.nan, values)
        if np.mean(np.isfinite(moving)) < 0.5 * np.mean(np.isfinite(values)):
            moving = values
        known = values[np.isfinite(values)]
        if (len(known) == 0 or np.ptp(known) == 0.0) and name in self.sensors:
            # One number throughout says nothing of the noise, and is no sign that there is none.
            return max(self.sensors[name].noise_std, self.step(name))
        return max(noise_std(moving), self.step(name))

    def at_ends(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Say where a reading stands at the lower and at the upper end of its sensor's range."""
        measured, sensor = self.run[name], self.sensors.get(name)
        if sensor is None or not sensor.range:
            return np.zeros((2, len(measured)), dtype=bool)
        low, high = sensor.range
        near = 0.51 * sensor.resolution + 1e-9 * (high - low)
        return np.abs(measured - low) <= near, np.abs(measured - high) <= near

    def as_read(self, name: str, model: np.ndarray) -> np.ndarray:
        """Let the model lag as the reading does, and hold it where that is at its range's end."""
        if lag := self.lags.get(name):
            from scipy.signal import lfilter    # here: few need it, and it loads for a second

            share = -np.expm1(-self.run.sample_time / lag)
            model = lfilter([share], [1.0, share - 1.0], model, zi=[(1.0 - share) * model[0]])[0]
        measured, (low, high) = self.run[name], self.at_ends(name)
        if not (low.any() or high.any()):
            return model
        model = np.where(low, np.maximum(model, measured), model)
        return np.where(high, np.minimum(model, measured), model)

    def ahead(self, values: np.ndarray, lag: float) -> np.ndarray:
        """Return what a reading with a first-order lag (s) was made of."""
        if lag <= 0.0:
            return values
        step = self.run.sample_time
        half = min(max(round(_LAG_SHARE * lag / step), 2), (len(values) - 1) // 2)
        if half < 2:
            return values
        from scipy.signal import savgol_filter  # here: few need it, and it loads for a second

        return values + lag * savgol_filter(values, 2 * half + 1, 4, deriv=1, delta=step)

    def slow(self, values: np.ndarray) -> np.ndarray:
        """Return what in a signal of this recording is slower than about a second."""
        # Three running means: as good as a Gaussian here, at a cost that does not grow with width.
        width = max(int(2 * _SLOW / self.run.sample_time), 1)
        for _ in range(3):
            # mirrored at the ends: 'nearest' would hold one noisy sample for a second
            values = uniform_filter1d(values, width, mode='reflect')
        return values


def later(time: np.ndarray, values: np.ndarray, delay: float) -> np.ndarray:
    """Return what a sensor reads that is late (s): an amplifier's filter mixes two moments."""
    return values if not delay else np.mean(
        [np.interp(time - share * delay, time, values) for share in _MIXED], axis=0)


def earlier(time: np.ndarray, values: np.ndarray, delay: float) -> np.ndarray:
    """Return what a reading that is late (s) was made of."""
    return np.interp(time + delay, time, values) if delay else values


def best_delay(time: np.ndarray, model: np.ndarray, measured: np.ndarray,
               floor: float = 0.0) -> float:
    """Return by how much (s) a reading is later than its model, as the least error has it."""
    slope, delay = np.gradient(model, time), 0.0
    rows = np.flatnonzero(np.isfinite(slope + measured))
    some = rows[::len(rows) // _LOOKED_AT + 1]      # enough to choose by

    def error(late: float, rows: np.ndarray) -> np.ndarray:
        return np.interp(time[rows] - late, time, model) - measured[rows]

    def left(late: float) -> float:
        known = error(late, some)
        known = known[np.isfinite(known)]
        return float(known.var()) if 2 * len(known) > len(some) else np.inf

    if len(rows) and left(0.0) > floor**2:
        # The slope tells a short delay only.
        delay = float(min(np.linspace(-LONGEST_DELAY, LONGEST_DELAY, _TRIALS), key=left))
    for _ in range(_STEPS):
        rate, rest = np.interp(time[rows] - delay, time, slope), error(delay, rows)
        valid = np.isfinite(rate + rest)
        if not valid.any() or not np.ptp(rate[valid]):
            return 0.0
        rate, rest = rate[valid] - rate[valid].mean(), rest[valid]
        delay = float(np.clip(delay + rate @ (rest - rest.mean()) / (rate @ rate),
                              -LONGEST_DELAY, LONGEST_DELAY))
    return delay


def _seen_step(values: np.ndarray) -> float:
    """Return the steps of a reading that takes the same values again and again; else 0."""
    values = values[np.isfinite(values)][:_LOOKED_AT]
    apart = np.diff(np.unique(values))
    # What differs by less is rounding: of a difference of two readings, say.
    apart = apart[apart > _ROUNDED * apart.sum()]
    return float(apart.min()) if 0 < len(apart) < max(_COARSE, _AGAIN * len(values)) else 0.0


def gaps(values: np.ndarray) -> np.ndarray:
    """Say which samples of a channel are missing, other than between those of a slower sensor."""
    there = np.flatnonzero(np.isfinite(values))
    ends = np.concatenate([[-1], there, [len(values)]])
    apart = np.diff(ends)
    wide = apart > np.median(np.diff(there))
    return ~np.isfinite(values) & np.repeat(wide, apart)[:len(values)]


def bridged(name: str, values: np.ndarray, sample_time: float) -> np.ndarray:
    """Bridge the gaps of a channel; of a slow one smooth its sensor's noise away, too."""
    values = filled(values, hold=CHANNELS[name].hold == 'zero')
    # Operating points have no time.
    smooth = CHANNELS[name].slow and np.isfinite(sample_time)
    return gaussian_filter1d(values, max(1.0 / sample_time, 1.0)) if smooth else values


def filled(values: np.ndarray, hold: bool = False) -> np.ndarray:
    """Bridge NaN: the last value for commands, a straight line for signals."""
    bad = ~np.isfinite(values)
    if not bad.any():
        return np.ascontiguousarray(values, dtype=float)
    index = np.arange(len(values))
    if not hold:
        return np.interp(index, index[~bad], values[~bad])
    last = np.maximum.accumulate(np.where(bad, -1, index))
    first = int(np.argmax(~bad))
    return values[np.where(last < 0, first, last)]
