# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Identification of the resistances: numbers worked by hand, and resistances got back."""
from hst_drive.losses import resistances as eq
from hst_drive.losses.table import Bench
from hypothesis import given, strategies as st
import numpy as np
import pytest

DISPLACEMENT = 16e-6 / (2 * np.pi)


def bench(pressure, flow, torque, speed, drain=None, displacement=DISPLACEMENT):
    """Return a table of one row."""
    one = np.ones(1)
    return Bench(displacement * one, 325.0 * one, torque * one, speed * one, pressure * one,
                 flow * one, 3e-5 * one, np.array([2]), None if drain is None else drain * one)


def test_a_row_worked_by_hand():
    # 16 cc/rev, 80 bar, 15 L/min, 19 N m, 900 rpm, 0.2 L/min to the case: T/D = 74.613 bar, so
    # 5.387 bar over 14.8 L/min, and 14.8 - 14.4 = 0.4 L/min between the ports.
    found = eq.identify(bench(80e5, 15e-3 / 60, 19.0, 900 * np.pi / 30, 0.2e-3 / 60))
    per = 1e5 * 60e3
    assert found.external[0] / per == pytest.approx(80 / 0.2)
    assert found.inlet[0] / per == pytest.approx(5.3871 / 14.8, rel=1e-4)
    assert found.internal[0] / per == pytest.approx(74.6128 / 0.4, rel=1e-4)
    assert found.total[0] / per == pytest.approx(80 / 0.6)


def test_without_case_drain_flow_nothing_is_invented():
    found = eq.identify(bench(80e5, 15e-3 / 60, 19.0, 900 * np.pi / 30))
    assert np.isnan([found.external[0], found.internal[0], found.inlet[0]]).all()
    assert found.total[0] / 6e9 == pytest.approx(80 / 0.6)
    # All 0.6 L/min to the case, or none: the port sees 14.4 or 15 L/min.
    assert found.inlet_low[0] / 6e9 == pytest.approx(5.3871 / 15.0, rel=1e-4)
    assert found.inlet_high[0] / 6e9 == pytest.approx(5.3871 / 14.4, rel=1e-4)


@given(external=st.floats(1e10, 1e13), inlet=st.floats(1e7, 1e10), internal=st.floats(1e10, 1e13),
       speed=st.floats(10.0, 300.0), torque=st.floats(1.0, 200.0), cc=st.floats(5.0, 200.0))
def test_known_resistances_come_back(external, inlet, internal, speed, torque, cc):
    size = cc * 1e-6 / (2 * np.pi)
    # The circuit of the paper's Fig. 4, solved by hand: port flow feeds shaft and inner leak.
    port_flow = size * speed + torque / size / internal
    pressure = torque / size + inlet * port_flow
    flow = port_flow + pressure / external
    row = bench(pressure, flow, torque, speed, pressure / external, size)
    found = eq.identify(row)
    assert found.external[0] == pytest.approx(external, rel=1e-9)
    if inlet * port_flow > 1e-4 * pressure and flow - port_flow < 0.5 * flow:
        assert found.inlet[0] == pytest.approx(inlet, rel=1e-6)
    if torque / size / internal > 1e-5 * flow:
        assert found.internal[0] == pytest.approx(internal, rel=1e-6)
    back = eq.predict(pressure, flow, torque, size, external, inlet, internal)
    assert back.speed == pytest.approx(speed, rel=1e-6)
    assert back.speed_eq1 == pytest.approx(speed, rel=1e-4)
    assert back.load_torque == pytest.approx(torque, rel=1e-6)
    assert back.efficiency == pytest.approx(torque * speed / (pressure * flow), rel=1e-6)
    assert back.slip == pytest.approx(1 - size * speed / flow, abs=1e-9)


def test_equation_1_as_printed_is_ill_conditioned():
    """An error of 1 % of the pressure drop's parts moves Eq. (1) tens of times further."""
    row = bench(80e5, 15e-3 / 60, 19.0, 900 * np.pi / 30, 0.2e-3 / 60)
    found = eq.identify(row)
    off = eq.predict(80e5 * 1.01, 15e-3 / 60, 19.0, DISPLACEMENT, found.external, found.inlet,
                     found.internal)
    speed = 900 * np.pi / 30
    assert abs(off.speed_eq1[0] / speed - 1) > 0.1
    assert abs(off.speed[0] / speed - 1) < 1e-3
