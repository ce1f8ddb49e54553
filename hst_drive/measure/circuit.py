# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Replay of a log of a circuit: measured signals in the place of the states that they tell.

What the equations then say of the other signals is compared with those, balance by balance, in
the weak form that ``PartReplay`` has for rates.
"""
from __future__ import annotations

from typing import Any

from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.measure.balances import is_table, lacking, what_would_close
from hst_drive.measure.circuit_balances import CHANGES, SETTLES, tell
from hst_drive.measure.commands import Between, HELD
from hst_drive.measure.part import NARROW, PartReplay
from hst_drive.measure.readings import filled
from hst_drive.measure.replay import Replay
from hst_drive.measure.run import Run
from hst_drive.model import Drive
from hst_drive.model.circuit_model import CircuitModel
from hst_drive.model.circuits import Balance
from hst_drive.model.part import PartModel
import numpy as np
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

_STEADY = 0.03      # s, over which a speed is smoothed at least that may have been read late
_SLOW_ROWS = 0.07   # s: fewer rows than are asked for (20 a second)
_SMALL = 0.05       # of the lag of what moves pump or valve: another one in series with it
_FEW = 0.02         # of the rows: a signal that is judged in fewer is not


class CircuitReplay(PartReplay):
    """
    A log of a circuit, ready to be predicted by models again and again; see ``PartReplay``.

    InputError is raised if no balance of it is closed, or the rows are operating points.
    """

    def __init__(self, run: Run, model: CircuitModel):
        self._judged: dict[str, np.ndarray] = {}
        super().__init__(run, model)
        between = Between.rows(model.rig, run.sample_time)
        course = self._fill_in(model, between) if between.steps > 1 else {}
        self.extra_std = {name: np.hypot(std, course.get(name, 0.0))
                          for name, std in self._extra_std(model).items()}

    def _fill_in(self, model: CircuitModel, between: Between) -> dict[str, np.ndarray]:
        """
        Let commands move between the rows of a slow record, unless held ones fit better.

        Return how far signals hang on which of the two it is (SI).
        """
        held = self._channels
        moving = {entry.name: between.mean_of_rows(held[entry.name])
                  for entry in model.circuit.held_inputs if entry.name in held}
        if not moving:
            return {}
        first = self.predict(model)
        self._channels = {**held, **moving}
        second = self.predict(model)
        if self._fast_misfit(first) < HELD * self._fast_misfit(second):
            self._channels = held
        return {name: np.abs(first[name] - second[name]) for name in self.signals}

    def _fast_misfit(self, found: dict[str, np.ndarray]) -> float:
        """Return the squared error from row to row, over what changes; slow errors are others'."""
        return sum(float(np.nanmean(np.diff(found[name] - self.run[name])**2)
                         / max(np.nanmean(np.diff(self.run[name])**2), 1e-30))
                   for name in self.signals)

    def _extra_std(self, model: CircuitModel) -> dict[str, np.ndarray]:
        """Return how far signals hang on the actuator's start, and on a small lag more (SI)."""
        known, moved, time = self._channels, model.circuit.states[0].name, self.run.time
        if moved in known:
            return {}
        settled, at_rest = (self._state(model, known, before)[moved]
                            for before in (SETTLES, 1e-3 * SETTLES))
        late, found = np.interp(time - _SMALL * model.steps[1], time, settled), []
        for values in (settled, late, at_rest):
            self._channels = {**known, moved: values}
            found.append(self.predict(model))
        self._channels = known
        return {name: np.hypot(values - found[1][name], values - found[2][name])
                for name, values in found[0].items()}

    def _closed(self, run: Run, model: PartModel) -> dict[str, Balance]:
        assert isinstance(model, CircuitModel)
        if is_table(run):
            raise InputError(
                f'{run.source}: its rows are operating points, {run.sample_time:.3g} s apart; '
                f"'circuit: {model.circuit.id}' needs a recording with 20 rows a second or more")
        found = {balance.signal: balance for balance in model.circuit.balances
                 if not lacking(balance, run, model.rig)}
        if not found:
            raise InputError(what_would_close(run, model.rig, model.circuit.balances))
        rows = {name: self._where(run, model, balance) for name, balance in found.items()}
        judged = {name: found[name] for name, where in rows.items()
                  if np.mean(where) > _FEW} or found
        self._judged = {name: rows[name] for name in judged}
        return judged

    def _where(self, run: Run, model: CircuitModel, balance: Balance) -> np.ndarray:
        """Say in which rows a balance is judged: what it hangs on is true."""
        needed = balance.conditions
        if not needed:
            return np.ones(len(run), dtype=bool)
        known = {key: filled(values, hold=CHANNELS[key].hold == 'zero')
                 for key, values in run.channels.items()}
        told = {entry.name: known[entry.name] for entry in model.circuit.states
                if entry.name in known}
        found = model.run(run.time - run.time[0], known, told)
        simple = np.any([found[when] >= 1.0 for when in needed], axis=0)
        # No moment may pass unseen in which the equations jump.
        width = 2 * int(CHANGES / run.sample_time) + 1
        return minimum_filter1d(simple.astype(np.int8), width) > 0

    def _unjudged(self, name: str) -> np.ndarray | bool:
        balance = self.balances[name]
        if balance.enters == 'torque' and any(part.state for part in balance.parts):
            creeps = np.abs(self._channels['motor_speed']) <= self._creeping
            return creeps | ~self._judged[name]
        return ~self._judged[name]

    def _rate_gain(self, name: str, model: PartModel) -> tuple[float, str]:
        part = self.balances[name].parts[0]
        if not part.state:
            return 0.0, ''
        found = self._state(model, self._channels)
        return float(np.median(np.abs(found[part.storage][self._judged[name]]))), part.state

    def _width(self, name: str, model: PartModel) -> float:
        width = super()._width(name, model)
        return max(width, _STEADY / self.run.sample_time) if name == 'motor_speed' else width

    def _behind(self, model: PartModel, channels: dict[str, np.ndarray]) -> np.ndarray | float:
        """Return by how much the reading of the speed is behind the shaft, rad/s."""
        first, second = (model.terms(f'speed_reading{kind}_lag', {}) for kind in ('', '_series'))
        if not first + second or 'motor_speed' not in channels:
            return 0.0
        # Two first-order lags in series: reading + (a + b) reading' + a b reading'' = shaft. What
        # is compared is smoothed once, this with it.
        rate = np.gradient(channels['motor_speed'], self.run.time)
        return (first + second) * rate + first * second * np.gradient(rate, self.run.time)

    def _state(self, model: PartModel, channels: dict[str, np.ndarray],
               before: float = SETTLES) -> dict[str, Any]:
        assert isinstance(model, CircuitModel)
        behind = ahead = self._behind(model, channels)
        if np.ndim(behind) and self.run.sample_time > _SLOW_ROWS:
            # These tell no rate by themselves.
            ahead = gaussian_filter1d(behind, NARROW, mode='nearest')
        return {**tell(model, channels, self.run.time, self.inputs.get('motor_angle'), ahead,
                       before), 'behind': behind}


def replay_of(run: Run, model: Drive | PartModel) -> Replay | PartReplay:
    """Return the replay of a log that goes with a model."""
    kind = (Replay if isinstance(model, Drive) else
            CircuitReplay if isinstance(model, CircuitModel) else PartReplay)
    return kind(run, model)
