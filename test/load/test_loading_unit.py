# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The inverse of the loading unit against its forward equations and the paper's points."""
import math

from hst_drive.load import LoadingUnit
from hypothesis import given, strategies as st
import numpy as np
import pytest

REV = 2.0 * math.pi
RPM = REV / 60.0
UNIT = LoadingUnit(
    20.0, 10e-6 / REV, np.array([0, 10, 20, 40, 60, 80, 120, 200]) * 1e5,
    [0.62, 0.74, 0.8, 0.85, 0.875, 0.89, 0.9, 0.905], [0.0, 0.5, 1.0, 2.0, 4.0, 6.0, 8.0, 10.0],
    np.array([3, 3, 8, 27, 69, 112, 156, 200]) * 1e5, 0.4e5 * 6e4, 20e-3 / 60.0)


def forward(command, speed):
    """Return the torque by the datasheet's equations, written out anew."""
    flow = 20.0 * 10e-6 / REV * speed * 6e4
    bar = max(np.interp(command, UNIT.command, np.array(UNIT.pressure) / 1e5)
              + 0.4 * (flow - 20.0), 0.0)
    eta = np.interp(bar, [0, 10, 20, 40, 60, 80, 120, 200], UNIT.efficiency)
    return bar * 1e5 * 10e-6 / REV * 20.0 / eta


@given(st.floats(0.0, 1000.0), st.floats(0.0, 160.0))
def test_inverse_gives_the_torque_back_or_sits_at_a_limit(torque, rpm):
    speed = rpm * RPM
    command = UNIT.command_of_torque(torque, speed)
    low, high = UNIT.torque_range(speed)
    assert 0.5 <= command <= 10.0
    assert forward(command, speed) == pytest.approx(min(max(torque, low), high), abs=1e-6)
    assert UNIT.torque_of_command(command, speed) == pytest.approx(forward(command, speed))


@given(st.floats(0.0, 600.0), st.floats(0.0, 600.0), st.floats(0.0, 160.0))
def test_more_torque_never_takes_less_command(one, other, rpm):
    low, high = sorted((one, other))
    assert UNIT.command_of_torque(low, rpm * RPM) <= UNIT.command_of_torque(high, rpm * RPM)


def test_points_of_the_paper():
    """223.5 N m at 100 rpm: the load pressure by hand, 223.5 eta / (D N), lies at 61.6 bar."""
    pressure = UNIT.pressure_of_torque(223.5)
    eta = 0.875 + 0.015 * (pressure / 1e5 - 60.0) / 20.0
    assert pressure == pytest.approx(223.5 * eta * REV / (10e-6 * 20.0), rel=1e-9)
    assert pressure / 1e5 == pytest.approx(61.6, abs=0.1)
    # At 100 rpm the loading pump gives just the reference flow: no override.
    assert UNIT.override_pressure(100 * RPM) == pytest.approx(0.0, abs=1.0)


def test_flat_top_of_the_table():
    unit = LoadingUnit(1.0, 1e-6, [0.0, 1e7], [0.8, 0.9], [0.0, 1.0, 2.0, 3.0],
                       [0.0, 1e7, 1e7, 2e7])
    assert unit.command_of_torque(unit.torque_of_pressure(0.5e7), 0.0) == pytest.approx(0.5)
    assert unit.command_of_torque(unit.torque_of_pressure(1.5e7), 0.0) == pytest.approx(2.5)
    flat = LoadingUnit(1.0, 1e-6, [0.0, 1e7], [0.8, 0.9], [0.0, 1.0, 2.0], [0.0, 1e7, 1e7])
    assert flat.command_of_torque(1e9, 0.0) == 1.0


def test_ambiguous_efficiency_is_refused():
    with pytest.raises(ValueError, match='single pressure'):
        LoadingUnit(1.0, 1e-6, [1e6, 1.1e6], [0.3, 0.9], [0.0, 1.0], [0.0, 1e7])
