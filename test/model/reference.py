# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The drive's equations written a second time, straight from the datasheet, for SciPy's Radau.

Nothing of the product's model is used: tables from the rig file by numpy.interp, units by hand.
"""
import math
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import RectBivariateSpline
import yaml

RIG = Path(__file__).resolve().parents[2] / 'config' / 'rig' / 'test_rig.yaml'
BAR, RPM, LPM, CC = 1e5, math.pi / 30, 1e-3 / 60, 1e-6 / (2 * math.pi)
FLOOR = -0.9 * BAR


class Reference:
    """State: pump displacement, pressure, hydromotor speed, PPRV pressure; SI, gauge."""

    def __init__(self):
        sheet = yaml.safe_load(RIG.read_text())
        self.sheet = sheet
        pump, motor, load = sheet['pump'], sheet['motor'], sheet['loading']
        self.w_pump = pump['shaft_speed_rpm'] * RPM
        self.d_motor = motor['displacement_cc_rev'] * CC
        self.inertia = motor['inertia_total_kg_m2']
        self.volume, self.bulk = sheet['line']['volume_m3'], sheet['line']['bulk_modulus_Pa']
        valve = sheet['relief_valve']
        self.p_set = valve['set_pressure_bar'] * BAR
        self.orifice = valve['discharge_coefficient'] * valve['area_m2']
        self.density = sheet['line']['oil_density_kg_m3']
        self.gear = load['gear_ratio']
        self.d_load = load['pump_displacement_cc_rev'] * CC
        self.override = load['pprv_override_bar_per_L_min'] * BAR / LPM
        self.q_ref = load['pprv_reference_flow_L_min'] * LPM
        self.lag_pump, self.lag_pprv = pump['displacement_lag_s'], load['pprv_lag_s']
        self._pump_leak = self._surface(pump['leakage_L_min'], 'command_V', 1.0, LPM)
        self._motor_leak = self._surface(motor['leakage_L_min'], 'speed_rpm', RPM, LPM)
        self._eta = self._surface(motor['mechanical_efficiency'], 'speed_rpm', RPM, 1.0)

    @staticmethod
    def _surface(table, axis, axis_unit, unit):
        x, y = np.array(table['pressure_bar']) * BAR, np.array(table[axis]) * axis_unit
        # Of degree 1 it is the bilinear table, and holds its end values outside.
        look = RectBivariateSpline(x, y, np.array(table['table']) * unit, kx=1, ky=1)
        return lambda a, b: float(look(a, b, grid=False))

    def displacement(self, u):
        table = self.sheet['pump']['displacement_vs_command']
        return float(np.interp(u, table['command_V'], table['displacement_cc_rev'])) * CC

    def pprv(self, v):
        table = self.sheet['loading']['pprv_pressure_vs_command']
        return float(np.interp(v, table['command_V'], table['pressure_bar'])) * BAR

    def q_leak_pump(self, p, u):
        return self._pump_leak(p, u)

    def q_leak_motor(self, p, w):
        return self._motor_leak(p, abs(w))

    def q_relief(self, p):
        return self.orifice * math.sqrt(2 * max(p - self.p_set, 0) / self.density)

    def torque_motor(self, p, w):
        return self._eta(p, abs(w)) * max(p, 0.0) * self.d_motor

    def torque_load(self, p_pprv, w):
        p = max(p_pprv + self.override * (self.gear * self.d_load * abs(w) - self.q_ref), 0.0)
        table = self.sheet['loading']['pump_mechanical_efficiency']
        eta = np.interp(p, np.array(table['pressure_bar']) * BAR, table['efficiency'])
        return p * self.d_load * self.gear / float(eta) * math.tanh(w / 0.15)

    def rates(self, x, u, v, roughness=0.0):
        d, p, w, p_pprv = x
        flow = (d * self.w_pump - self.q_leak_pump(p, u) - self.d_motor * w
                - self.q_leak_motor(p, w) - self.q_relief(p))
        p_rate = self.bulk / self.volume * flow
        if p <= FLOOR:
            p_rate = max(p_rate, 0.0)
        load = self.torque_load(p_pprv, w) + roughness * abs(math.tanh(w / 0.15))
        return [(self.displacement(u) - d) / self.lag_pump, p_rate,
                (self.torque_motor(p, w) - load) / self.inertia,
                (self.pprv(v) - p_pprv) / self.lag_pprv]

    def run(self, time, u, v, x0, tolerance=1e-9):
        """Integrate piece by piece between changes of the held commands; rows like ``x0``."""
        out = np.empty((len(time), 4))
        out[0] = x0
        edges = [0, *(np.flatnonzero((np.diff(u) != 0) | (np.diff(v) != 0)) + 1), len(time) - 1]
        for first, last in zip(edges[:-1], edges[1:]):
            self._piece(time[first:last + 1], u[first], v[first], out[first:last + 1], tolerance)
        return out

    def _piece(self, time, u, v, out, tolerance):
        """Fill ``out`` from its first row on; the pressure's floor is a corner: stop there."""
        def rate(t, x):
            found = self.rates(x, u, v)
            if stuck:
                found[1] = 0.0
            return found

        def corner(t, x):
            # Leaves the floor when more flows in than out.
            return (x[0] * self.w_pump - self.d_motor * x[2] - self.q_leak_pump(FLOOR, u)
                    - self.q_leak_motor(FLOOR, x[2])) if stuck else x[1] - FLOOR

        corner.terminal = True
        now, x = time[0], np.array(out[0])
        while now < time[-1]:
            stuck = x[1] <= FLOOR and self.rates(x, u, v)[1] <= 0
            corner.direction = 1 if stuck else -1
            solved = solve_ivp(rate, (now, time[-1]), x, 'Radau', rtol=tolerance,
                               atol=tolerance * np.array([1e-7, 1e5, 1.0, 1e5]),
                               dense_output=True, events=corner)
            inside = (time > now) & (time <= solved.t[-1])
            if inside.any():
                out[inside] = solved.sol(time[inside]).T
            now, x = solved.t[-1], solved.y[:, -1].copy()
            if solved.t_events[0].size:
                # Just past the corner, so that it is not found again.
                x[1] = FLOOR + 1e-3 if stuck else FLOOR
