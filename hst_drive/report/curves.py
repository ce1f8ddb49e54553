# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Curves for a screen: thinned so that no peak is lost, and packed into text."""
from __future__ import annotations

import base64
from typing import Sequence

from hst_drive.channels import CHANNELS
from hst_drive.measure.compare import LogComparison
from hst_drive.units import difference_from_si, from_si
import numpy as np

POINTS = 12_000             # of a curve, at most: some hundred times more than a screen is wide
_FEWEST = 2_000             # of a curve, however many there are
_BUDGET = 1_600_000         # of a page: 4 bytes each, and a third more as text: 9 MB
INPUTS = ('pump_command', 'pprv_command', 'speed_setpoint', 'oil_temperature')


def points_each(logs: Sequence[LogComparison], models: int) -> int:
    """Return how many points a curve of a page may have."""
    curves = sum(len(log.signals) * (1 + 2 * models) + len(INPUTS) for log in logs)
    return int(min(max(_BUDGET / max(curves, 1), _FEWEST), POINTS))


def thin(values: np.ndarray, points: int) -> np.ndarray:
    """
    Return a curve with at most so many points that shows every peak.

    The samples are cut into bunches of equal length, of which the least and the greatest value
    stay, in the order in which they came; see ``thin_time``.
    """
    size = _bunch(len(values), points)
    if size == 1:
        return np.asarray(values, dtype=float)
    count = -(-len(values) // size)
    padded = np.full(count * size, np.nan)
    padded[:len(values)] = values
    bunches = padded.reshape(count, size)
    empty = np.isnan(bunches).all(axis=1)
    bunches = np.where(empty[:, None], 0.0, bunches)
    least, most = np.nanargmin(bunches, axis=1), np.nanargmax(bunches, axis=1)
    rows = np.arange(count)
    kept = np.stack([bunches[rows, np.minimum(least, most)],
                     bunches[rows, np.maximum(least, most)]], axis=1)
    kept[empty] = np.nan
    return kept.ravel()


def thin_time(time: np.ndarray, points: int) -> np.ndarray:
    """Return the times of what ``thin`` leaves: begin and middle of each bunch, s."""
    size = _bunch(len(time), points)
    if size == 1:
        return np.asarray(time, dtype=float)
    begin = np.arange(0, len(time), size)
    return np.stack([time[begin], time[np.minimum(begin + size // 2, len(time) - 1)]],
                    axis=1).ravel()


def _bunch(samples: int, points: int) -> int:
    return 1 if samples <= points else -(-2 * samples // points)


def pack(values: np.ndarray) -> str:
    """Return numbers as text: 4-byte floats, little-endian, in base64."""
    return base64.b64encode(np.asarray(values, dtype='<f4').tobytes()).decode('ascii')


def measured_curves(log: LogComparison, points: int) -> dict:
    """Return time, recorded inputs and measured signals of a log, in the units of the field."""
    run = log.run
    start = float(run.time[0])
    return {'name': run.name, 'start': start, 'end': float(run.time[-1]), 'samples': len(run),
            'time': pack(thin_time(run.time - start, points)),
            'thinned': _bunch(len(run), points),
            'leftOut': [[span.start - start, span.end - start] for span in log.judged.left_out],
            'inputs': {name: _curve(run[name], name, points) for name in INPUTS if name in run},
            'measured': {name: _curve(run[name], name, points) for name in log.signals}}


def model_curves(log: LogComparison, points: int) -> dict:
    """Return what the model gives for a log, and the error, in the units of the field."""
    errors = {name: difference_from_si(log.model[name] - log.run[name], CHANNELS[name].display)
              for name in log.signals}
    return {'model': {name: _curve(log.model[name], name, points) for name in log.signals},
            'error': {name: pack(thin(error, points)) for name, error in errors.items()},
            'floor': {name: difference_from_si(entry.floor, CHANNELS[name].display)
                      for name, entry in log.signals.items()},
            'ratio': {name: entry.noise_ratio for name, entry in log.signals.items()}}


def _curve(values: np.ndarray, name: str, points: int) -> str:
    return pack(thin(from_si(np.asarray(values, dtype=float), CHANNELS[name].display), points))


def titles() -> dict[str, dict[str, str]]:
    """Return title and unit of each channel for people."""
    return {name: {'title': channel.title, 'unit': 'deg C' if channel.display == 'degC'
                   else channel.display} for name, channel in CHANNELS.items()}
