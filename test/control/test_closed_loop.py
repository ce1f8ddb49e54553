# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The controller on the whole nonlinear drive: margins that hold there, not only on paper."""
import math

from hst_drive.control import PiController
from hst_drive.control.margins import margins, Plant
from hst_drive.model import Drive
from hst_drive.model.steady import linearise, operating_point
from hst_drive.rig import default_rig
import numpy as np
import pytest

SPEED = 100.0 * math.pi / 30.0
STEP = 0.01


@pytest.fixture(scope='module')
def drive():
    return Drive(default_rig())


def run(drive, point, kp, ki, count, kick=0.05, command=None):
    """Close the loop at an operating point after a kick to the speed; return the errors, rad/s."""
    control = PiController(kp, ki, STEP, (0.0, 10.0))
    control.reset(point.pump_command)
    inputs = {'pprv_command': point.pprv_command if command is None else command,
              'oil_temperature': point.oil_temperature}
    state, errors = point.state.copy(), []
    control.update(SPEED, SPEED)
    state[2] += kick
    for _ in range(count):
        errors.append(state[2] - SPEED)
        state = drive.advance(state, STEP, pump_command=control.update(SPEED, state[2]), **inputs)
    return np.array(errors)


def test_loop_turns_unstable_where_the_gain_margin_says(drive):
    point = operating_point(drive, SPEED, 223.5)
    linear = linearise(drive, point)
    factor = margins(Plant(linear.a, linear.b[:, 0], linear.c[0]), 0.02, 0.45, STEP).gain_margin
    below = run(drive, point, 0.02 * 0.85 * factor, 0.45 * 0.85 * factor, 600)
    above = run(drive, point, 0.02 * 1.15 * factor, 0.45 * 1.15 * factor, 600)
    assert np.abs(below[-100:]).max() < 0.1 * np.abs(below[:100]).max()
    assert np.abs(above[-100:]).max() > 2.0 * np.abs(above[:100]).max()


def test_step_of_the_paper_is_held(drive):
    """223.5 to 241.1 N.m: small excursion, back at 100 rpm, the command that the paper gives."""
    before, after = (operating_point(drive, SPEED, torque) for torque in (223.5, 241.1))
    errors = run(drive, before, 0.02, 0.45, 1000, kick=0.0, command=after.pprv_command)
    assert np.abs(errors).max() < 0.08 * SPEED
    assert np.abs(errors[-100:]).max() < 1e-3 * SPEED
    assert after.pump_command == pytest.approx(5.781, rel=0.005)
