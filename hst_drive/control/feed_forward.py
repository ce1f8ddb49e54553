# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Feed-forward of the pump command from the set point."""
from __future__ import annotations

from bisect import bisect_left, bisect_right


class PumpFeedForward:
    """
    Pump command that would give the set speed if nothing leaked.

    The inverse of the pump's displacement table at ``D_m w / w_p``. Parts of the table that do
    not rise (the dead band) map to their upper end. Leakage stays with the integral.

    Parameters
    ----------
    command : array_like, shape (n,)
        Strictly rising, V.
    displacement : array_like, shape (n,)
        Not falling, m^3/rad.
    pump_speed : float
        Pump shaft speed, rad/s.
    motor_displacement : float
        m^3/rad.

    """

    def __init__(self, command, displacement, pump_speed: float, motor_displacement: float):
        self._command = [float(value) for value in command]
        self._displacement = [float(value) for value in displacement]
        self._ratio = motor_displacement / pump_speed

    def __call__(self, setpoint: float) -> float:
        """Return the command in V for a speed in rad/s; 0 V at standstill."""
        x, y = self._displacement, self._command
        wanted = setpoint * self._ratio
        if setpoint <= 0.0:
            return 0.0
        wanted = max(wanted, x[0])
        if wanted >= x[-1]:
            return y[bisect_left(x, x[-1])]
        i = bisect_right(x, wanted) - 1
        return y[i] + (y[i + 1] - y[i]) * (wanted - x[i]) / (x[i + 1] - x[i])
