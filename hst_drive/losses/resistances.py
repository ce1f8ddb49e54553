# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Loss resistances of a motor, Eqs. (1) to (10) of the motor-loss paper.

The supplied flow loses ``P/R_el`` to the case, passes the inlet port (``R_1``) and loses
``(T/D)/R_2`` between the ports. Eq. (3) is Eq. (2) solved for ``R_1``: pressure, flow, torque
and speed are two equations for three resistances. ``R_el`` needs the case drain flow
(``Q_el = P/R_el``); without it only the total leakage is determined, here as the resistance
``R_total = P/(Q - D w)``, and ``R_1`` lies between the values for no and for all leakage to the
case.
"""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.losses.table import Bench
import numpy as np


class Resistances(NamedTuple):
    """
    Resistances of each row, Pa.s/m^3; NaN where the row does not determine one.

    ``inlet_low`` and ``inlet_high`` bound ``inlet`` where there is no case drain flow.
    """

    external: np.ndarray
    inlet: np.ndarray
    internal: np.ndarray
    total: np.ndarray
    inlet_low: np.ndarray
    inlet_high: np.ndarray


class Prediction(NamedTuple):
    """
    What resistances give at a row: rad/s, N.m, N.m, and fractions.

    ``speed_eq1`` is Eq. (1) as printed; ``speed`` is Eq. (1) with the flow through the inlet
    port taken from Eq. (2).
    """

    speed_eq1: np.ndarray
    speed: np.ndarray
    load_torque: np.ndarray
    torque_loss: np.ndarray
    slip: np.ndarray
    efficiency: np.ndarray


def identify(bench: Bench) -> Resistances:
    """Return the resistances that each row determines, Eqs. (2) to (4)."""
    swept = bench.displacement * bench.speed
    drop = bench.pressure - bench.load_torque / bench.displacement
    internal = None if bench.drain is None else bench.flow - bench.drain - swept
    return of_losses(bench, drop, bench.flow - swept, bench.drain, internal)


def of_losses(bench: Bench, drop: np.ndarray, leakage: np.ndarray, external: np.ndarray | None,
              internal: np.ndarray | None) -> Resistances:
    """Return the resistances of a drop (Pa) at the inlet, and of leakages (m^3/s), at rows."""
    total = _ratio(bench.pressure, leakage)
    if external is None:
        nothing = np.full(len(bench), np.nan)
        return Resistances(nothing, nothing, nothing, total, _ratio(drop, bench.flow),
                           _ratio(drop, bench.flow - leakage))
    inlet = _ratio(drop, bench.flow - external)
    return Resistances(_ratio(bench.pressure, external), inlet,
                       _ratio(bench.load_torque / bench.displacement, internal), total, inlet,
                       inlet)


def predict(pressure, flow, load_torque, displacement, external, inlet, internal) -> Prediction:
    """
    Return the performance that resistances give at measured pressure, flow and load.

    Eqs. (1) and (6) to (10). Eq. (1) as printed divides the small difference ``P - T/D`` by
    ``R_1``: an error of 1 % of the pressure becomes one of about 15 % of the speed. With
    Eq. (2) the same flow is ``Q - P/R_el``; efficiency, Eq. (8), takes this speed.

    Parameters
    ----------
    pressure, flow, load_torque, displacement : float or ndarray
        Pa, m^3/s, N.m, m^3/rad.
    external, inlet, internal : float or ndarray
        ``R_el``, ``R_1``, ``R_2`` in Pa.s/m^3.

    """
    load_pressure = load_torque / displacement
    inlet_flow = flow - pressure / external
    speed_eq1 = ((pressure - load_pressure) / inlet - load_pressure / internal) / displacement
    speed = (inlet_flow - load_pressure / internal) / displacement
    torque_loss = inlet_flow * inlet * displacement
    torque = pressure * displacement - torque_loss
    slip = (load_pressure / internal + pressure / external) / flow
    return Prediction(speed_eq1, speed, torque, torque_loss, slip,
                      torque * speed / (pressure * flow))


def _ratio(over, under):
    with np.errstate(divide='ignore', invalid='ignore'):
        return np.where(under > 0.0, over / under, np.nan)
