# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Samples that a sensor, its cable or its logger made: spikes, and readings that stand still.

They are told from the recording alone, without a model. Told from the drive's own motion they are
by what a sensor's fault alone does: one reading jumps and comes back while no other follows, or
it repeats one number to the last digit where it never did before.
"""
from __future__ import annotations

from collections.abc import Container, Mapping
from typing import NamedTuple

from hst_drive.measure.run import USUAL
import numpy as np

_WIDTHS = (1, 2)        # samples of a spike
_CLEAR = 12.0           # times what the readings around it scatter
_RETURNS = 4.0          # a spike is so many times what the signal moves by beside it
_STEPS = 3.5            # of the sensor's resolution at least
_TAIL = 97.0            # percentile of how far readings lie off their neighbours' line
_BEYOND = 4.0           # times that: what a signal does now and then is no fault
_AROUND = 25            # samples on either side that tell the scatter
_FOLLOWS = 3            # samples within which another channel follows a real jump
_MOVES = 6.0            # times its usual step: it follows
_STEP = 1.5             # of its resolution, where it usually does not move at all
_SHARE = 0.1            # of how far the jump itself stands out, if that is more
_SPARSE = 0.02          # share of spikes above which they are how the signal is
_STANDS, _ROWS = 1.0, 20    # s and readings: shorter repetitions are chance
_REPEATS = 20.0         # times the usual length of a repetition
_COARSE, _FEW = 0.1, 3  # s and readings: who usually repeats a number for longer is coarse
_MOST = 0.9             # of a recording: a sensor that stands for longer is made so
_JUMP = 15.0            # of the usual step: a reading that stands began or ended with it
_SCATTERS = 0.1         # share of its steps that turn back, from which on a reading shows noise
_TOLD = 3
_NULLS = 0.0, 273.15, -101325.0     # what 0 of a logger is in SI: also of degC, and absolute Pa
_FALLS = 0.25           # of what a reading usually is: so far it falls into a lost row, and rises


class Faults(NamedTuple):
    """What was found in one channel: spikes (indices) and frozen stretches (first, end)."""

    spikes: np.ndarray
    frozen: tuple[tuple[int, int], ...]


def without_faults(time: np.ndarray, channels: Mapping[str, np.ndarray]) -> tuple[
        dict[str, np.ndarray], list[str]]:
    """
    Return channels with NaN for the samples that faults made, and notes that tell which.

    Parameters
    ----------
    time : ndarray, shape (n,)
        s, rising.
    channels : mapping of str to ndarray, shape (n,)
        Readings of sensors; any unit, NaN where missing. Commands jump by nature: leave them out.

    """
    found = find_faults(time, channels)
    clean, notes = dict(channels), []
    for name, faults in found.items():
        values = channels[name].copy()
        low, high = np.nanmin(values), np.nanmax(values)
        if len(faults.spikes):
            values[faults.spikes] = np.nan
            notes.append(f'{name}: {len(faults.spikes)} of {len(time)} samples are spikes that '
                         f'no other channel follows ({_at(time[faults.spikes])}); left out')
        for first, end in faults.frozen:
            stands = channels[name][first]
            # What stood at an end of its range is not known in any row there; 0 is rest as well.
            ended = stands not in _NULLS and stands in (low, high)
            values[channels[name] == stands if ended else slice(first, end)] = np.nan
        if faults.frozen:
            spans = ', '.join(f'{time[first]:.4g} to {time[end - 1]:.4g} s'
                              for first, end in faults.frozen[:_TOLD])
            more = f' and {len(faults.frozen) - _TOLD} more' if len(faults.frozen) > _TOLD else ''
            notes.append(f'{name}: stands still to the last digit from {spans}{more}: a frozen, '
                         'disconnected or saturated sensor; left out')
        clean[name] = values
    return clean, notes


def without_lost_rows(time: np.ndarray, channels: Mapping[str, np.ndarray],
                      commands: Container[str]) -> tuple[dict[str, np.ndarray], list[str]]:
    """
    Return channels with NaN for rows that a logger filled with zeros, and a note of them.

    All readings fall to 0 at once, and come back at once: no drive does that.

    Parameters
    ----------
    time : ndarray, shape (n,)
        s, rising.
    channels : mapping of str to ndarray, shape (n,)
        SI.
    commands : container of str
        Channels that may be at 0 in such a row, or not.

    """
    readings = [values for name, values in channels.items()
                if name not in commands and np.isfinite(values).any()]
    if len(readings) < 2:
        return dict(channels), []
    null = np.all([np.isin(values, _NULLS) | np.isnan(values) for values in readings], axis=0)
    usual = [_FALLS * np.nanpercentile(np.abs(values), 90) for values in readings]
    lost = np.zeros(len(time), dtype=bool)
    for first, end in stretches(null):
        if first and end < len(time) and all(
                sum(abs(values[row] - values[first]) > far
                    for values, far in zip(readings, usual)) >= 2 for row in (first - 1, end)):
            lost[first:end] = True
    if not lost.any():
        return dict(channels), []
    clean = {name: np.where(lost & np.isin(values, _NULLS), np.nan, values)
             for name, values in channels.items()}
    return clean, [f'{np.count_nonzero(lost)} of {len(time)} rows are 0 in all readings '
                   f'({_at(time[lost])}): lost by the logger; left out']


def stretches(where: np.ndarray) -> np.ndarray:
    """Return the stretches in which a condition holds, each its first row and the one behind."""
    return np.flatnonzero(np.diff(where.astype(int), prepend=0, append=0)).reshape(-1, 2)


def _at(times: np.ndarray) -> str:
    """Return the first of some times for a note."""
    more = ' and later' if len(times) > _TOLD else ''
    return f'at {", ".join(f"{time:.4g}" for time in times[:_TOLD])} s{more}'


def find_faults(time: np.ndarray, channels: Mapping[str, np.ndarray]) -> dict[str, Faults]:
    """Return the faults of each channel that has any."""
    if len(time) < 4 * _AROUND:
        return {}
    step = float(np.median(np.diff(time)))
    steps = {name: _resolution(values) for name, values in channels.items()}
    found = {}
    for name, values in channels.items():
        spikes = _spikes(values, steps[name])
        if len(spikes):
            spikes = spikes[~_followed(name, spikes, channels, steps)]
        if len(spikes) > _SPARSE * len(values):
            spikes = spikes[:0]
        frozen = _frozen(values, step, steps[name])
        if len(spikes) or frozen:
            found[name] = Faults(spikes, frozen)
    return found


def _followed(name: str, spikes: np.ndarray, channels: Mapping[str, np.ndarray],
              steps: Mapping[str, float]) -> np.ndarray:
    """Tell at which spikes another reading moves as well: then it is the drive."""
    values, moves = channels[name], np.zeros(len(spikes), dtype=bool)
    near = spikes[:, None] + np.arange(-_FOLLOWS, _FOLLOWS)
    about = np.clip(spikes[:, None] + np.arange(-_AROUND, _AROUND), 1, len(values) - 2)
    # A large jump of the drive moves the others far, too.
    own = 0.5 * np.abs(2 * values - np.roll(values, 1) - np.roll(values, -1))
    size = np.nan_to_num(own[spikes] / np.maximum(np.nanmedian(own[about], axis=1),
                                                  max(steps[name], 1e-300)))
    for each, other in channels.items():
        if each == name:
            continue
        changes = np.abs(np.diff(other, append=other[-1:]))
        # a row at 0 throughout is one that the logger lost, not a drive that moves
        lost = (other == 0.0) & (values == 0.0)
        changes[lost | np.roll(lost, -1)] = 0.0
        changes = np.nan_to_num(changes)
        # while the drive sticks and slips all move far: then the quiet of the recording counts
        quiet = np.median(changes[changes > 0]) if changes.any() else 0.0
        usual = np.median(changes[about], axis=1)
        usual = np.where(values[spikes] == 0.0, usual, np.minimum(usual, quiet))
        most = np.max(changes[np.clip(near, 0, len(other) - 1)], axis=1)
        # a coarse reading moves seldom, and then by its step
        coarse = (usual == 0.0) & (steps[each] > 0.0)
        moves |= (most > np.maximum(_MOVES, _SHARE * size) * usual) & (usual > 0.0)
        moves |= (most > np.maximum(_STEP, _SHARE * size) * steps[each]) & coarse
    return moves


def _resolution(values: np.ndarray) -> float:
    """Return the smallest change that the readings show."""
    changes = np.abs(np.diff(values[np.isfinite(values)]))
    changes = changes[changes > 1e-9 * max(float(np.max(changes, initial=0.0)), 1e-300)]
    return float(np.percentile(changes, 1)) if len(changes) else 0.0


def _spikes(values: np.ndarray, resolution: float) -> np.ndarray:
    """Return the indices of readings that jump away and come back at once."""
    good = np.flatnonzero(np.isfinite(values))
    if len(good) < 4 * _AROUND:
        return good[:0]
    x = values[good]
    found: list[np.ndarray] = []
    for width in _WIDTHS:
        # x[k - 1] and x[k + width] are the edges of the block that begins at k.
        k = np.arange(3, len(x) - width - 2)
        line = 0.5 * (x[k - 1] + x[k + width])
        off = np.min([np.abs(x[k + i] - line) for i in range(width)], axis=0)
        sides = [np.sign(x[k + i] - line) for i in range(width)]
        off = np.where(sides[0] == sides[-1], off, 0.0)
        usual = 1.4826 * float(np.median(off))
        rare = _BEYOND * float(np.percentile(off, _TAIL))
        far = off > max(0.5 * _CLEAR * usual, rare, _STEPS * resolution)
        k, off = k[far], off[far]
        if not len(k):
            continue
        edge = np.abs(x[k + width] - x[k - 1])
        # The second smallest: another spike beside this one does not count, ringing does.
        beside = np.sort(np.abs([x[k - 1] - x[k - 2], x[k - 2] - x[k - 3],
                                 x[k + width + 1] - x[k + width],
                                 x[k + width + 2] - x[k + width + 1]]), axis=0)[1]
        rows = k[:, None] + np.arange(-_AROUND, _AROUND)
        rows = np.clip(rows, 1, len(x) - 2)
        rough = np.abs(x[rows] - 0.5 * (x[rows - 1] + x[rows + 1]))
        scatter = 1.4826 * np.median(rough, axis=1)
        limit = np.max([_CLEAR * scatter, _RETURNS * edge, _RETURNS * beside,
                        np.full(len(k), _STEPS * resolution)], axis=0)
        first = k[off > limit]
        found.append((first[:, None] + np.arange(width)).ravel())
    return good[np.unique(np.concatenate(found))] if found else good[:0]


def _frozen(values: np.ndarray, step: float, resolution: float) -> tuple[tuple[int, int], ...]:
    """Return stretches over which a reading that else moves repeats one number."""
    first, last = stretches(np.diff(values) == 0.0).T
    end = last + 1
    finite = values[np.isfinite(values)]
    if not len(first) or not len(finite) or resolution == 0.0:
        return ()
    length = end - first
    ends = float(finite.min()), float(finite.max()), 0.0
    # Where a reading often stands for a while, coarse steps or a slow sensor do it, no fault.
    alone = max(len(finite) - int(length.sum()), 0)
    stands = max(_STANDS / step, _ROWS)
    short = length[(length < stands) & ~np.isin(values[first], ends)]
    each = np.concatenate([np.repeat(short, short), np.ones(alone)])    # by reading
    usual = float(np.percentile(each, USUAL)) if len(each) else np.inf
    limit = max(stands, _REPEATS * usual)
    inside = (length > limit) & ~np.isin(values[first], ends)
    if usual > max(_COARSE / step, _FEW) or length[inside].sum() > _MOST * len(finite):
        return ()
    moves = np.diff(finite)
    changes, moves = np.abs(moves), moves[moves != 0.0]
    scatters = np.count_nonzero(moves[1:] * moves[:-1] < 0.0) > _SCATTERS * len(moves)
    far = max(ends, key=abs) if scatters else None
    jump = max(_JUMP * float(np.median(changes[changes > 0])), _STEPS * resolution)
    found = []
    for a, b in zip(first[length > limit].tolist(), end[length > limit].tolist()):
        into = [abs(values[row] - values[a]) for row in (a - 1, b) if 0 <= row < len(values)]
        # A drive at rest, and a reading without noise at an end of its motion, stand still as
        # well: but they come there and go without a jump.
        if values[a] not in ends or values[a] == far or any(size > jump for size in into):
            found.append((a, b))
    return tuple(found)
