# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A recording: one time base and named channels in SI."""
from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Mapping

from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.units import from_si
import numpy as np

FEWEST = 8              # of anything: fewer tell nothing
BLOCK = 2.0             # s; errors further apart than this count as independent
USUAL = 95.0            # percentile up to which sizes are usual
_STEPPING = 0.9         # share of them that lies where the controller steps
_WRITTEN = 1e-6         # of the largest value: what a format may round off

# By unit: what is beyond it is a slip of the unit or a fault code, not a hydraulic drive.
_IMPOSSIBLE = {'V': 1e3, 'rpm': 1e5, 'degC': 1e3, 'bar': 1e4, 'L/min': 1e6, 'N.m': 1e8,
               'cc/rev': 1e6, 'kW': 1e6}


@dataclass(frozen=True)
class Run:
    """
    One recording.

    Attributes
    ----------
    name : str
        Short name for tables.
    time : ndarray, shape (n,)
        Seconds, strictly rising.
    channels : dict of str to ndarray, shape (n,)
        SI values by the names of ``CHANNELS``; NaN where a sample is missing.
    source : str
        Where it came from.
    notes : tuple of str
        What the reader should know: repaired, left out, guessed.

    """

    name: str
    time: np.ndarray
    channels: dict[str, np.ndarray]
    source: str = ''
    notes: tuple[str, ...] = field(default=())

    def __contains__(self, name: str) -> bool:
        return name in self.channels

    def __getitem__(self, name: str) -> np.ndarray:
        return self.channels[name]

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def sample_time(self) -> float:
        """Median time between samples, s."""
        return float(np.median(np.diff(self.time)))

    def between(self, start: float, end: float) -> Run:
        """Return the part with ``start <= time < end`` (s), of the channels with numbers there."""
        keep = (self.time >= start) & (self.time < end)
        channels = {name: values[keep] for name, values in self.channels.items()}
        off = [name for name, values in channels.items() if not np.isfinite(values).any()]
        return Run(self.name, self.time[keep],
                   {name: values for name, values in channels.items() if name not in off},
                   self.source, (*self.notes, *(
                       f'{name}: no numbers from {start:g} to {end:g} s; left out'
                       for name in off)))

    def slower(self, sample_time: float) -> Run:
        """
        Return the recording with samples about ``sample_time`` (s) apart, or itself.

        Signals are averaged about each sample that is kept. Samples are kept where the controller
        steps, at up to a quarter longer intervals, if the commands show where. Commands are
        averaged until the next sample, so that they come neither early nor late.
        """
        step = int(sample_time / self.sample_time + 1e-6)
        if step < 2:
            return self
        step, first = self._stepping(range(step, step + step // 4 + 1)) or (step, 0)
        half = (step - 1) // 2
        kept = np.arange(first, len(self), step)
        kept = kept[(kept >= half) & (kept + max(half + 1, step) <= len(self))]
        if len(kept) < 2:
            return self     # too short for a time between samples
        around = kept[:, None] + np.arange(-half, half + 1)
        after = kept[:, None] + np.arange(step)
        channels = {name: _mean(values[
            after if name in CHANNELS and CHANNELS[name].hold == 'zero' else around])
            for name, values in self.channels.items()}
        return Run(self.name, self.time[around].mean(axis=1), channels, self.source, self.notes)

    def _stepping(self, steps: range) -> tuple[int, int] | None:
        """Return every how many samples, and from which one, commands change; None if unclear."""
        changes = [np.flatnonzero(np.diff(values)) + 1 for name, values in self.channels.items()
                   if name in CHANNELS and CHANNELS[name].hold == 'zero']
        rows = np.concatenate([*changes, np.zeros(0, dtype=int)])
        counts = {step: np.bincount(rows % step, minlength=step) for step in steps}
        best = max(counts, key=lambda step: counts[step].max())
        if len(rows) < FEWEST or counts[best].max() < _STEPPING * len(rows):
            return None
        return best, int(counts[best].argmax())


def _mean(values: np.ndarray) -> np.ndarray:
    """Return the mean of each row's numbers, exact where they are alike; NaN without any."""
    there = np.isfinite(values)
    mean = np.where(there, values, 0.0).sum(axis=1) / np.maximum(there.sum(axis=1), 1)
    return np.clip(mean, np.fmin.reduce(values, axis=1), np.fmax.reduce(values, axis=1))


def shifted(signals: Mapping[str, np.ndarray],
            by: Mapping[str, np.ndarray | float]) -> dict[str, np.ndarray]:
    """Return signals with something added to some of them; the others are the same arrays."""
    return {**signals, **{name: signals[name] + shift for name, shift in by.items()
                          if name in signals}}


def zeroed(signals: Mapping[str, np.ndarray],
           zeros: Mapping[str, float]) -> dict[str, np.ndarray]:
    """Return what sensors would read with their zeros right."""
    return shifted(signals, {name: -zero for name, zero in zeros.items()})


def usual_size(values: np.ndarray) -> float:
    """Return up to which size values usually are; 0 without any."""
    known = np.abs(values[np.isfinite(values)])
    return float(np.percentile(known, USUAL)) if len(known) else 0.0


def same_recording(one: Run, other: Run) -> bool:
    """Say whether two files hold one recording: the same readings, in whatever format."""
    common = one.channels.keys() & other.channels.keys()
    return (len(one) == len(other) and any(CHANNELS[name].hold == 'linear' for name in common)
            and _alike(one.time - one.time[0], other.time - other.time[0])
            and all(_alike(one[name], other[name]) for name in common))


def _alike(one: np.ndarray, other: np.ndarray) -> bool:
    """Say whether values are the same but for how they were written down."""
    largest = float(np.max(np.abs(one), initial=0.0, where=np.isfinite(one)))
    return bool(np.allclose(one, other, rtol=0.0, atol=_WRITTEN * largest, equal_nan=True))


def refuse_impossible(run: Run) -> None:
    """
    Raise InputError if a channel holds numbers that no hydraulic drive has.

    It names channel, value and time.
    """
    for name, values in run.channels.items():
        unit = CHANNELS[name].display
        shown = from_si(values, unit)
        bad = np.flatnonzero(np.abs(shown) > _IMPOSSIBLE[unit])
        if len(bad):
            raise InputError(
                f'{run.source}: {name} is {shown[bad[0]]:.4g} {unit} at {run.time[bad[0]]:g} s '
                f'({len(bad)} of {len(values)} samples lie beyond {_IMPOSSIBLE[unit]:g} {unit}); '
                'check its unit, or leave the cells of faulty samples empty')
