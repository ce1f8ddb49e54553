# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The speed of the hydromotor behind what was recorded of it."""
from __future__ import annotations

from hst_drive.measure.readings import filled, Readings
from hst_drive.measure.run import Run
from hst_drive.model import Drive
import numpy as np

_LAGS = ('speed_reading_lag', 'speed_reading_series_lag')


def measured_speed(drive: Drive, run: Run, torque: np.ndarray) -> np.ndarray:
    """Return the speed (rad/s) of a record; from flow meter and torque (N.m) if need be."""
    if 'motor_speed' in run:
        return filled(run['motor_speed'])
    motor, flow = drive.rig.motor, filled(run['motor_inlet_flow'])
    pressure = np.maximum(torque, 0.0) / motor.displacement
    return (flow - motor.leakage(pressure, np.abs(flow) / motor.displacement)
            ) / motor.displacement


def speed_behind(drive: Drive, readings: Readings, reading: np.ndarray,
                 oil_temperature: np.ndarray) -> np.ndarray:
    """
    Return the speed (rad/s) of which a sensor reads this.

    Parameters
    ----------
    drive : Drive
        Its effects say how the reading is late and off.
    readings : Readings
        Of the record.
    reading, oil_temperature : ndarray, shape (n,)
        rad/s, K.

    """
    speed = reading - drive.slot('speed_reading', motor_speed=reading,
                                 oil_temperature=oil_temperature)
    for slot in _LAGS:
        speed = readings.ahead(speed, drive.slot(slot))
    return speed
