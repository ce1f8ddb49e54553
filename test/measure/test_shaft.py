# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a torque sensor on a flexible shaft tells of the load, against the equations solved."""
from hst_drive.effects.slots import USUAL_DAMPING_TIME
from hst_drive.measure.noise import Coloured
from hst_drive.measure.shaft import Behind, behind, load_side, LoadSide
from hst_drive.model import Drive
from hst_drive.model.steady import twist_at
from hst_drive.rig import default_rig
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.signal import lsim

from .synthetic import coloured

SIDE = LoadSide(0.0025, 0.2, 0.004, 1.5)
STEP = 0.005
TIME = np.arange(4000) * STEP


def swung(load, held_speed=8.0):
    """Return the torque in the shaft whose other end turns steadily, by an ODE solver."""
    def torque(twist, speed):
        return (twist + SIDE.damping_time * (held_speed - speed)) / SIDE.compliance

    def rates(time, state):
        twist, speed = state
        behind_it = np.interp(time, TIME, load) + SIDE.slope * (speed - held_speed)
        return held_speed - speed, (torque(twist, speed) - behind_it) / SIDE.inertia

    found = solve_ivp(rates, (0.0, TIME[-1]), (SIDE.compliance * load[0], held_speed),
                      t_eval=TIME, rtol=1e-8, atol=1e-10, max_step=STEP)
    return torque(*found.y)


def loads():
    """Return a load that steps, and swings near the shaft's resonance."""
    return 100.0 + 20.0 * (TIME > 7.0) + 3.0 * np.sin(40.0 * TIME)


def test_the_load_is_found_again():
    rough = Coloured(5.0, 0.1, 0.01)
    found = Behind(SIDE, STEP, 0.0, rough).load(swung(loads()))
    inner = (TIME > 2.0) & (TIME < 18.0) & (np.abs(TIME - 7.0) > 0.5)
    assert found[inner] == pytest.approx(loads()[inner], abs=0.5)


def test_noise_is_not_taken_for_load():
    noise = 0.5 * np.random.default_rng(1).standard_normal(len(TIME))
    found = behind(SIDE, STEP, noise, 0.5, 0.0)
    assert np.std(found.load(noise)) < 0.15
    assert found.rough.noise_std == pytest.approx(0.5, rel=0.1)


@pytest.mark.parametrize('speed_noise', [0.0, 0.02])
def test_how_rough_the_load_is_its_spectrum_tells(speed_noise):
    """Noise of the speed moves the inertia behind the shaft: in the reading, not in the load."""
    random = np.random.default_rng(4)
    time = np.arange(0.0, 60.0, STEP)
    load = coloured(random, len(time), STEP, 3.0, 0.2)
    turning = lsim(([SIDE.damping_time, 1.0], [
        SIDE.compliance * SIDE.inertia, SIDE.damping_time + SIDE.compliance * SIDE.slope, 1.0]),
        load, time)[1]
    rate = speed_noise * np.gradient(random.standard_normal(len(time)), STEP) * SIDE.inertia
    shaken = lsim(([SIDE.damping_time, 1.0], [
        SIDE.compliance * SIDE.inertia, SIDE.damping_time + SIDE.compliance * SIDE.slope, 1.0]),
        rate, time)[1]
    reading = turning + shaken + 0.3 * random.standard_normal(len(time))
    found = behind(SIDE, STEP, reading, 1.0, speed_noise)
    assert found.rough.std == pytest.approx(3.0, rel=0.2)
    assert found.rough.time_constant == pytest.approx(0.2, rel=0.4)
    assert found.rough.noise_std == pytest.approx(0.3, rel=0.2)
    missed = found.draw_error(STEP, len(time), random)
    assert np.std(missed) == pytest.approx(np.std(found.load(reading) - load), rel=0.25)


@pytest.mark.parametrize('hardening', [0.0, 20.0])
def test_a_reading_follows_the_measured_speed_as_the_equations_do(hardening):
    drive = Drive(default_rig(), {'shaft_compliance': {
        'compliance': 0.003, 'load_side_share': 0.4, 'hardening': hardening,
        'damping_time': 0.002}})
    stiff = drive.without('shaft_compliance')
    time = np.arange(600) * STEP
    speed = 9.0 + 0.4 * np.sin(40.0 * time) + 0.5 * np.tanh(20.0 * (time - 1.0))
    volts, warm = np.full(len(time), 2.5), np.full(len(time), 323.15)
    grid = np.linspace(5.0, 13.0, 200)
    given = stiff.load_torque(np.arange(200.0), np.full(200, 2.5), grid, np.full(200, 323.15))
    inertia = 0.4 * default_rig().motor.inertia

    def torque(twist, slip):
        return (twist + 0.002 * slip) / 0.003 * (1.0 + hardening * twist**2)

    def rates(now, state):
        slip = CubicSpline(time, speed)(now) - state[1]
        return slip, (torque(state[0], slip) - np.interp(state[1], grid, given)) / inertia

    start = brentq(lambda twist: torque(twist, 0.0) - np.interp(speed[0], grid, given), 0.0, 2.0)
    found = solve_ivp(rates, (0.0, time[-1]), (start, speed[0]), t_eval=time, rtol=1e-8,
                      atol=1e-10, max_step=STEP)
    expected = torque(found.y[0], speed - found.y[1])
    shown = drive.load_torque(time, volts, speed, warm)
    assert np.ptp(expected) > 8.0
    assert shown == pytest.approx(expected, abs=0.01 * np.ptp(expected))


def test_what_is_behind_the_shaft_of_a_drive():
    torque = np.full(10, 120.0)
    assert load_side(Drive(default_rig()), torque, lambda faster: torque) is None
    drive = Drive(default_rig(), {'shaft_compliance': {
        'compliance': 0.002, 'load_side_share': 0.6, 'hardening': 5.0,
        'damping_time': USUAL_DAMPING_TIME}})
    side = load_side(drive, torque, lambda faster: torque + 1.5 * faster)
    assert side.inertia == pytest.approx(0.6 * default_rig().motor.inertia)
    assert side.slope == pytest.approx(1.5)
    # T = twist*(1 + hardening*twist^2)/compliance: a cubic, and its slope at 120 N.m.
    twist = twist_at(drive, 120.0)
    assert twist == pytest.approx(np.roots([5.0, 0.0, 1.0, -0.002 * 120.0])[2].real)
    stiffness = (1.0 + 15.0 * twist**2) / 0.002
    assert side.compliance == pytest.approx(1.0 / stiffness, rel=1e-4)
    damping = USUAL_DAMPING_TIME * (1.0 + 5.0 * twist**2) / 0.002
    assert side.damping_time == pytest.approx(damping / stiffness, rel=1e-4)
