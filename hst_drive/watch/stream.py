# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Signals as they come, laid on one time base.

Sensors and controllers stamp on their own; a message may be late, missing or NaN, and a bag that
is played again jumps back in time. What leaves this file is clean: finite samples of all
signals at the same, rising times, or the name of the signal that is missing.
"""
from __future__ import annotations

from bisect import bisect_left, bisect_right
import math
from typing import NamedTuple

from hst_drive.channels import CHANNELS
import numpy as np

BILLION = 1_000_000_000
_BACK = BILLION     # ns: a stamp that far back is a new start, a smaller step a late message


class Window(NamedTuple):
    """
    Samples of several signals at the same times; ``time`` in s from ``start`` (ns).

    Each is the mean of ``samples`` readings.
    """

    start: int
    time: np.ndarray
    values: dict[str, np.ndarray]
    samples: int = 1

    def thinned(self, rate: float) -> Window:
        """Return it with about so many samples a second (Hz) at the most."""
        count = len(self.time)
        step = round((count - 1) / (self.time[-1] - self.time[0]) / rate) if count > 1 else 1
        if step < 2:
            return self

        def mean(values: np.ndarray) -> np.ndarray:
            return values[count % step:].reshape(-1, step).mean(axis=1)

        return Window(self.start, mean(self.time), {
            name: mean(values) for name, values in self.values.items()}, step)


class Stream:
    """
    The last seconds of some signals.

    Parameters
    ----------
    names : tuple of str
        Channels; the first gives the time base.
    memory : float
        How far back samples are kept, s.
    timeout : float
        A signal with a longer gap is missing, s.

    Attributes
    ----------
    restarts : int
        How often time has jumped back; all that was known before is dropped then.

    """

    def __init__(self, names: tuple[str, ...], memory: float, timeout: float):
        self.names = names
        self.restarts = 0
        self._memory = round(memory * BILLION)
        self._patience = round(timeout * BILLION)
        self._keep = 4 * self._memory
        self.clear()

    def clear(self) -> None:
        """Forget all samples."""
        self._times: dict[str, list[int]] = {name: [] for name in self.names}
        self._values: dict[str, list[float]] = {name: [] for name in self.names}

    def put(self, name: str, stamp: int, value: float) -> bool:
        """
        Take a sample (ns, SI); return whether it counts.

        What is not finite counts as not sent, and so does a late or repeated message.
        """
        if not math.isfinite(value):
            return False
        times = self._times[name]
        if times:
            if stamp <= times[-1]:
                if stamp > times[-1] - _BACK:
                    return False
                self.clear()
                self.restarts += 1
                times = self._times[name]
            elif times[0] < stamp - self._keep:
                cut = bisect_left(times, stamp - self._memory)
                del times[:cut], self._values[name][:cut]
        times.append(stamp)
        self._values[name].append(value)
        return True

    def newest(self, name: str) -> int | None:
        """Return the time (ns) of the last sample of a signal."""
        times = self._times[name]
        return times[-1] if times else None

    def missing(self, names: tuple[str, ...], start: int, end: int) -> list[str]:
        """Return the signals that do not cover ``start`` to ``end`` (ns) without a gap."""
        return [name for name in names if self._gap(name, start, end)]

    def _gap(self, name: str, start: int, end: int) -> bool:
        times, patience = self._times[name], self._patience
        held = np.array(times[bisect_left(times, start - patience):bisect_right(times, end)])
        return (not len(held) or held[0] > start + patience or held[-1] < end - patience
                or bool(np.any(np.diff(held) > patience)))

    def window(self, names: tuple[str, ...], start: int, end: int) -> Window:
        """Return the samples from ``start`` up to ``end`` (ns) at the first signal's times."""
        base = self._times[self.names[0]]
        first, last = bisect_left(base, start), bisect_left(base, end)
        wanted = base[first:last]
        at = np.array(wanted, dtype=np.int64)
        found = {}
        for name in names:
            times, values = self._times[name], self._values[name]
            low, high = bisect_left(times, start), bisect_left(times, end)
            if times[low:high] == wanted:
                found[name] = np.array(values[low:high])
            elif CHANNELS[name].hold == 'zero':
                places = np.searchsorted(np.array(times), at, side='right') - 1
                found[name] = np.array(values)[np.maximum(places, 0)]
            else:
                found[name] = np.interp((at - start).astype(float),
                                        (np.array(times) - start).astype(float), values)
        return Window(start, (at - start) / BILLION, found)
