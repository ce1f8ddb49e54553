# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where a model fails: regions of the operating range that hold more error than their time."""
from __future__ import annotations

from typing import Mapping, NamedTuple, Sequence

from hst_drive.channels import CHANNELS, TORQUES
from hst_drive.measure.readings import filled
from hst_drive.measure.run import Run
import numpy as np
from scipy.ndimage import gaussian_filter1d

_BINS = 8
_MOST = 8           # regions, the most telling first
AT_NOISE = 1.15     # floors: in a signal that is nearer nothing is left
_VARIABLES = ('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed', 'oil_temperature',
              'pump_command', 'pprv_command', 'load_torque', 'motor_torque')
# A region says something if the odds of the error to lie there are so many times those of the
# time: fewer are needed where the variable explains more of it. Where the error changes its sign
# from moment to moment no function explains it, but then it must be crowded.
_ODDS = ((0.3, 1.5), (0.1, 2.0), (0.0, 5.0))   # explained at least, odds at least
WARMS = 2.0         # K; oil that keeps its temperature explains nothing
TRANSIENT = 'pressure_rate'   # Pa/s; how fast the state changes


class Region(NamedTuple):
    """
    A range of one variable that holds more of a signal's error than its share of the time.

    ``explained`` is the share of the error's variance that a function of the variable explains.
    """

    signal: str
    variable: str
    low: float
    high: float
    unit: str
    share_of_error: float
    share_of_time: float
    explained: float


def operating_variables(run: Run) -> dict[str, np.ndarray]:
    """Return what the error may depend on, smoothed over 0.1 s, SI."""
    width = max(0.1 / run.sample_time, 0.5)
    found = {}
    for name in _VARIABLES:
        if name in run and np.isfinite(run[name]).any():
            values, hold = filled(run[name]), CHANNELS[name].hold == 'zero'
            found[name] = values if hold else gaussian_filter1d(values, width)
    pressure = found.get('pump_outlet_pressure', found.get('motor_inlet_pressure'))
    if pressure is not None:
        found[TRANSIENT] = np.abs(np.gradient(pressure, run.time))
    return found


def where(errors: Mapping[str, Sequence[np.ndarray]],
          variables: Mapping[str, Sequence[np.ndarray]],
          floors: Mapping[str, float]) -> list[Region]:
    """
    Find the regions that hold the error; none where it is spread over the whole range.

    Parameters
    ----------
    errors : mapping of str to sequence of ndarray
        Model minus measurement by signal, one array per log.
    variables : mapping of str to sequence of ndarray
        What the error may depend on, one array per log.
    floors : mapping of str to float
        Rmse by signal that a perfect model would show.

    """
    regions = []
    for signal, parts in errors.items():
        error = np.concatenate(parts)
        valid = np.isfinite(error)
        if valid.sum() < 10 * _BINS:
            continue
        power = np.mean(error[valid]**2)
        if power < (AT_NOISE * floors[signal])**2:
            continue
        for variable, columns in variables.items():
            if variable == signal and variable in TORQUES:
                continue
            region = _region(signal, variable, error[valid], np.concatenate(columns)[valid])
            if region:
                telling = region.explained + region.share_of_error - region.share_of_time
                regions.append((telling * (power / floors[signal]**2)**0.25, region))
    regions.sort(key=lambda item: -item[0])
    return [region for _, region in regions[:_MOST]]


def _region(signal: str, variable: str, error: np.ndarray, values: np.ndarray) -> Region | None:
    edges = np.unique(np.quantile(values, np.linspace(0, 1, _BINS + 1)))
    least = max(WARMS if variable == 'oil_temperature' else 0.0, 1e-9 * np.abs(edges).max(), 1e-18)
    if len(edges) < 3 or edges[-1] - edges[0] < least:
        return None
    bins = np.clip(np.searchsorted(edges, values, side='right') - 1, 0, len(edges) - 2)
    counts = np.bincount(bins, minlength=len(edges) - 1)
    counts_safe = np.maximum(counts, 1)
    means = np.bincount(bins, error, minlength=len(counts)) / counts_safe
    squares = np.bincount(bins, error**2, minlength=len(counts))
    total = error.var()
    explained = float(counts @ (means - error.mean())**2 / len(error) / total) if total else 0.0
    time_share = counts / len(error)
    error_share = squares / squares.sum()
    best, found = 0.0, None
    for low in range(len(counts)):
        for high in range(low + 1, len(counts) + 1):
            held, spent = error_share[low:high].sum(), time_share[low:high].sum()
            if spent < 0.95 and held - spent > best:
                best, found = held - spent, (low, high, held, spent)
    if not found or best < 0.1:
        return None
    low, high, held, spent = found
    odds = held * (1 - spent) / max(spent * (1 - held), 1e-9)
    if odds < next(least for share, least in _ODDS if explained >= share):
        return None
    unit = 'Pa/s' if variable == TRANSIENT else CHANNELS[variable].unit
    return Region(signal, variable, float(edges[low]), float(edges[high]), unit, float(held),
                  float(spent), explained)
