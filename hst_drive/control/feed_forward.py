# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Feed-forward of the pump command from the set point."""
from __future__ import annotations

from bisect import bisect_left, bisect_right
import math


class PumpFeedForward:
    """
    Pump command that would give the set speed if nothing leaked.

    The inverse of the pump's displacement table at ``D_m w / w_p``. Parts of the table that do
    not rise (the dead band) map to their end away from zero stroke. Leakage stays with the
    integral.

    Parameters
    ----------
    command : array_like, shape (n,)
        Strictly rising, V.
    displacement : array_like, shape (n,)
        Not falling, m^3/rad; negative for a pump over centre, which turns the drive either way.
    pump_speed : float
        Pump shaft speed, rad/s.
    motor_displacement : float
        m^3/rad.

    """

    def __init__(self, command, displacement, pump_speed: float, motor_displacement: float):
        x, y = [float(value) for value in displacement], [float(value) for value in command]
        self._forwards = x, y
        self._backwards = [-value for value in reversed(x)], [-value for value in reversed(y)]
        self._ratio = motor_displacement / pump_speed

    def __call__(self, setpoint: float) -> float:
        """Return the command in V for a speed in rad/s; 0 V at standstill."""
        x, y = self._forwards if setpoint > 0.0 else self._backwards
        if setpoint == 0.0 or x[-1] <= 0.0:
            return 0.0
        wanted = max(abs(setpoint) * self._ratio, x[0])
        if wanted >= x[-1]:
            found = y[bisect_left(x, x[-1])]
        else:
            i = bisect_right(x, wanted) - 1
            found = y[i] + (y[i + 1] - y[i]) * (wanted - x[i]) / (x[i + 1] - x[i])
        return math.copysign(1.0, setpoint) * found
