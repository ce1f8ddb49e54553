# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Loss characteristics that are no table: one number, or coefficients of the usual models.

Leakage is laminar and turbulent (W. E. Wilson 1950; W. M. J. Schloesser 1961), the loss of torque
Coulomb, viscous and in proportion to pressure. The model reads tables, so these become fine ones.
"""
from __future__ import annotations

from typing import Mapping

from hst_drive.rig.schema import LEAKAGE, TORQUE
from hst_drive.rig.tables import Surface
from hst_drive.units import to_si
import numpy as np

# Finest where losses bend, at low pressure and speed.
_PRESSURES = 1500e5 * np.linspace(0.0, 1.0, 61)**3      # Pa
_SPEEDS = to_si(20000.0, 'rpm') * np.linspace(0.0, 1.0, 31)**3    # rad/s
_FULL = 1e5             # Pa
_LEAST = 0.01           # efficiency where what is lost exceeds what is there


def leakage(found: Mapping[str, float]) -> Surface:
    """Return ``laminar*p + turbulent*sqrt(p)`` over pressure, m^3/s, whatever the second axis."""
    pressure = _PRESSURES / 1e5
    flow = sum(found.get(name, 0.0) * term for name, term in zip(
        LEAKAGE, (pressure, np.sqrt(pressure))))
    return Surface(_PRESSURES, _SPEEDS[[0, -1]],
                   to_si(np.column_stack([flow, flow]), 'L/min'))


def torque_efficiency(found: Mapping[str, float], displacement: float) -> Surface:
    """
    Return ``1 - pressure_share - (coulomb + viscous*w) / (p*D)`` over pressure and speed.

    ``displacement`` is that of the hydromotor, m^3/rad.
    """
    coulomb, viscous, share = (found.get(name, 0.0) for name in TORQUE)
    ideal = np.maximum(_PRESSURES, 1.0)[:, None] * displacement
    lost = share + (coulomb + viscous * _SPEEDS) / ideal
    return Surface(_PRESSURES, _SPEEDS, np.clip(1.0 - lost, _LEAST, 1.0))


def constant(value: float, *, leaks: bool) -> Surface:
    """
    Return a table that has one value everywhere, SI.

    What leaks needs a pressure: below ``_FULL`` it falls to zero with it.
    """
    pressure = np.array([0.0, _FULL, _PRESSURES[-1]])
    return Surface(pressure, _SPEEDS[[0, -1]], np.column_stack(
        [np.where(leaks & (pressure == 0.0), 0.0, value)] * 2))
