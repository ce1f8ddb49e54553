# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Replay of a recording through one model that stays as it is: what was computed is not done again.

Estimating the noise, the error, the delays and the floor all ask for the same simulation. And the
floor of a long recording is a mean over far more of it than is needed: stretches will do.
"""
from __future__ import annotations

from typing import Iterator, Mapping

from hst_drive.channels import COMMANDS
from hst_drive.measure.pieces import simulate_in_pieces
from hst_drive.measure.readings import filled
from hst_drive.measure.replay import Replay, SIGNALS
from hst_drive.measure.start import first_state
from hst_drive.model import Drive
import numpy as np

_KEEP = 2               # simulations
LONG = 600.0            # s; up to it the whole recording is drawn
_STRETCHES = 10
_STRETCH = 60.0         # s
_SETTLED = 5.0          # s after which the start of a stretch is forgotten


class KeptReplay(Replay):
    """A ``Replay`` that simulates nothing twice: for comparing, where the model stays."""

    def __init__(self, run, drive: Drive):
        self._kept: list[tuple[tuple, np.ndarray, dict[str, np.ndarray]]] = []
        self._keeping = False
        self._load: tuple = ((), None, None)    # of the measured speed
        self._whole = {name: filled(run[name]) for name in SIGNALS if name in run}
        super().__init__(run, drive)

    def turn(self, angle: float) -> None:
        super().turn(angle)
        self._kept, self._load = [], ((), None, None)

    def predict(self, drive: Drive, extra: np.ndarray | None = None,
                commands: Mapping[str, np.ndarray] = {}) -> dict[str, np.ndarray]:
        self._keeping = extra is None and not commands
        return super().predict(drive, extra, commands)

    def _simulate(self, drive: Drive, disturbance: np.ndarray,
                  commands: Mapping[str, np.ndarray] = {},
                  extra: np.ndarray | None = None) -> dict[str, np.ndarray]:
        if not self._keeping:
            return super()._simulate(drive, disturbance, commands, extra)
        key = self._key(drive)
        for known, added, signals in self._kept:
            if known == key and np.array_equal(added, disturbance):
                return dict(signals)
        signals = super()._simulate(drive, disturbance)
        # Only what is measured is asked for again; the rest need not fill the memory.
        wanted = {*self.signals, 'motor_speed'}
        signals = {name: np.array(values) for name, values in signals.items() if name in wanted}
        self._kept = [*self._kept[1 - _KEEP:], (key, disturbance, signals)]
        return dict(signals)

    def _key(self, drive: Drive) -> tuple:
        return id(drive), self._between, drive.parameters.tobytes(), drive.switches.tobytes()

    def _load_model(self, drive: Drive, speed: np.ndarray | None = None) -> np.ndarray:
        if speed is not None:
            return super()._load_model(drive, speed)
        key, speed, load = self._load
        if speed is not self._speed or key != self._key(drive):
            load = super()._load_model(drive)
            self._load = self._key(drive), self._speed, load
        return load

    def shaken(self, drive: Drive, count: np.ndarray | None) -> Iterator[dict[str, float]]:
        time = self.run.time
        if time[-1] - time[0] <= LONG or drive.has_flexible_shaft:
            yield from super().shaken(drive, count)
            return
        disturbance = self._between.finer(self.disturbance(drive))
        added = disturbance + self._finely().draw_error(np.random.default_rng(0))
        counted = np.ones(len(time), dtype=bool) if count is None else count
        squares: dict[str, list[np.ndarray]] = {name: [] for name in self.signals}
        starts = np.linspace(time[0], time[-1] - _STRETCH, _STRETCHES)
        for first, last in zip(np.searchsorted(time, starts),
                               np.searchsorted(time, starts + _STRETCH)):
            part = slice(first, last)
            base, moved = (self._stretch(drive, part, values) for values in (disturbance, added))
            use = counted[part] & (time[part] >= time[first] + _SETTLED)
            for name in self.signals:
                squares[name].append((moved[name] - base[name])[use]**2)
        yield {name: float(np.nanmean(np.concatenate(parts)))
               for name, parts in squares.items() if name != self.torque}

    def _motion(self, drive: Drive, time: np.ndarray,
                inputs: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        if time[-1] - time[0] <= LONG or not drive.kernel.compiled:
            return super()._motion(drive, time, inputs)
        return simulate_in_pieces(drive, time, inputs, self.start(drive),
                                  lambda row: self._state(drive, row // self._between.steps))

    def _state(self, drive: Drive, row: int) -> np.ndarray:
        """Return the state that the signals show at a row."""
        first = {name: float(self._whole[name][row]) for name in self.signals}
        return first_state(drive, first, {name: float(values[row])
                                          for name, values in self.inputs.items()}, self.torque)

    def _stretch(self, drive: Drive, part: slice,
                 disturbance: np.ndarray) -> dict[str, np.ndarray]:
        """Return the signals of some rows alone, from the state that their first one shows."""
        steps = self._between.steps
        inputs = {name: self._between.finer(values[part], name in COMMANDS)
                  for name, values in self.inputs.items()}
        inputs['load_disturbance'] = disturbance[part.start * steps:(part.stop - 1) * steps + 1]
        signals = drive.simulate(self._between.finer(self.run.time[part]), inputs,
                                 self._state(drive, part.start))
        return {name: self.readings.as_read(name, self._between.at_rows(signals[name]), part)
                for name in self.signals}
