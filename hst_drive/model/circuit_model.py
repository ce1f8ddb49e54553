# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A circuit with a rig's numbers: what moves in time, and what follows from measured signals."""
from __future__ import annotations

import math
from typing import Iterable, Mapping

from hst_drive.errors import InputError
from hst_drive.model.circuit_code import code_of
from hst_drive.model.circuits import circuit_of
from hst_drive.model.parameters import cells_of
from hst_drive.model.part import PartModel
from hst_drive.rig import Rig
import numpy as np

MAX_STEP, LEAST_STEP = 2.5e-3, 2e-5     # s
_TOLD_STEP = 10e-3  # s, where all that is fast is measured


class CircuitModel(PartModel):
    """
    A rig of any circuit but the open one, effects that are on, factors of this unit.

    Parameters
    ----------
    rig, effects, factors
        As for ``PartModel``.
    compiled : bool, optional
        Force numba (True) or plain Python (False).

    Raises
    ------
    InputError
        If the circuit, an effect or a parameter is not known, or a section of the rig is missing.

    """

    def __init__(self, rig: Rig, effects: Mapping[str, Mapping[str, float]] | None = None,
                 factors: Mapping[str, float] | None = None, *, compiled: bool | None = None):
        super().__init__(rig, effects, factors)
        self.circuit = circuit_of(rig)
        self._numbers = self.circuit.parameters(rig)
        self.steps = self.circuit.steps(self._numbers)
        if self.steps[0] < LEAST_STEP:
            raise InputError(
                f"{rig.source}: 'circuit: {rig.circuit}' would need integration steps of "
                f'{self.steps[0]:.1g} s, expected {LEAST_STEP:g} s or more; check the volume of '
                'the line, the lags, the check valve and the override of the relief valve')
        self.code = code_of(self.circuit, tuple(self._numbers), compiled)
        self._tables = cells_of([table(rig) for table in self.circuit.tables.values()])

    def enters(self, name: str) -> bool:
        """Say whether an effect has a term in this circuit's equations."""
        return name in self.code.usable

    def parameter(self, name: str) -> float:
        """Return a number of the equations, SI, for this unit."""
        scaled = self.circuit.scaled.items()
        return self._numbers[name] * math.prod(
            self.factors.get(key, 1.0) / self.rig.calibration.get(key, 1.0)
            for key, scales in scaled if scales == name)

    def run(self, time: np.ndarray, channels: Mapping[str, np.ndarray],
            told: Mapping[str, np.ndarray], state: np.ndarray | None = None, *,
            memory: np.ndarray | None = None, max_step: float | None = None,
            ) -> dict[str, np.ndarray]:
        """
        Evaluate the equations over a record; integrate what is not told.

        Parameters
        ----------
        time : ndarray, shape (n,)
            s, strictly rising.
        channels : mapping of str to ndarray, shape (n,)
            Inputs by channel, SI; one that is left out has its default. 'viscosity_ratio'
            follows from 'oil_temperature' if it is not given.
        told : mapping of str to ndarray, shape (n,)
            States that are measured, SI.
        state, memory : ndarray, optional
            Where to start, and what the actuator remembers; at the end they hold the last ones.
        max_step : float, optional
            Longest integration step, s.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            States that were integrated and quantities (``Circuit.quantities``), SI.

        """
        circuit, n = self.circuit, len(time)
        known = {'oil_temperature': self.rig.characterised_at, **channels}
        if circuit.complete:
            known.update(circuit.complete(self.rig, {**channels, **told}))
        if 'viscosity_ratio' not in known:
            known['viscosity_ratio'] = self.rig.viscosity_ratio(known['oil_temperature'])
        work = np.zeros((25, max(len(circuit.states), circuit.held, len(circuit.inputs),
                                 len(circuit.quantities))))
        work[-1, :len(circuit.states)] = [entry.least for entry in circuit.states]
        columns, varied = [], []
        for index, entry in enumerate(circuit.inputs):
            value = known.get(entry.name, entry.default)
            if np.ndim(value):
                columns.append(value)
                varied.append(index)
            else:
                work[0, index] = value
        inputs = np.column_stack(columns).astype(float) if columns else np.empty((n, 0))
        commands = np.column_stack([np.broadcast_to(known.get(entry.name, entry.default), n)
                                    for entry in circuit.held_inputs]).astype(float)
        record = np.empty((n, len(circuit.states)))
        mask = np.zeros(len(circuit.states), dtype=np.int8)
        values, switches = self.code.vectors(
            [self.parameter(name) for name in self._numbers], self.effects)
        for index, entry in enumerate(circuit.states):
            if entry.name in told:
                record[:, index], mask[index] = told[entry.name], 1
            elif entry.moved_by and not switches[self.code.slots[entry.moved_by]]:
                record[:, index], mask[index] = self.parameter(entry.start), 1
        if state is None:
            state = self.at_rest()
        if memory is None:
            memory = np.full(circuit.memory, math.nan)
        out = np.empty((n, len(circuit.quantities)))
        if max_step is None:
            fast = any(entry.unit == 'Pa' for entry in circuit.states if entry.name not in told)
            max_step = MAX_STEP if fast else min(self.steps[1], _TOLD_STEP)
        cells, layout = self._tables
        self.code.module.run(np.ascontiguousarray(time, dtype=float), commands, inputs,
                             np.array(varied, dtype=np.int64), mask, record, state, memory,
                             values, switches, cells, layout.copy(), max_step, work, out)
        found = {name: out[:, index] for index, name in enumerate(circuit.quantities)}
        return {**{entry.name: record[:, index] for index, entry in enumerate(circuit.states)},
                **found}

    def at_rest(self) -> np.ndarray:
        """Return the state of a drive at rest."""
        return np.array([self.parameter(entry.start) if entry.start else 0.0
                         for entry in self.circuit.states])


def part_model(rig: Rig) -> PartModel:
    """Return the model that judges a log balance by balance: of its circuit, or of a part."""
    return PartModel(rig) if circuit_of(rig) is None else CircuitModel(rig)


def refuse_placeless(model: PartModel, names: Iterable[str]) -> None:
    """Raise InputError if an effect has no place in the equations of a rig's circuit."""
    rig = model.rig
    for name in names:
        if not model.enters(name):
            raise InputError(f"effect '{name}': has no place in 'circuit: {rig.circuit}' of "
                             f'{rig.source or rig.name}; leave it out')
