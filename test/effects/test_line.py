# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where in the oil the resistance of a line lies: closed forms of the linearised drive."""
from hst_drive.model import Drive
from hst_drive.model.steady import operating_point
from hst_drive.rig import default_rig
import numpy as np
import pytest
from scipy.optimize import curve_fit

RIG = default_rig()
RESISTANCE = 6e8    # Pa.s/m^3
TIME = np.arange(0.0, 1.0, 1e-3)


def ringing(share):
    """Return the drive's signals after a small step of the pump command; share None: no line."""
    drive = Drive(RIG, {} if share is None else {'line_loss': {
        'laminar': RESISTANCE, 'turbulent': 0.0, 'viscosity_share': 0.0,
        'upstream_share': share}})
    point = operating_point(drive, 10.0, 100.0)
    commands = {'pump_command': np.full(len(TIME), point.pump_command + 0.05),
                'pprv_command': np.full(len(TIME), point.pprv_command)}
    return drive.simulate(TIME, commands, point.state.copy())


def decay(signals):
    """Return the rate (1/s) at which the swing of the speed dies down."""
    def swing(time, end, slow, lag, size, rate, frequency, phase):
        return end + slow * np.exp(-time / lag) + size * np.exp(-rate * time) * np.sin(
            frequency * time + phase)

    speed = signals['motor_speed'] * 100.0
    guess = (speed[-1], -1.0, 0.05, 3.0, 5.0, 45.0, 0.0)
    found, _ = curve_fit(swing, TIME, speed, guess, maxfev=20000)
    return found[4]


@pytest.mark.parametrize('share', [0.0, 0.3, 1.0])
def test_the_hydromotor_gets_what_the_line_leaves(share):
    signals = ringing(share)
    lost = signals['pump_outlet_pressure'] - signals['motor_inlet_pressure']
    np.testing.assert_allclose(lost, RESISTANCE * signals['motor_inlet_flow'], rtol=1e-6)


def test_a_resistance_before_all_of_the_oil_leaves_the_motion_alone():
    np.testing.assert_allclose(ringing(0.0)['motor_speed'], ringing(None)['motor_speed'],
                               rtol=1e-9)


def test_a_resistance_behind_all_of_the_oil_damps():
    """J*dw/dt = eta*D*(P - R*D*w): the rate of decay gains eta*R*D^2/(2*J)."""
    displacement, inertia = RIG.motor.displacement, RIG.motor.inertia
    efficiency = RIG.motor.mechanical_efficiency(60e5, 10.0)
    expected = efficiency * RESISTANCE * displacement**2 / (2.0 * inertia)
    assert decay(ringing(1.0)) - decay(ringing(0.0)) == pytest.approx(expected, rel=0.15)
