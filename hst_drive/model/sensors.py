# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the sensors make of the true values: noise, range and steps of the reading."""
from __future__ import annotations

from dataclasses import replace
from typing import Any, Mapping, Sequence

from hst_drive.channels import CHANNELS
from hst_drive.rig import Rig
from hst_drive.rig.rig import Sensor
import numpy as np


def usual_sensors(rig: Rig) -> dict[str, Sensor]:
    """Return a whole rig's sensors, of the usual kind where it states none, or no noise."""
    pump, pressure = rig.pump, rig.relief_valve.set_pressure
    largest = {'Pa': pressure, 'm^3/s': pump.max_displacement * pump.shaft_speed,
               'N.m': rig.motor.displacement * pressure, 'm^3/rad': pump.max_displacement,
               'rad/s': rig.full_speed}
    usual = {name: Sensor(entry.noise * largest[entry.unit]) for name, entry in CHANNELS.items()
             if entry.noise and name != 'pump_speed'}
    usual['pump_speed'] = Sensor(CHANNELS['pump_speed'].noise * pump.shaft_speed)
    stated = rig.sensors.get('pump_outlet_pressure')
    if stated:
        usual['motor_inlet_pressure'] = stated
        # It stands about zero: a range that ends there would cut half of the noise off.
        usual['motor_outlet_pressure'] = replace(stated, range=None)
    return {**usual, **{name: replace(sensor, noise_std=sensor.noise_std or usual[name].noise_std)
                        for name, sensor in rig.sensors.items() if name in usual}}


class SensorBank:
    """
    The sensors of a rig.

    Parameters
    ----------
    rig : Rig
        Its ``sensors`` say which channels there are and how good.
    seed : int
        The same seed gives the same noise, reading by reading.
    more : sequence of str
        Channels that are read as well, by a usual sensor if the rig states none.

    """

    def __init__(self, rig: Rig, seed: int = 0, more: Sequence[str] = ()):
        usual = usual_sensors(rig) if more else {}
        self.sensors = {**rig.sensors, **{name: usual[name] for name in more if name in usual}}
        self._random = np.random.default_rng(seed)

    def read(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the readings (SI) of those values, numbers or arrays, that a sensor watches."""
        readings = {}
        for name, sensor in self.sensors.items():
            if name not in values:
                continue
            value = values[name]
            if isinstance(value, float):
                readings[name] = self._single(sensor, value)
                continue
            reading = value + sensor.noise_std * self._random.standard_normal(np.shape(value))
            if sensor.range:
                reading = np.clip(reading, *sensor.range)
            if sensor.resolution:
                reading = np.round(reading / sensor.resolution) * sensor.resolution
            readings[name] = reading if np.ndim(reading) else float(reading)
        return readings

    def _single(self, sensor: Sensor, value: float) -> float:
        """Return one reading; a tenth of the time that NumPy takes for a single number."""
        reading = value + sensor.noise_std * self._random.standard_normal()
        if sensor.range:
            low, high = sensor.range
            reading = min(max(reading, low), high)
        if sensor.resolution:
            reading = round(reading / sensor.resolution, 0) * sensor.resolution
        return reading
