# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the balances of any circuit predict, for logs and for the watch.

Measured signals stand in the place of the states that they tell; what the equations then say of
the other signals is compared with those.
"""
from __future__ import annotations

import math
from typing import Any, Container, Mapping

from hst_drive.channels import LINES
from hst_drive.effects import effect_of
from hst_drive.measure.balances import BALANCES, lacking
from hst_drive.measure.equations import measured_state, Weak
from hst_drive.model import circuits
from hst_drive.model.circuit_model import CircuitModel
from hst_drive.model.circuits import Balance
from hst_drive.model.part import Known, PartModel
from hst_drive.rig import Rig
from hst_drive.rig.rig import OPEN
import numpy as np

_STEP = 0.5         # of the actuator's lag, while the drive runs
CHANGES = 0.1        # s before and after what a balance hangs on that are not judged
SETTLES = 2.0       # s before the first row in which the actuator settles on its command
# Sensors that are off: the slot of the term by the signal that it is added to.
_READINGS = {'pump_displacement': ('displacement_at_once', 'displacement'),
             'line_a_pressure': ('pressure_reading', 'pressure'),
             'motor_inlet_flow': ('flow_reading', 'flow'),
             'motor_torque': ('torque_reading', 'load_torque')}


def watched(signals: Container[str], rig: Rig) -> dict[str, Balance]:
    """Return the balances, by id, that some signals close while the drive runs."""
    return {entry.id or entry.signal: entry for entry in balances_of(rig)
            if (entry.id or rig.circuit != OPEN) and not lacking(entry, signals, rig)}


def balances_of(rig: Rig) -> tuple[Balance, ...]:
    """Return all balances that logs of a rig, or of a part of it, may close."""
    circuit = circuits.circuit_of(rig)
    return circuit.balances if circuit else tuple(BALANCES.values())


def read_instead(model: PartModel) -> tuple[str, ...]:
    """Return the channels that stand, where they are measured, for what is modelled."""
    return tuple(entry.name for entry in model.circuit.inputs if math.isnan(entry.default)
                 ) if isinstance(model, CircuitModel) else ()


def predicted(balance: Balance, model: PartModel, known: Known, channels: Known, weak: Weak
              ) -> Any:
    """Return what a sensor would read by a balance; ``known`` as of ``circuit_state``."""
    if balance.equation:
        return balance.equation(model, known, channels, weak)
    assert isinstance(model, CircuitModel)
    return _by_parts(balance, model, known, channels, weak)


def circuit_state(model: PartModel, channels: Mapping[str, np.ndarray], time: np.ndarray,
                  creeping: float, angle: np.ndarray | None) -> dict[str, Any]:
    """Return what the equations of any circuit may read (``measured_state``, ``tell``)."""
    if not isinstance(model, CircuitModel):
        return measured_state(model, channels, creeping, angle)
    return tell(model, channels, time, angle, max_step=_STEP * model.steps[1])


def tell(model: CircuitModel, channels: Mapping[str, np.ndarray], time: np.ndarray,
         angle: np.ndarray | None = None, ahead: np.ndarray | float = 0.0,
         before: float = SETTLES, max_step: float | None = None) -> dict[str, Any]:
    """
    Return what the equations say with all measured states in place.

    Parameters
    ----------
    model : CircuitModel
        The model.
    channels : mapping of str to ndarray
        Readings, SI.
    time : ndarray
        s.
    angle : ndarray, optional
        Of the hydromotor's shaft, rad.
    ahead : ndarray or float
        By how much the shaft is ahead of the reading of its speed, rad/s.
    before : float
        How long (s) before the first row what is not told settles.
    max_step : float, optional
        Longest integration step, s.

    Returns
    -------
    dict
        Quantities and states; 'viscosity_ratio'; 'true': the channels as they are where a sensor
        reads something else; 'without', which evaluates with one measured state free.

    """
    true = dict(channels)
    if 'motor_speed' in true:
        true['motor_speed'] = true['motor_speed'] + ahead
    for name in ('line_a_pressure', 'pump_displacement'):
        if name in true:
            true[name] = true[name] - misread(model, true, name, true[name])
    ratio = true.setdefault('viscosity_ratio', model.rig.viscosity_ratio(true.get(
        'oil_temperature', np.full(len(time), model.rig.characterised_at))))
    states = [entry.name for entry in model.circuit.states]

    def without(free: str) -> dict[str, np.ndarray]:
        known = {name: true[name] for name in states if name in true and name != free}
        if angle is not None:
            known['motor_angle'] = angle
        # A row before the first one, from which what is not told settles.
        found = model.run(np.concatenate([[time[0] - before], time]), _earlier(true),
                          _earlier(known), max_step=None if free else max_step)
        return {name: values[1:] for name, values in found.items()}

    return {**without(''), 'viscosity_ratio': ratio, 'true': true, 'without': without}


def _earlier(values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return channels with their first row repeated before them."""
    return {name: np.concatenate([row[:1], row]) for name, row in values.items()}


def _by_parts(balance: Balance, model: CircuitModel, known: Known, channels: Known, weak: Weak
              ) -> Any:
    found, true, parts = known, known['true'], balance.parts
    if any(part.quantity == balance.signal for part in parts) and balance.signal in {
            entry.name for entry in model.circuit.states} & channels.keys():
        # A state that is measured, too: what it would do by itself.
        found = known['without'](balance.signal)
    chosen = np.zeros(len(found[parts[0].quantity]), dtype=int)
    for index, part in enumerate(parts[1:], 1):
        chosen[found[part.when] >= 1.0] = index
    value = weak.mean(np.choose(chosen, [found[part.quantity] for part in parts]))
    stored = np.zeros(len(chosen))
    for index, part in enumerate(parts):
        if part.state and part.state in true:
            storage = np.where(chosen == index, found[part.storage], 0.0)
            stored[1:] += np.cumsum(0.5 * (storage[1:] + storage[:-1])
                                    * np.diff(true[part.state]))
    # Summed before it is smoothed: the lines may change their parts at any row.
    stored += found[parts[0].turns] if parts[0].turns else 0.0
    value = value - weak.rate(stored)
    if balance.signal == 'motor_speed':
        return value - weak.mean(known.get('behind', 0.0))
    return value + misread(model, channels, balance.signal, value)


def misread(model: CircuitModel, channels: Known, signal: str, value: Any) -> Any:
    """Return what effects of its sensor, but a lag, add to a signal of this value."""
    slot, reads = _READINGS.get(signal, ('', ''))
    if not any(entry == slot for name in model.effects
               for entry, _ in effect_of(name).terms):
        return 0.0
    if {*LINES} <= channels.keys():
        channels = {**channels, 'pressure': channels[LINES[0]] - channels[LINES[1]]}
    return model.terms(slot, {**model.complete(channels), reads: value})
