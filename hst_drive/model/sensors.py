# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the sensors make of the true values: noise, range and steps of the reading."""
from __future__ import annotations

from typing import Mapping

from hst_drive.rig import Rig
from hst_drive.rig.rig import Sensor
import numpy as np


class SensorBank:
    """
    The sensors of a rig.

    Parameters
    ----------
    rig : Rig
        Its ``sensors`` say which channels there are and how good.
    seed : int
        The same seed gives the same noise, reading by reading.

    """

    def __init__(self, rig: Rig, seed: int = 0):
        self.sensors = rig.sensors
        self._random = np.random.default_rng(seed)

    def read(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the readings (SI) of those values that a sensor watches."""
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
