# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Replay of a log of a circuit: measured signals in the place of the states that they tell.

What the equations then say of the other signals is compared with those, balance by balance, in
the weak form that ``PartReplay`` has for rates.
"""
from __future__ import annotations

from hst_drive.effects import catalogue
from hst_drive.errors import InputError
from hst_drive.measure.balances import is_table
from hst_drive.measure.part import PartReplay
from hst_drive.measure.readings import filled
from hst_drive.measure.replay import Prediction
from hst_drive.measure.run import CHANNELS, Run
from hst_drive.model.circuit_model import CircuitModel
from hst_drive.model.circuits import Balance, Part
from hst_drive.model.part import PartModel
import numpy as np
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

_SETTLES = 2.0      # s before the first row in which the actuator settles on its command
_CHANGES = 0.1      # s before and after what a balance hangs on that are not judged
_STEADY = 0.03      # s, over which a speed is smoothed at least that may have been read late
_SIZE = 95.0        # percentile of a reading's size
_SMALL = 0.05       # of the lag of what moves pump or valve: another one in series with it
_FEW = 0.02         # of the rows: a signal that is judged in fewer is not
# Sensors that are off: the slot of the term by the signal that it is added to.
_READINGS = {'line_a_pressure': ('pressure_reading', 'pressure'),
             'motor_inlet_flow': ('flow_reading', 'flow'),
             'motor_torque': ('torque_reading', 'load_torque')}


class CircuitReplay(PartReplay):
    """
    A log of a circuit, ready to be predicted by models again and again; see ``PartReplay``.

    Raises
    ------
    InputError
        If no balance of the circuit is closed, or the rows are operating points.

    """

    pressures = ('line_a_pressure', 'line_b_pressure')

    def __init__(self, run: Run, model: CircuitModel):
        self._by_name: dict[str, Balance] = {
            entry.name: entry for entry in model.circuit.balances}
        self._judged: dict[str, np.ndarray] = {}
        self._ratio: np.ndarray | None = None
        super().__init__(run, model)
        if 'oil_temperature' in self._channels:
            self._ratio = model.viscosity_ratio(self._channels['oil_temperature'])
        self.doubts = self._doubts(model)

    def place(self, name: str) -> Balance:
        """Return the balance of that name."""
        return self._by_name[name]

    def _doubts(self, model: CircuitModel) -> dict[str, np.ndarray]:
        """Return what another start and another small lag of pump or valve would do."""
        known, moved, time = self._channels, model.circuit.states[0].name, self.run.time
        if moved in known:
            return {}
        settled, at_rest = (self._evaluated(model, known, before=before)[moved]
                            for before in (_SETTLES, 1e-3 * _SETTLES))
        late, found = np.interp(time - _SMALL * model.steps[1], time, settled), []
        for values in (settled, late, at_rest):
            self._channels = {**known, moved: values}
            found.append(self.predict(model).signals)
        self._channels = known
        return {name: np.hypot(values - found[1][name], values - found[2][name])
                for name, values in found[0].items()}

    def _closed(self, run: Run, model: PartModel) -> dict[str, str]:
        assert isinstance(model, CircuitModel)
        if is_table(run):
            raise InputError(
                f'{run.source}: its rows are operating points, {run.sample_time:.3g} s apart; '
                f"'circuit: {model.circuit.id}' needs a recording with 20 rows a second or more")
        found, lacks = {}, []
        for balance in model.circuit.balances:
            missing = [need.replace('|', ' or ') for need in (balance.signal, *balance.needs)
                       if not any(name in run for name in need.split('|'))]
            if not missing:
                found[balance.signal] = balance.name
            lacks.append((len(missing), f'{balance.name} lacks {", ".join(missing)}'))
        if not found:
            have = ', '.join(run.channels) or 'none but time'
            least = '; '.join(text for _, text in sorted(lacks)[:3])
            raise InputError(
                f"{run.source}: its channels ({have}) close no balance of 'circuit: "
                f"{model.circuit.id}': {least}; name foreign columns with --channels")
        rows = {name: self._where(run, model, balance) for name, balance in found.items()}
        judged = {name: found[name] for name, where in rows.items()
                  if np.mean(where) > _FEW} or found
        self._judged = {name: rows[name] for name in judged}
        return judged

    def _where(self, run: Run, model: CircuitModel, name: str) -> np.ndarray:
        """Say in which rows a balance is judged: what it hangs on is true."""
        needed = [part.when for part in self._by_name[name].parts]
        if not all(needed):
            return np.ones(len(run), dtype=bool)
        known = {key: filled(values, hold=CHANNELS[key].hold == 'zero')
                 for key, values in run.channels.items()}
        told = {entry.name: known[entry.name] for entry in model.circuit.states
                if entry.name in known}
        found = model.run(run.time - run.time[0], known, told)
        simple = np.any([found[when] >= 1.0 for when in needed], axis=0)
        # No moment may pass unseen in which the equations jump.
        width = 2 * int(_CHANGES / run.sample_time) + 1
        return minimum_filter1d(simple.astype(np.int8), width) > 0

    def _unjudged(self, name: str) -> np.ndarray | bool:
        balance = self._by_name[self.balances[name]]
        if balance.enters == 'torque' and any(part.state for part in balance.parts):
            creeps = np.abs(self._channels['motor_speed']) <= self._creeping
            return creeps | ~self._judged[name]
        return ~self._judged[name]

    def _rate_gain(self, name: str, model: PartModel) -> tuple[float, str]:
        part = self._by_name[self.balances[name]].parts[0]
        if not part.state:
            return 0.0, ''
        found = self._evaluated(model, self._channels)
        return float(np.median(np.abs(found[part.storage][self._judged[name]]))), part.state

    def _width(self, name: str, model: PartModel) -> float:
        width = super()._width(name, model)
        return max(width, _STEADY / self.run.sample_time) if name == 'motor_speed' else width

    def _behind(self, model: PartModel, channels: dict[str, np.ndarray]) -> np.ndarray | float:
        """Return by how much the shaft is ahead of the reading of its speed, rad/s."""
        first, second = (model.terms(f'speed_reading{kind}_lag', {}) for kind in ('', '_series'))
        if not first + second or 'motor_speed' not in channels:
            return 0.0
        step = self.run.sample_time
        width = self._widths.get('motor_speed', 0.0) or _STEADY / step
        rate, bend = (gaussian_filter1d(channels['motor_speed'], width, order=order,
                                        mode='nearest') / step**order for order in (1, 2))
        # Two first-order lags in series: reading + (a + b) reading' + a b reading'' = shaft.
        return (first + second) * rate + first * second * bend

    def _true(self, model: PartModel, channels: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return channels as they are where a sensor reads something else."""
        true = dict(channels)
        for name in ('line_a_pressure', 'motor_speed'):
            if name in true:
                true[name] = true[name] - self._reading(model, channels, name, true[name])
        return true

    def _evaluated(self, model: PartModel, true: dict[str, np.ndarray], *,
                   free: str = '', before: float = _SETTLES) -> dict[str, np.ndarray]:
        """Return the quantities with all measured states in place but ``free``."""
        assert isinstance(model, CircuitModel)
        if self._ratio is not None:
            true = {**true, 'viscosity_ratio': self._ratio}
        told = {entry.name: true[entry.name] for entry in model.circuit.states
                if entry.name in true and entry.name != free}
        if 'motor_angle' in self.inputs:
            told['motor_angle'] = self.inputs['motor_angle']
        # A row before the first one, from which what is not told settles.
        time = np.concatenate([[self.run.time[0] - before], self.run.time])
        found = model.run(time, _earlier(true), _earlier(told))
        return {key: values[1:] for key, values in found.items()}

    def predict(self, model: PartModel, extra: dict[str, np.ndarray] | None = None) -> Prediction:
        """Predict each signal from the others; see ``PartReplay.predict``."""
        channels = self._channels if extra is None else {
            name: values + extra.get(name, 0.0) for name, values in self._channels.items()}
        true = self._true(model, channels)
        found = self._evaluated(model, true)
        signals = {}
        for signal, name in self.balances.items():
            quantities = found
            if any(part.quantity == signal and signal in channels
                   for part in self._by_name[name].parts) and signal in {
                       entry.name for entry in model.circuit.states}:
                # A state that is measured, too: what it would do by itself.
                quantities = self._evaluated(model, true, free=signal)
            value = self._combined(self._by_name[name].parts, quantities, true, signal)
            signals[signal] = value + self._reading(model, channels, signal, value)
        return Prediction(signals, np.zeros(len(self.run)))

    def _reading(self, model: PartModel, channels: dict[str, np.ndarray], signal: str,
                 value: np.ndarray) -> np.ndarray | float:
        """Return what effects of its sensor add to a signal."""
        if signal == 'motor_speed':
            return -self._behind(model, channels)
        slot, reads = _READINGS.get(signal, ('', ''))
        if not any(place == slot for name in model.effects
                   for place, _ in catalogue(everything=True)[name].terms):
            return 0.0
        return model.terms(slot, {**model.complete(channels), reads: value})

    def floor(self, model: PartModel, seed: int = 0) -> dict[str, float]:
        """Return the rmse that the best model would show: sensors' noise, and its sheet's."""
        found = super().floor(model, seed)
        for name, noise in found.items():
            size = np.abs(self.run[name][self.counted(name)])
            if len(size):
                found[name] = float(np.hypot(
                    noise, self._by_name[self.balances[name]].sheet * np.percentile(size, _SIZE)))
        return found

    def _combined(self, parts: tuple[Part, ...], found: dict[str, np.ndarray],
                  channels: dict[str, np.ndarray], signal: str) -> np.ndarray:
        chosen = np.zeros(len(self.run), dtype=int)
        for place, part in enumerate(parts[1:], 1):
            chosen[found[part.when] >= 1.0] = place
        value = self._smooth(np.choose(chosen, [found[part.quantity] for part in parts]), signal)
        stored = np.zeros(len(self.run))
        for place, part in enumerate(parts):
            if part.state and part.state in channels:
                storage = np.where(chosen == place, found[part.storage], 0.0)
                stored[1:] += np.cumsum(0.5 * (storage[1:] + storage[:-1])
                                        * np.diff(channels[part.state]))
        # Summed before it is smoothed: the lines may change their parts at any row.
        stored += found[parts[0].turns] if parts[0].turns else 0.0
        return value - self._rate(stored, signal)


def _earlier(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return channels with their first row repeated before them."""
    return {name: np.concatenate([row[:1], row]) for name, row in values.items()}


def part_replay(run: Run, model: PartModel) -> PartReplay:
    """Return the replay of a log that goes with a model (``part_model``)."""
    return CircuitReplay(run, model) if isinstance(model, CircuitModel) else PartReplay(
        run, model)
