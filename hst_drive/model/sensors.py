# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the sensors make of the true values: noise, range and steps of the reading."""
from __future__ import annotations

from typing import Mapping

from hst_drive.rig import Rig
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
            reading = values[name] + sensor.noise_std * self._random.standard_normal(
                np.shape(values[name]))
            if sensor.range:
                reading = np.clip(reading, *sensor.range)
            if sensor.resolution:
                reading = np.round(reading / sensor.resolution) * sensor.resolution
            readings[name] = reading if np.ndim(reading) else float(reading)
        return readings
