# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where in the oil the resistance of a line lies: closed forms, and two volumes by SciPy."""
from test.model.reference import Reference

from hst_drive.model import Drive
from hst_drive.model.steady import operating_point
from hst_drive.rig import default_rig
import numpy as np
import pytest
from scipy.integrate import solve_ivp
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
    """Oil before the resistance takes up its share of what the pump delivers beyond the flow."""
    signals = ringing(share)
    lost = signals['pump_outlet_pressure'] - signals['motor_inlet_pressure']
    through = share * signals['motor_inlet_flow'] + (1.0 - share) * signals['pump_flow']
    np.testing.assert_allclose(lost, RESISTANCE * through, rtol=1e-6)


class TwoVolumes(Reference):
    """The drive with a resistance (Pa.s/m^3) in its oil; the last state is what lies behind."""

    def __init__(self, share, resistance):
        super().__init__()
        self.share, self.resistance = share, resistance

    def rates(self, x, u, v):
        *drive, far = x
        through = (x[1] - far) / self.resistance
        rates = super().rates([x[0], far, x[2], x[3]], u, v)
        delivered = x[0] * self.w_pump - self.q_leak_pump(x[1], u) - self.q_relief(x[1])
        taken = self.d_motor * x[2] + self.q_leak_motor(far, x[2])
        stiff = self.bulk / self.volume
        rates[1] = stiff * (delivered - through) / self.share
        return [*rates, stiff * (through - taken) / (1.0 - self.share)]

    def after(self, command, pprv, step):
        """Return the states at ``TIME`` after a step of the pump command from where it stood."""
        start, end = [3e-5, 60e5, 10.0, 40e5, 50e5], 20.0
        for u, time in ((command, [0.0, end]), (command + step, TIME)):
            found = solve_ivp(lambda t, x, u=u: self.rates(x, u, pprv), (0.0, time[-1]), start,
                              'Radau', time, rtol=1e-8, atol=1e-9)
            start = found.y[:, -1]
        return found.y


@pytest.mark.parametrize('share', [0.3, 0.7])
def test_a_resistance_between_two_volumes(share):
    resistance, settling = 2e9, 20_000
    drive = Drive(RIG, {'line_loss': {'laminar': resistance, 'turbulent': 0.0,
                                      'viscosity_share': 0.0, 'upstream_share': share}})
    point = operating_point(drive, 10.0, 100.0)
    count = settling + len(TIME)
    signals = drive.simulate(np.arange(count) * 1e-3, {
        'pump_command': point.pump_command + 0.3 * (np.arange(count) >= settling),
        'pprv_command': np.full(count, point.pprv_command)}, point.state.copy())
    _, near, speed, _, far = TwoVolumes(share, resistance).after(
        point.pump_command, point.pprv_command, 0.3)
    for name, expected in (('pump_outlet_pressure', near), ('motor_inlet_pressure', far),
                           ('motor_speed', speed)):
        error = np.abs(signals[name][settling:] - expected).max() / np.ptp(expected)
        assert error < 0.015, name


def test_a_resistance_before_all_of_the_oil_leaves_the_motion_alone():
    np.testing.assert_allclose(ringing(0.0)['motor_speed'], ringing(None)['motor_speed'],
                               rtol=1e-9)


def test_a_resistance_behind_all_of_the_oil_damps():
    """J*dw/dt = eta*D*(P - R*D*w): the rate of decay gains eta*R*D^2/(2*J)."""
    displacement, inertia = RIG.motor.displacement, RIG.motor.inertia
    efficiency = RIG.motor.mechanical_efficiency(60e5, 10.0)
    expected = efficiency * RESISTANCE * displacement**2 / (2.0 * inertia)
    assert decay(ringing(1.0)) - decay(ringing(0.0)) == pytest.approx(expected, rel=0.15)
