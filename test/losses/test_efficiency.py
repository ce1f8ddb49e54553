# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The figures of merit against closed forms and power balances."""
from hst_drive.losses import efficiency as eff
from hypothesis import given, strategies as st
import numpy as np
import pytest

DISPLACEMENT = 195e-6 / (2 * np.pi)


def test_a_motor_without_losses_is_perfect():
    speed, pressure = 10.0, 80e5
    got = eff.performance(pressure, DISPLACEMENT * speed, speed, pressure * DISPLACEMENT,
                          DISPLACEMENT)
    assert got.volumetric == pytest.approx(1.0)
    assert got.hydromechanical == pytest.approx(1.0)
    assert got.overall == pytest.approx(1.0)
    assert got.slip == pytest.approx(0.0, abs=1e-12)
    assert got.torque_loss == pytest.approx(0.0, abs=1e-9)


def test_a_point_worked_by_hand():
    # 195 cc/rev at 100 rpm takes 19.5 L/min; 20 L/min supplied is 2.5 % slip. 80 bar on
    # 195 cc/rev is 248.28 N m; 220 N m at the shaft.
    got = eff.performance(80e5, 20e-3 / 60, 100 * 2 * np.pi / 60, 220.0, DISPLACEMENT)
    assert got.slip == pytest.approx(0.025)
    assert got.torque_loss == pytest.approx(248.2817 - 220.0, abs=1e-3)
    assert got.torque_loss_ratio == pytest.approx(0.11391, abs=1e-5)
    assert got.overall == pytest.approx(220.0 * 10.471976 / (80e5 * 20e-3 / 60), rel=1e-6)


@given(pressure=st.floats(5e5, 4e7), speed=st.floats(0.5, 300.0), leak=st.floats(0.0, 1e-3),
       share=st.floats(0.05, 1.0))
def test_the_lost_power_is_the_sum_of_its_parts(pressure, speed, leak, share):
    got = eff.predicted(pressure, speed, DISPLACEMENT, leak, share)
    flow = DISPLACEMENT * speed + leak
    lost = pressure * leak + got.torque_loss * speed
    assert (1.0 - got.overall) * pressure * flow == pytest.approx(lost, rel=1e-9, abs=1e-6)
    assert got.overall == pytest.approx(got.volumetric * got.hydromechanical, rel=1e-9)
    assert got.volumetric == pytest.approx(1.0 - got.slip)
    assert got.hydromechanical == pytest.approx(share)


def test_it_works_on_arrays():
    speed = np.array([5.0, 10.0])
    got = eff.predicted(np.array([20e5, 80e5]), speed, DISPLACEMENT, 1e-5, 0.9)
    assert got.slip == pytest.approx(1e-5 / (DISPLACEMENT * speed + 1e-5))


@pytest.mark.parametrize('signals, word', [
    ((80e5, 3e-4, 0.0, 200.0), 'standstill'),
    ((80e5, 3e-4, np.nan, 200.0), 'no speed'),
    ((np.nan, np.nan, 10.0, 200.0), 'no pressure and no flow'),
    ((2e5, 3e-4, 10.0, 20.0), 'pressure'),
    ((80e5, 0.0, 10.0, 200.0), 'flow'),
    ((80e5, -3e-4, 10.0, 200.0), 'flow'),
    ((80e5, 3e-4, 10.0, -5.0), 'load torque'),
    ((80e5, 3e-4, 10.0, 200.0), ''),
])
def test_it_says_why_nothing_can_be_told(signals, word):
    reason = eff.reason_not_valid(*signals)
    assert word in reason if word else reason == ''
