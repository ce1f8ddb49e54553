# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Actual performance of a hydraulic motor, from measured signals.

Equations (11) to (15) of the motor-loss paper. The paper quotes slip and torque loss in percent;
here they are fractions, 0.05 for 5 %.
"""
from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Performance(NamedTuple):
    """
    Performance of a motor at one operating point.

    ``volumetric = 1 - slip``, ``hydromechanical = 1 - torque_loss_ratio`` and ``overall`` is
    their product.
    """

    volumetric: float
    hydromechanical: float
    overall: float
    slip: float
    torque_loss: float
    torque_loss_ratio: float


class Limits(NamedTuple):
    """
    The smallest signals from which an efficiency means something (SI).

    Every ratio below has one of them in its denominator, so at standstill and without pressure
    it is noise divided by noise.
    """

    speed: float = 0.5
    pressure: float = 5e5
    flow: float = 1e-5


def ideal_speed(flow, displacement):
    """Return the speed of a motor without leakage, rad/s. Eq. (13): ``w_mi = Q_s / D_m``."""
    return flow / displacement


def performance(pressure, flow, speed, load_torque, displacement) -> Performance:
    """
    Return all figures of merit of an operating point, Eqs. (11) to (15).

    Parameters
    ----------
    pressure, flow, speed, load_torque : float or ndarray
        Pa, m^3/s, rad/s, N m; pressure and flow not zero.
    displacement : float
        Displacement, m^3/rad.

    """
    # Eq. (12): S_ma = (w_mi - w_ma) / w_mi; Eqs. (14), (15): dT_la = P_p D_m - T_ld.
    ideal = ideal_speed(flow, displacement)
    slip = (ideal - speed) / ideal
    lost_torque = pressure * displacement - load_torque
    lost_share = lost_torque / (pressure * displacement)
    # Eq. (11): eta_ma = T_ld w_ma / (P_p Q_s).
    return Performance(1.0 - slip, 1.0 - lost_share, load_torque * speed / (pressure * flow),
                       slip, lost_torque, lost_share)


def braking(pressure, flow, speed, load_torque, displacement) -> Performance:
    """
    Return the figures of merit of a hydromotor that the load drives: it works as a pump.

    Shaft power comes in and hydraulic power goes out (ISO 4391), so ratios are the other way up;
    signs are those of the driving motor turning forwards: pressure and torque are below 0.
    """
    volumetric = flow / (displacement * speed)
    mechanical = pressure * displacement / load_torque
    return Performance(volumetric, mechanical, volumetric * mechanical, 1.0 - volumetric,
                       pressure * displacement - load_torque, 1.0 - mechanical)


def predicted(pressure, speed, displacement, leakage, mechanical_efficiency) -> Performance:
    """
    Return the performance that a loss model predicts at a measured pressure and speed.

    Parameters
    ----------
    pressure, speed : float or ndarray
        Pa and rad/s, not zero.
    displacement : float
        Displacement, m^3/rad.
    leakage : float or ndarray
        Leakage that the model gives at this point, m^3/s.
    mechanical_efficiency : float or ndarray
        Share of ``P D`` that reaches the shaft.

    """
    flow = displacement * speed + leakage
    torque = mechanical_efficiency * pressure * displacement
    return performance(pressure, flow, speed, torque, displacement)


def reason_not_valid(pressure, flow, speed, load_torque, limits: Limits = Limits()) -> str:
    """
    Return why no efficiency can be told from these signals, or an empty string.

    Parameters
    ----------
    pressure, flow, speed, load_torque : float
        Pa, m^3/s, rad/s, N m; NaN stands for a signal that is not there.
    limits : Limits
        The smallest signals that are enough.

    """
    signals = {'pressure': pressure, 'flow': flow, 'speed': speed, 'load torque': load_torque}
    missing = [name for name, value in signals.items() if not np.isfinite(value)]
    if missing:
        return f'no {" and no ".join(missing)}'
    if abs(speed) < limits.speed:
        return f'standstill: speed {speed:.3g} rad/s is below {limits.speed:g} rad/s'
    if abs(pressure) < limits.pressure:
        return f'pressure {pressure / 1e5:.3g} bar is below {limits.pressure / 1e5:g} bar'
    if abs(flow) < limits.flow or flow * speed <= 0.0:
        return f'flow {flow * 6e4:.3g} L/min does not drive the motor'
    if pressure < 0.0 <= load_torque * speed:
        return f'load torque {load_torque:.3g} N m does not drive the motor that brakes'
    if load_torque * speed <= 0.0 < pressure:
        return f'load torque {load_torque:.3g} N m drives the motor'
    return ''
