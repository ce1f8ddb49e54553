# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The loading unit of the rig: from a wanted torque to the PPRV command that gives it."""
from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class LoadingUnit:
    """
    Gear, loading pump and PPRV, in steady state.

    Eq. (7) of the drill-drive paper, ``T = P D N / eta(P)``, with the pressure that the PPRV
    holds at a flow: ``P = P_table(v) + override * (N D w - reference_flow)``, never below 0.
    Tables are linear between points and hold their ends.

    Attributes
    ----------
    gear_ratio : float
        Loading pump speed over hydromotor speed.
    pump_displacement : float
        m^3/rad.
    efficiency_pressure, efficiency : sequences, shape (n,)
        Pa, 1.
    command, pressure : sequences, shape (m,)
        PPRV command, strictly rising, V, and its pressure, not falling, Pa.
    override : float
        Pa.s/m^3.
    reference_flow : float
        m^3/s.

    """

    gear_ratio: float
    pump_displacement: float
    efficiency_pressure: tuple[float, ...]
    efficiency: tuple[float, ...]
    command: tuple[float, ...]
    pressure: tuple[float, ...]
    override: float = 0.0
    reference_flow: float = 0.0

    def __post_init__(self):
        for name in ('efficiency_pressure', 'efficiency', 'command', 'pressure'):
            object.__setattr__(self, name, tuple(float(value) for value in getattr(self, name)))
        ratio = [p / eta for p, eta in zip(self.efficiency_pressure, self.efficiency)]
        if any(b <= a for a, b in zip(ratio, ratio[1:])):
            raise ValueError('loading pump efficiency: the torque P / eta(P) falls with pressure '
                             'somewhere, so a torque has no single pressure; check the table')
        object.__setattr__(self, '_ratio', ratio)

    @classmethod
    def of(cls, loading) -> LoadingUnit:
        """Take the numbers from the ``loading`` section of a rig."""
        return cls(loading.gear_ratio, loading.pump_displacement,
                   loading.pump_mechanical_efficiency.x, loading.pump_mechanical_efficiency.y,
                   loading.pprv_pressure.x, loading.pprv_pressure.y,
                   loading.pprv_override, loading.pprv_reference_flow)

    def torque_of_pressure(self, pressure: float) -> float:
        """Return the torque at the hydromotor shaft, N.m, at a loading pressure, Pa."""
        eta = float(np.interp(pressure, self.efficiency_pressure, self.efficiency))
        return pressure * self.pump_displacement * self.gear_ratio / eta

    def pressure_of_torque(self, torque: float) -> float:
        """
        Return the loading pressure in Pa that gives a torque in N.m; 0 for none.

        Exact: between two points of the table ``eta = a + b P``, so ``P = r a / (1 - r b)``
        with ``r = T / (D N) = P / eta``.
        """
        r = torque / (self.pump_displacement * self.gear_ratio)
        if r <= 0.0:
            return 0.0
        x, eta, ratio = self.efficiency_pressure, self.efficiency, self._ratio
        if r >= ratio[-1]:
            return r * eta[-1]
        i = bisect_right(ratio, r) - 1
        if i < 0:
            return r * eta[0]
        slope = (eta[i + 1] - eta[i]) / (x[i + 1] - x[i])
        return r * (eta[i] - slope * x[i]) / (1.0 - r * slope)

    def override_pressure(self, speed: float) -> float:
        """Return what the flow adds to the PPRV's pressure, Pa, at a speed in rad/s."""
        flow = self.gear_ratio * self.pump_displacement * speed
        return self.override * (flow - self.reference_flow)

    def torque_of_command(self, command: float, speed: float) -> float:
        """Return the steady torque, N.m, of a command, V, at a speed, rad/s."""
        pressure = float(np.interp(command, self.command, self.pressure))
        return self.torque_of_pressure(max(pressure + self.override_pressure(speed), 0.0))

    def command_of_torque(self, torque: float, speed: float) -> float:
        """
        Return the PPRV command, V, that gives a torque, N.m, at a speed, rad/s.

        A torque out of reach gives the nearest command that gives the least or greatest
        pressure; of a flat part of the table below the top, its upper end.
        """
        wanted = self.pressure_of_torque(torque) - self.override_pressure(speed)
        x, y = self.pressure, self.command
        wanted = max(wanted, x[0])
        if wanted >= x[-1]:
            return y[bisect_left(x, x[-1])]
        i = bisect_right(x, wanted) - 1
        return y[i] + (y[i + 1] - y[i]) * (wanted - x[i]) / (x[i + 1] - x[i])

    def torque_range(self, speed: float) -> tuple[float, float]:
        """Return least and greatest torque, N.m, at a speed, rad/s."""
        return (self.torque_of_command(self.command[0], speed),
                self.torque_of_command(self.command[-1], speed))
