# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Losses of the hydromotor learnt while it runs, by operating range, with forgetting.

The range of pressure and speed is cut into buckets. Each holds the mean of what the motor loses
beyond its loss model, and forgets with every new block that falls into it; so what was seen at
80 bar is still there after an hour at 30 bar. A value is given only where buckets have been
filled: at their pressures and between them, never beyond.
"""
from __future__ import annotations

import math
from typing import NamedTuple

from hst_drive.channels import LINES
from hst_drive.measure.circuit_balances import tell
from hst_drive.model.circuit_model import CircuitModel
from hst_drive.model.part import PartModel
from hst_drive.watch.figures import losses
from hst_drive.watch.samples import Accuracy, SPEED
import numpy as np

_PRESSURE, _SPEED = 10e5, 2.0   # size of a bucket, Pa and rad/s
_FILLED = 3                     # blocks
_MOST = 1000                    # buckets; a drive has some hundred, a broken sensor any number
_SIGNIFICANT = 3.0              # standard uncertainties: less is no internal leakage


class Estimate(NamedTuple):
    """A value, what the rig's loss model gives, and the standard uncertainty (SI)."""

    value: float
    model: float | None
    uncertainty: float


class Resistances(NamedTuple):
    """
    Loss resistances of Eqs. (2) to (4) of the motor-loss paper, Pa.s/m^3.

    ``leakage`` is all leakage, ``P/(Q - D*w)``; ``external`` (R_el) and ``internal`` (R_2) are
    its parts, which only the case drain flow tells apart, else None. Eq. (3) is Eq. (2)
    rearranged, so pressure, flow, speed and torque alone do not determine them. ``port`` is
    R_1; without the case drain flow it hangs on the unknown split, by less than the slip.
    """

    leakage: Estimate
    port: Estimate
    external: Estimate | None = None
    internal: Estimate | None = None


class Characteristic:
    """
    What a hydromotor loses beyond its loss model, over pressure and speed.

    Parameters
    ----------
    model : PartModel
        The motor's loss model.
    accuracy : Accuracy
        Of the sensors.
    memory : float
        Blocks over which a bucket forgets.

    """

    def __init__(self, model: PartModel, accuracy: Accuracy = Accuracy(), memory: float = 30.0):
        self._model, self._accuracy, self._memory = model, accuracy, memory
        self._buckets: dict[tuple[int, int], np.ndarray] = {}
        self._counts: dict[tuple[int, int], int] = {}

    def add(self, pressure: float, speed: float, excess_flow: float, missing_torque: float,
            drain: float = math.nan) -> None:
        """Take the means of a block (SI): losses beyond the model, and the case drain flow."""
        row = np.array([pressure, speed, excess_flow, missing_torque, drain])
        if not np.all(np.isfinite(row[:4])) or not pressure > 0.0:
            return
        row[4] /= pressure      # nearly the same all over a bucket
        key = self._key(pressure, speed)
        count = self._counts[key] = self._counts.get(key, 0) + 1
        # The range visited last is the last of the dict.
        known = self._buckets[key] = self._buckets.pop(key, row.copy())
        if len(self._buckets) > _MOST:
            gone = next(iter(self._buckets))
            del self._buckets[gone], self._counts[gone]
        if not math.isfinite(known[4]):
            known[4] = row[4]
        known += np.where(np.isfinite(row), row - known, 0.0) / min(count, self._memory)

    @staticmethod
    def _key(pressure: float, speed: float) -> tuple[int, int]:
        return math.floor(speed / _SPEED), math.floor(pressure / _PRESSURE)

    def at(self, pressure: float, speed: float) -> np.ndarray | None:
        """Return excess flow, missing torque and drain flow; None where nothing was seen."""
        rows = sorted((tuple(self._buckets[key]) for key, count in self._counts.items()
                       if key[0] == self._key(pressure, speed)[0] and count >= _FILLED))
        if not rows:
            return None
        table = np.array(rows)
        low, high = table[0, 0] - 0.5 * _PRESSURE, table[-1, 0] + 0.5 * _PRESSURE
        if not low <= pressure <= high:
            return None
        found = np.array([np.interp(pressure, table[:, 0], table[:, column])
                          for column in (2, 3, 4)])
        return found * [1.0, 1.0, pressure]

    def _modelled(self, pressure: float, speed: float) -> tuple[float, float]:
        """Return leakage and torque of the loss model at an operating point."""
        model = self._model
        if isinstance(model, CircuitModel):
            low = model.rig.charge.relief_pressure if model.rig.charge else 0.0
            known = tell(model, {
                LINES[0]: np.array([pressure + low]), LINES[1]: np.array([low]),
                SPEED: np.array([speed])}, np.zeros(1))
        else:
            known = model.complete({
                SPEED: speed, 'pressure': pressure, 'pump_pressure': pressure})
        found = losses(model, known, speed)
        return float(np.squeeze(found.leakage)), float(np.squeeze(found.torque))

    def resistances(self, pressure: float, speed: float) -> tuple[Resistances | None, str]:
        """Return the loss resistances at an operating point, or None and why there are none."""
        if not pressure > 0.0 or not speed > 0.0:
            return None, 'standstill or no pressure'
        found = self.at(pressure, speed)
        if found is None:
            return None, (f'not valid yet: {pressure / 1e5:.0f} bar at {speed * 30 / math.pi:.0f} '
                          'rpm have not been visited for long enough')
        displacement, accuracy = self._model.motor_displacement, self._accuracy
        leak, made = self._modelled(pressure, speed)
        excess, missing, drain = (float(value) for value in found)
        lost = leak + excess
        flow, torque = displacement * speed + lost, made - missing
        unsure = math.hypot(accuracy.flow * flow, accuracy.speed * displacement * speed)
        if not (lost > 0.0 and torque > 0.0 and pressure > torque / displacement):
            return None, 'not valid: the losses are smaller than the sensors can tell'
        total = Estimate(pressure / lost, pressure / leak if leak > 0.0 else None,
                         pressure / lost**2 * unsure)
        split = math.isfinite(drain)
        external = drain if split else 0.5 * lost
        through = flow - external
        drop, modelled = pressure - torque / displacement, pressure - made / displacement
        spread = math.hypot(accuracy.pressure, accuracy.torque / displacement)
        port = Estimate(drop / through, modelled / (displacement * speed + leak), math.hypot(
            spread, drop / through * (0.0 if split else lost / math.sqrt(12))) / through)
        if not split or not drain > 0.0:
            return Resistances(total, port), ''
        inside, doubt = lost - drain, math.hypot(unsure, accuracy.flow * drain)
        internal = None
        if inside > _SIGNIFICANT * doubt:
            internal = Estimate(torque / displacement / inside, None,
                                torque / displacement / inside**2 * doubt)
        return Resistances(total, port, Estimate(
            pressure / drain, None, pressure / drain * accuracy.flow), internal), ''
