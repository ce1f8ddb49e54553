# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Signals with stamps of their own, brought to one time base.

The base is the stamps of the densest signal. The others are read between their samples as their
channel is held (commands stay, from the nearest stamp on; analogue signals move on a straight
line), never beyond their ends, and not across gaps.
"""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hst_drive.bag.channels import channel_of, differences
from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.measure.balances import SLOWEST
from hst_drive.measure.faults import without_faults, without_lost_rows
from hst_drive.measure.run import Run
import numpy as np

MIN_ROWS = 10
"""Fewer samples than this are no recording."""
_SHORTEST = 1e-4        # s: no logger of a drive is faster
GAP_PERIODS = 5.0
"""A signal is missing between samples that lie further apart than this many periods."""
_HOLE_PERIODS = 20.0    # without any sample: worth a word
_LONGEST_HOLE = 3600.0  # s that a replay bridges: beyond, these are two recordings
_APART = 5.0            # two signals differ by so many times what each changes by


@dataclass(frozen=True)
class Signal:
    """One channel as recorded: stamps (ns) and SI values."""

    channel: str
    stamps: np.ndarray
    values: np.ndarray


def finish_run(name: str, time: np.ndarray, channels: Mapping[str, np.ndarray], source: str,
               notes: Sequence[str], rows: str = 'rows') -> Run:
    """
    Check a recording and return it.

    Channels without a single number are left out, and so are samples that a sensor's fault made
    (``hst_drive.measure.faults``).

    Raises
    ------
    InputError
        If there are too few rows or no channel with numbers.

    """
    notes = list(notes)
    if len(time) < MIN_ROWS:
        raise InputError(f'{source}: only {len(time)} {rows[:-1] if len(time) == 1 else rows} of '
                         f'data; a recording needs at least {MIN_ROWS}')
    interval = float(np.median(np.diff(time)))
    if interval < _SHORTEST:
        notes.append(f'rows come every {1e6 * interval:.3g} us: is the unit of the time column '
                     'right?')
    channels, lost = without_lost_rows(time, channels, [
        name for name in channels if CHANNELS[name].hold == 'zero'])
    notes += lost
    kept = {}
    holes: dict[int, list[str]] = {}
    for channel, values in channels.items():
        missing = int(np.count_nonzero(~np.isfinite(values)))
        if missing == len(values):
            notes.append(f'{channel}: no numbers in it; left out')
            continue
        if missing:
            values = np.where(np.isfinite(values), values, np.nan)
            holes.setdefault(missing, []).append(channel)
        numbers = values[np.isfinite(values)]
        if CHANNELS[channel].hold == 'linear' and len(numbers) >= 100 and np.ptp(numbers) == 0:
            notes.append(f'{channel}: the same number throughout; is the sensor connected?')
        kept[channel] = values
    notes += [f'{", ".join(names)}: {missing} of {len(time)} samples missing'
              for missing, names in holes.items()]
    notes += _interruptions(time, source)
    sensors, faults = without_faults(time, {channel: values for channel, values in kept.items()
                                            if CHANNELS[channel].hold == 'linear'})
    kept.update(sensors)
    notes += faults
    if not kept:
        raise InputError(f'{source}: none of its channels holds a number')
    return Run(name, time, kept, source, tuple(notes))


def _interruptions(time: np.ndarray, source: str) -> list[str]:
    """Return a note if there are holes in the recording itself; refuse one that is too long."""
    steps = np.diff(time)
    holes = np.flatnonzero(steps > _HOLE_PERIODS * np.median(steps))
    if not len(holes):
        return []
    longest = holes[np.argmax(steps[holes])]
    # A table of operating points is bridged by nothing.
    if steps[longest] > _LONGEST_HOLE and np.median(steps) < SLOWEST:
        raise InputError(f'{source}: no samples for {steps[longest]:.6g} s after '
                         f'{time[longest]:g} s; expected at most {_LONGEST_HOLE:g} s: mend the '
                         'time stamps, or give what lies before and after as logs of their own')
    return [f'no samples for {steps[longest]:.6g} s after {time[longest]:g} s'
            + (f' and in {len(holes) - 1} more places' if len(holes) > 1 else '')
            + '; the replay bridges it with the last commands']


def in_order(signal: Signal, notes: list[str]) -> Signal:
    """Return the signal with rising stamps, noting what was done."""
    stamps, values = signal.stamps, signal.values
    if len(stamps) and not np.all(np.diff(stamps) > 0):
        order = np.argsort(stamps, kind='stable')
        stamps, values = stamps[order], values[order]
        first = np.concatenate(([True], np.diff(stamps) > 0))
        notes += disorder(signal.channel, signal.stamps)
        if not first.all():
            notes.append(f'{signal.channel}: {np.count_nonzero(~first)} messages with a repeated '
                         'stamp; the first of each kept')
        stamps, values = stamps[first], values[first]
    return Signal(signal.channel, stamps, values)


def disorder(name: str, stamps: np.ndarray) -> list[str]:
    """Return a note if messages came out of order."""
    back = np.diff(stamps)
    back = back[back < 0]
    if not len(back):
        return []
    return [f'{name}: {len(back)} messages came out of order (by up to '
            f'{-back.min() / 1e9:.3g} s); sorted']


def alternates(signal: Signal) -> bool:
    """Tell whether every other value belongs to another signal: two sources on one topic."""
    if channel_of(signal.channel).hold != 'linear':
        return False
    values = signal.values[np.argsort(signal.stamps, kind='stable')]
    values = values[np.isfinite(values)]
    if len(values) < 4 * MIN_ROWS:
        return False
    next_one = np.median(np.abs(values[1:] - values[:-1]))
    next_but_one = np.median(np.abs(values[2:] - values[:-2]))
    return bool(next_one > _APART * next_but_one and next_one > 0.0)


def align(signals: Sequence[Signal], name: str, source: str, notes: Sequence[str] = (),
          origin: int | None = None) -> Run:
    """
    Bring signals to one time base that begins at 0 s, or counts from ``origin`` (ns).

    Raises
    ------
    InputError
        If there are too few samples.

    """
    notes = list(notes)
    ordered = [in_order(signal, notes) for signal in signals]
    base = max(ordered, key=lambda signal: len(signal.stamps))
    channels = {}
    moved = []
    for signal in ordered:
        if np.array_equal(signal.stamps, base.stamps):
            channels[signal.channel] = signal.values
        else:
            channels[signal.channel] = sample(signal, base.stamps)
            moved.append(signal.channel)
    if moved:
        notes.append(f'{", ".join(moved)}: read at the stamps of {base.channel}')
    if origin is None:
        origin = base.stamps[0] if len(base.stamps) else 0
    return finish_run(name, (base.stamps - origin) / 1e9, differences(channels), source, notes,
                      'messages')


def sample(signal: Signal, stamps: np.ndarray) -> np.ndarray:
    """
    Return a signal's values at other stamps (ns, rising); NaN outside it and in gaps.

    Held signals stay for up to ``GAP_PERIODS`` of their longer spacings (90th percentile), so
    that a command that is sent only when it changes is not taken for one with gaps.
    """
    good = ~np.isnan(signal.values)
    own, values = signal.stamps[good], signal.values[good]
    if not len(own):
        return np.full(len(stamps), np.nan)
    held = channel_of(signal.channel).hold == 'zero'
    # A command that comes between two stamps acts from the nearer one on.
    half = int(np.median(np.diff(stamps))) // 2 if held and len(stamps) > 1 else 0
    before = np.searchsorted(own, stamps + half, side='right') - 1
    inside = before >= 0
    before = np.maximum(before, 0)
    if held:
        if len(own) == 1:
            return np.where(inside, values[0], np.nan)
        limit = GAP_PERIODS * np.percentile(np.diff(own), 90)
        return np.where(inside & (stamps - own[before] <= limit), values[before], np.nan)
    after = np.minimum(before + (stamps > own[before]), len(own) - 1)
    inside &= stamps <= own[-1]
    span = own[after] - own[before]
    limit = GAP_PERIODS * np.median(np.diff(own)) if len(own) > 1 else 0.0
    weight = (stamps - own[before]) / np.maximum(span, 1)
    between = values[before] + weight * (values[after] - values[before])
    return np.where(inside & (span <= limit), between, np.nan)
