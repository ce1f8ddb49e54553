# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A fitted motor as the tables of a rig file."""
from __future__ import annotations

from hst_drive.losses.study import Study
from hst_drive.units import from_si
import numpy as np

_LEAST_EFFICIENCY = 0.01        # what a rig file allows


def motor_section(study: Study, size: float, viscosity: float, top_pressure: float,
                  top_speed: float) -> dict:
    """
    Return displacement, leakage and mechanical efficiency of a motor with the keys of a rig file.

    Parameters
    ----------
    study : Study
        The bench.
    size : float
        Displacement of the motor, m^3/rad.
    viscosity : float
        Kinematic viscosity of the oil that the tables hold for, m^2/s.
    top_pressure, top_speed : float
        Ends of the tables, Pa and rad/s; beyond the bench the formulas are extrapolated.

    """
    pressure = top_pressure * np.linspace(0.0, 1.0, 33)**1.5
    speed = np.linspace(0.0, top_speed, 17)
    p, w = np.meshgrid(np.maximum(pressure, 1e-3 * top_pressure),
                       np.maximum(speed, 0.02 * top_speed), indexing='ij')
    lost = study.curves(p.ravel(), w.ravel(), viscosity, size)
    leakage = np.maximum(lost.leakage.reshape(p.shape), 0.0)
    leakage[0] = 0.0
    efficiency = 1.0 - lost.torque_loss.reshape(p.shape) / (p * size)
    bars, rpm = (_rounded(from_si(pressure, 'bar'), 4), _rounded(from_si(speed, 'rpm'), 3))
    return {
        'displacement_cc_rev': float(f'{from_si(size, "cc/rev"):.7g}'),
        'leakage_L_min': {'pressure_bar': bars, 'speed_rpm': rpm,
                          'table': [_rounded(from_si(row, 'L/min'), 6) for row in leakage]},
        'mechanical_efficiency': {
            'pressure_bar': bars, 'speed_rpm': rpm,
            'table': [_rounded(row, 6) for row in np.clip(efficiency, _LEAST_EFFICIENCY, 1.0)]}}


def ends_of(study: Study, size: float) -> tuple[float, float]:
    """Return the pressure (Pa) and speed (rad/s) to which a motor's tables should go."""
    own = study.bench.of_motor(size)
    own = own if own.any() else np.ones(len(study.bench), dtype=bool)
    return (1.25 * float(study.bench.pressure[own].max()),
            1.2 * float(study.bench.speed[own].max()))


def _rounded(values: np.ndarray, digits: int) -> list[float]:
    return [float(value) for value in np.round(values, digits)]
