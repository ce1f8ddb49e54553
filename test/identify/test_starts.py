# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where fits start, on a drive in closed form that stalls where friction is too high."""
from hst_drive.effects import catalogue
from hst_drive.identify.model import Model
from hst_drive.identify.starts import starts
import numpy as np
import pytest

NAME, STALLS = 'stribeck_friction', 6.0     # N.m, where the shaft stands still
SPEED = np.linspace(0.3, 12.0, 200)         # rad/s
TRUE = 4.0 * np.exp(-SPEED / 4.0)           # N.m, the exponential form


class Stalling:
    """A campaign of one signal: the friction that is missing; too much of it stops the shaft."""

    by_balance, starts_known, adopted = False, False, {}
    signals, sizes = ('motor_speed',), (1.0, 1.0, 1.0)

    def typical(self, name):
        return catalogue()[name].typical

    def off(self, name):
        return catalogue()[name].neutral

    def parameter(self, name, key):
        return catalogue()[name].parameter(key)

    def errors(self, model, *, to_fit=False, known=None):
        values = model.effects.get(NAME)
        if values is None:
            return [TRUE]
        found = np.array([catalogue()[NAME].function(float(speed), **values) for speed in SPEED])
        return [np.full(len(SPEED), 50.0) if values['torque'] > STALLS else TRUE - found]

    def training(self, errors):
        return errors[0]


def test_every_form_starts_at_a_size_with_which_the_drive_turns():
    assert catalogue()[NAME].typical['torque'] > STALLS
    found = [model.effects[NAME] for model in starts(
        Stalling(), np.zeros((len(SPEED), 0)), Model(), NAME, None)]
    exact = next(values for values in found if values['shape'] == 1.0)
    assert exact['torque'] == pytest.approx(4.0, rel=0.05)
