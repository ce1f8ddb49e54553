# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a recording asked of a drive, to be asked of another run: ``kind: recorded``.

Commands and set points stay between their samples, the others move on a straight line. What the
recording lacks in places is bridged, and told.
"""
from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from hst_drive.channels import TORQUES
from hst_drive.errors import InputError
from hst_drive.load.keys import Keys
from hst_drive.load.profile_sections import COMMAND, Quantity, SPEED, TEMPERATURE, TORQUE
from hst_drive.load.profiles import constant, Points, Profile
from hst_drive.units import from_si, to_si
import numpy as np

KIND = 'recorded'
_QUANTITIES = {'speed_setpoint': SPEED, 'oil_temperature': TEMPERATURE, 'pump_command': COMMAND,
               'pprv_command': COMMAND, **dict.fromkeys(TORQUES[::-1], TORQUE)}
_HELD = ('speed_setpoint', 'pump_command', 'pprv_command')
_TURNING = 0.5          # of the set point: the drive runs already
_SLOW = 2.0             # s before and after
_GAP = 1.0              # s without a sample are worth a word


class Recording(NamedTuple):
    """Time (s, rising) and channels (SI, NaN where missing) of a recording, and its name."""

    source: str
    time: np.ndarray
    channels: Mapping[str, np.ndarray]


class Recorded:
    """
    The recording that a scenario names, read when the first section asks for it.

    Parameters
    ----------
    keys : Keys or None
        The scenario's ``recording`` section: file, channels and ``time_range_s``.
    read : callable
        Takes file and channel map (or None) and returns a Recording.

    """

    def __init__(self, keys: Keys | None, read: Callable[[str | None, str | None], Recording]):
        self._file = keys and keys.text('file', None)
        self._channels = keys and keys.text('channels', None)
        self._range = keys.numbers('time_range', 's', low=-1e9, count=2) \
            if keys and keys.has('time_range', 's') else None
        if keys:
            keys.done()
        self._read, self._found = read, None
        self.notes: list[str] = []

    @property
    def recording(self) -> Recording:
        """The recording, its time from 0 s on."""
        if self._found is None:
            self._found = self._cut(self._read(self._file, self._channels))
        return self._found

    @property
    def end(self) -> float:
        """Where it ends, s: its last sample counts for as long as the others."""
        time = self.recording.time
        return float(time[-1] + np.median(np.diff(time)))

    def _cut(self, whole: Recording) -> Recording:
        time, keep = whole.time, np.ones(len(whole.time), dtype=bool)
        if self._range is not None:
            keep = (time >= self._range[0]) & (time <= self._range[1])
        if keep.sum() < 2:
            raise InputError(
                f'{whole.source}: fewer than 2 samples from {self._range[0]:g} to '
                f'{self._range[1]:g} s; it runs from {time[0]:g} to {time[-1]:g} s: mend '
                'recording.time_range_s')
        return Recording(whole.source, time[keep] - time[keep][0],
                         {name: values[keep] for name, values in whole.channels.items()})

    def load(self, keys: Keys) -> tuple[Profile | None, Profile | None]:
        """Return the load as torque (N.m), or else as PPRV command (V), of a section."""
        keys.take('kind')
        there, known = self.recording.channels, ('pprv_command', *TORQUES[::-1])
        found = [name for name in known if name in there]
        channel = keys.choice('channel', known) if keys.has('channel') else (*found, '')[0]
        keys.done()
        if channel not in there:
            raise InputError(
                f'{self.recording.source}: no load in it: expected the channel '
                f'{channel or " or ".join(known)}, found {", ".join(there)}; name the foreign '
                'one with --channels')
        self.notes.append(f'the load is {channel} of {self.recording.source}')
        profile = self._points(channel)
        return (None, profile) if channel == 'pprv_command' else (profile, None)

    def profile(self, keys: Keys, channel: str) -> Profile:
        """
        Return a channel as a profile.

        ``otherwise_...`` of the section is its value where the recording has none.
        """
        what = _QUANTITIES[channel]
        keys.take('kind')
        otherwise = keys.number(f'otherwise_{what.name}', what.unit, None, low=what.low,
                                high=what.high)
        keys.done()
        values = self.recording.channels.get(channel)
        asked = values is not None and (channel != 'speed_setpoint' or (
            np.abs(values) > 0.0).any())
        if asked:
            return self._points(channel)
        lack = 'is 0 throughout' if values is not None else 'is not in it'
        if otherwise is None:
            raise InputError(
                f'{self.recording.source}: {channel} {lack}; name the foreign one with '
                f"--channels or give '{keys.path}' a profile of its own")
        self.notes.append(f'{self.recording.source}: {channel} {lack}; '
                          f'{from_si(otherwise, what.unit):g} {what.unit} throughout')
        return constant(otherwise)

    def turns(self, setpoint: Profile) -> bool:
        """Tell whether the drive runs when the recording begins."""
        speed = self.recording.channels.get('motor_speed')
        if speed is None:
            return False
        first = speed[np.isfinite(speed)][:1]
        return bool(len(first) and setpoint(0.0) > 0.0 and first[0] > _TURNING * setpoint(0.0))

    def _points(self, channel: str) -> Points:
        recording, what = self.recording, _QUANTITIES[channel]
        values = recording.channels[channel]
        good = np.isfinite(values)
        if not good.any():
            raise InputError(f'{recording.source}: {channel} holds no number in the part to be '
                             'used; mend recording.time_range_s or the recording')
        time, values = recording.time[good], values[good]
        gap = float(np.diff(np.concatenate(([0.0], time, [self.end]))).max())
        if not good.all() and gap > _GAP:
            way = 'held' if channel in _HELD else 'bridged by a straight line'
            self.notes.append(f'{channel}: {np.count_nonzero(~good)} of {len(good)} samples '
                              f'missing, {way} for up to {gap:.3g} s')
        values = self._within(channel, values, what)
        if channel == 'oil_temperature':
            values = _mean(time, values)
        if channel in _HELD:
            kept = np.concatenate(([True], np.diff(values) != 0.0))
            return Points(time[kept].tolist(), values[kept].tolist(), 'zero')
        return Points(time.tolist(), values.tolist())

    def _within(self, channel: str, values: np.ndarray, what: Quantity) -> np.ndarray:
        low, high = to_si(what.low, what.unit), to_si(what.high, what.unit)
        beyond = (values < low) | (values > high)
        if beyond.any():
            self.notes.append(f'{channel}: {np.count_nonzero(beyond)} of {len(values)} samples '
                              f'beyond {what.low:g} to {what.high:g} {what.unit}; held there')
        return np.clip(values, low, high)


def _mean(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the mean about each sample: the oil is slow, what varies is its sensor's noise."""
    steps = 0.5 * (values[1:] + values[:-1]) * np.diff(time)
    area = np.concatenate(([0.0], np.cumsum(steps)))
    first, last = np.maximum(time - _SLOW, time[0]), np.minimum(time + _SLOW, time[-1])
    if not np.all(last > first):
        return values
    return (np.interp(last, time, area) - np.interp(first, time, area)) / (last - first)


def is_recorded(keys: Keys) -> bool:
    """Tell whether a section asks for the recording."""
    return keys.content.get('kind') == KIND
