# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Margins against closed forms and against a simulated loop that is driven to its limit."""
import math

from hst_drive.control.margins import choose_gains, discretise, Loop, margins, meets, Plant
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest
from scipy.integrate import solve_ivp

TS = 0.01
REV = 2.0 * math.pi


def linear_drive(leakage=2.0e-12, efficiency=0.88, override=0.4e5 * 6e4, load_efficiency=0.88):
    """
    Return the test rig linearised by hand from the paper's balances and the datasheet.

    States: pump displacement, pressure, speed; input V, output rad/s. Slopes: pump table
    3.3 cc/rev/V behind 0.06 s, flow balance, torque balance with a load that rises with speed
    through the PPRV's override.
    """
    table, lag, pump_speed = 3.3e-6 / REV, 0.06, 1450.0 * REV / 60.0
    motor, inertia, stiffness = 195e-6 / REV, 0.35, 1.2e9 / 0.9e-3
    load = 10e-6 / REV * 20.0
    drag = load**2 * override / load_efficiency
    a = np.array([[-1.0 / lag, 0.0, 0.0],
                  [stiffness * pump_speed, -stiffness * leakage, -stiffness * motor],
                  [0.0, efficiency * motor / inertia, -drag / inertia]])
    return Plant(a, np.array([table / lag, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), 'test rig')


def first_order(gain=1.0, lag=0.1):
    """Return a lag of first order."""
    return Plant(np.array([[-1.0 / lag]]), np.array([gain / lag]), np.array([1.0]))


def simulate(plant, kp, ki, count=4000):
    """Return the sampled output of the loop after a kick, stepping the plant with SciPy."""
    a, b = discretise(plant, TS)
    state, integral, out = np.full(len(a), 1e-3), 0.0, []
    for _ in range(count):
        speed = float(plant.c @ state)
        out.append(speed)
        command = -kp * speed + integral
        integral -= ki * TS * speed
        state = a @ state + b * command
    return np.array(out)


@given(st.floats(2.0, 100.0), st.floats(0.02, 1.0))
def test_first_order_plant_has_closed_form(kp, lag):
    """P control of a held lag: the loop is kp b / (z - a), solved by hand."""
    a = math.exp(-TS / lag)
    b = 1.0 - a
    found = margins(first_order(lag=lag), kp, 0.0, TS)
    if kp * b < 0.99 * (1 + a):
        assert found.gain_margin == pytest.approx((1 + a) / (kp * b), rel=1e-9)
    cosine = (1 + a * a - (kp * b)**2) / (2 * a)
    if abs(cosine) < 0.99:
        z = complex(cosine, math.sqrt(1 - cosine**2))
        phase = math.remainder(math.atan2(z.imag, z.real - a), 2 * math.pi)
        assert found.phase_margin == pytest.approx(math.pi - phase, rel=1e-2)
        assert found.crossover == pytest.approx(math.acos(cosine) / TS, rel=1e-2)
        assert found.stable == (kp * b < 1 + a)


def test_hold_is_exact():
    plant = linear_drive()
    a, b = discretise(plant, TS)
    exact = solve_ivp(lambda _, x: plant.a @ x + plant.b, (0.0, TS), np.array([1e-6, 1e5, 1.0]),
                      method='Radau', rtol=1e-10, atol=1e-14).y[:, -1]
    assert a @ np.array([1e-6, 1e5, 1.0]) + b == pytest.approx(exact, rel=1e-7)


def test_resonance_of_the_drive_in_closed_form():
    """Undamped: sqrt(eta K D^2 / (V J)), Eqs. (1), (4) and (8) of the drill-drive paper."""
    plant = linear_drive(leakage=0.0, override=0.0)
    found = margins(plant, 0.02, 0.45, TS)
    expected = math.sqrt(0.88 * 1.2e9 / 0.9e-3 / 0.35) * 195e-6 / (2 * math.pi)
    assert found.resonance == pytest.approx(expected, rel=1e-6)
    assert found.resonance_damping == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.1, 3.0), st.floats(0.1, 3.0))
def test_gain_margin_is_where_the_loop_starts_to_grow(kp_scale, ki_scale):
    plant = linear_drive()
    kp, ki = 0.02 * kp_scale, 0.45 * ki_scale
    found = margins(plant, kp, ki, TS)
    if not found.stable or math.isinf(found.gain_margin):
        return
    factor = found.gain_margin
    loop = Loop(plant, TS)
    assert np.abs(loop.closed_loop_poles(kp * factor, ki * factor)).max() == pytest.approx(
        1.0, abs=2e-3)
    below = simulate(plant, 0.95 * factor * kp, 0.95 * factor * ki)
    above = simulate(plant, 1.05 * factor * kp, 1.05 * factor * ki)
    assert np.abs(below[-500:]).max() < np.abs(below[:500]).max()
    assert np.abs(above[-500:]).max() > np.abs(above[:500]).max()


@pytest.mark.parametrize('delay', (0, 1, 3))
def test_delay_takes_margin_away(delay):
    """A delay of whole samples costs its phase at the crossover, and nothing else."""
    plant = linear_drive()
    without = Loop(plant, TS)
    delayed = Loop(plant, TS, delay)
    assert np.abs(delayed.loop_gain(0.02, 0.45)) == pytest.approx(
        np.abs(without.loop_gain(0.02, 0.45)))
    a, b = without.margins(0.02, 0.45), delayed.margins(0.02, 0.45)
    assert a.phase_margin - b.phase_margin == pytest.approx(
        delay * TS * a.crossover, abs=2e-3)
    poles = delayed.closed_loop_poles(0.02, 0.45)
    assert len(poles) == 4 + delay
    assert (np.abs(poles).max() < 1.0) == b.stable


@pytest.mark.filterwarnings('error')
def test_without_gains_nothing_can_become_unstable():
    found = margins(linear_drive(), 0.0, 0.0, TS)
    assert found.stable and found.phase_margin == found.gain_margin == math.inf
    assert found.crossover == found.resonance_gain == 0.0 and found.sensitivity_peak == 1.0


def test_sensitivity_peak_bounds_the_margins():
    """|1 + L| >= 1 / Ms gives PM >= 2 asin(1 / (2 Ms)) and GM >= Ms / (Ms - 1)."""
    found = margins(linear_drive(), 0.02, 0.45, TS)
    peak = found.sensitivity_peak
    assert found.phase_margin >= 2 * math.asin(0.5 / peak) - 1e-3
    assert found.gain_margin >= peak / (peak - 1) - 1e-3


def test_chosen_gains_meet_what_was_asked():
    plants = [linear_drive(), linear_drive(leakage=4e-12, efficiency=0.8),
              linear_drive(override=0.0)]
    wanted = (math.radians(60.0), 2.0, 2.0)
    kp, ki = choose_gains(plants, TS)
    assert all(meets(margins(plant, kp, ki, TS), *wanted) for plant in plants)
    assert not all(meets(margins(plant, 1.3 * kp, 1.3 * ki, TS), *wanted) for plant in plants)


def test_impossible_wishes_are_refused():
    unstable = Plant(np.array([[5.0]]), np.array([1.0]), np.array([1.0]))
    with pytest.raises(ValueError, match='no PI gains'):
        choose_gains([unstable], TS, phase_margin=math.radians(89.0), gain_margin=10.0)
