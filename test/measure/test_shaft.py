# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a torque sensor on a flexible shaft tells of the load, against the equations solved."""
from hst_drive.effects.base import USUAL_DAMPING_TIME
from hst_drive.measure.noise import Coloured
from hst_drive.measure.shaft import behind, load_side, LoadSide, read, twist_at
from hst_drive.model import Drive
from hst_drive.rig import default_rig
import numpy as np
import pytest
from scipy.integrate import solve_ivp

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


def test_the_sensor_reads_what_the_equations_give():
    inner = slice(400, -400)
    assert read(SIDE, STEP, loads())[inner] == pytest.approx(swung(loads())[inner], abs=0.5)


def test_the_load_is_found_again():
    found = behind(SIDE, STEP, swung(loads()), Coloured(5.0, 0.1, 0.01))
    inner = (TIME > 2.0) & (TIME < 18.0) & (np.abs(TIME - 7.0) > 0.5)
    assert found[inner] == pytest.approx(loads()[inner], abs=0.5)


def test_noise_is_not_taken_for_load():
    noise = 0.5 * np.random.default_rng(1).standard_normal(len(TIME))
    found = behind(SIDE, STEP, noise, Coloured(0.3, 0.1, 0.5))
    assert np.std(found) < 0.15


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
