# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Operating points, the linearised drive and conservation, against formulas by hand."""
import math

from hst_drive.errors import InputError
from hst_drive.model import Drive
from hst_drive.model.lags import follow
from hst_drive.model.part import PartModel
from hst_drive.model.steady import linearise, operating_point
from hst_drive.rig import default_rig
import numpy as np
import pytest

from .reference import Reference

RPM = math.pi / 30


@pytest.mark.parametrize('load, quantity, paper', [
    (None, 'command', 5.601), (223.5, 'pressure', 82.2e5), (241.1, 'pressure', 88.43e5),
    (241.1, 'command', 5.781)])
def test_operating_points_of_the_paper(load, quantity, paper):
    """At 100 rpm; without a load the PPRV is fully open."""
    pprv = {'pprv_command': 0.0} if load is None else {'load_torque': load}
    point = operating_point(Drive(default_rig()), 100 * RPM, **pprv)
    found = (point.pump_command if quantity == 'command'
             else point.readings['pump_outlet_pressure'])
    assert found == pytest.approx(paper, rel=0.005)
    if load is not None:
        assert point.readings['load_torque'] == pytest.approx(load, rel=1e-6)


@pytest.mark.parametrize('speed, load', [(20, 60.0), (80, 150.0), (100, 241.1), (170, 300.0)])
def test_every_balance_is_at_rest_in_an_operating_point(speed, load):
    reference, drive = Reference(), Drive(default_rig())
    point = operating_point(drive, speed * RPM, load)
    rates = reference.rates(point.state[:4], point.pump_command, point.pprv_command)
    # Rates per second against the size of the state.
    assert np.max(np.abs(np.array(rates) / point.state[:4])) < 1e-4
    later = drive.advance(point.state, 2.0, pump_command=point.pump_command,
                          pprv_command=point.pprv_command)
    np.testing.assert_allclose(later[:4], point.state[:4], rtol=1e-5)


@pytest.mark.parametrize('compliance, hardening', [(0.003, 0.0), (0.003, 30.0), (0.0, 0.0)])
def test_a_twisted_shaft_is_at_rest_in_an_operating_point(compliance, hardening):
    drive = Drive(default_rig(), {
        'shaft_compliance': {'compliance': compliance, 'hardening': hardening}})
    point = operating_point(drive, 10.0, 150.0)
    stiff = operating_point(Drive(default_rig()), 10.0, 150.0)
    assert point.readings['load_torque'] == pytest.approx(150.0, rel=1e-6)
    assert point.pump_command == pytest.approx(stiff.pump_command, rel=1e-6)
    later = drive.advance(point.state, 1.0, pump_command=point.pump_command,
                          pprv_command=point.pprv_command)
    np.testing.assert_allclose(later[:7], point.state[:7] + [0, 0, 0, 0, 10.0, 0, 0], rtol=1e-4)


@pytest.mark.parametrize('speed, load, expected', [
    (400, 100.0, 'beyond what the pump gives'), (100, 5000.0, 'more than the loading unit brakes'),
])
def test_points_out_of_reach(speed, load, expected):
    with pytest.raises(InputError, match=expected):
        operating_point(Drive(default_rig()), speed * RPM, load)


def slope(function, x, step):
    """Return the derivative inside a cell of a table."""
    return (function(x + step) - function(x - step)) / (2 * step)


@pytest.mark.parametrize('speed, load', [(30, 120.0), (80, 165.0), (120, 260.0)])
def test_hydraulic_resonance(speed, load):
    """
    Frequency and damping of {P, w} by hand.

    Oil spring and inertia make the resonance; leakage, the slope of the efficiency and the
    override of the PPRV damp it.
    """
    r = Reference()
    drive = Drive(default_rig())
    point = operating_point(drive, speed * RPM, load)
    p, w, pprv, u = *point.state[1:4], point.pump_command
    dp, dw = 10.0, 1e-5
    stiffness = r.bulk / r.volume
    leak_p = slope(lambda x: r.q_leak_pump(x, u) + r.q_leak_motor(x, w), p, dp)
    leak_w = slope(lambda x: r.q_leak_motor(p, x), w, dw)
    torque_p = slope(lambda x: r.torque_motor(x, w), p, dp)
    torque_w = slope(lambda x: r.torque_motor(p, x), w, dw)
    brake_w = slope(lambda x: r.torque_load(pprv, x), w, dw)
    a11, a12 = -stiffness * leak_p, -stiffness * (r.d_motor + leak_w)
    a21, a22 = torque_p / r.inertia, (torque_w - brake_w) / r.inertia
    frequency = math.sqrt(a11 * a22 - a12 * a21)
    damping = -(a11 + a22) / (2 * frequency)
    assert 8 < frequency / (2 * math.pi) < 11 and 0.02 < damping < 0.2

    model = linearise(drive, point)
    poles = np.linalg.eigvals(model.a)
    pair = poles[np.argmax(poles.imag)]
    assert abs(pair) == pytest.approx(frequency, rel=1e-3)
    assert -pair.real / abs(pair) == pytest.approx(damping, rel=5e-3)
    lags = sorted(poles[np.abs(poles.imag) < 1e-6].real)
    assert lags == pytest.approx([-1 / r.lag_pprv, -1 / r.lag_pump], rel=1e-3)
    assert model.a[1:3, 1:3] == pytest.approx(np.array([[a11, a12], [a21, a22]]), rel=5e-3)
    # Gain of the command: slope of the displacement table over the lag.
    gain = slope(r.displacement, u, 1e-4) / r.lag_pump
    assert model.b[0, 0] == pytest.approx(gain, rel=1e-3)


def test_oil_that_stiffens_under_pressure():
    """The squared resonance goes with the stiffness at the pressure of the point."""
    found = []
    for factor in (1.0, 0.8):
        drive = Drive(default_rig())
        drive.scale({'line.compressibility_under_pressure': factor})
        point = operating_point(drive, 80 * RPM, 150.0)
        poles = np.linalg.eigvals(linearise(drive, point).a)
        found.append(abs(poles[np.argmax(poles.imag)])**2)
    share = point.state[1] / default_rig().relief_valve.set_pressure
    assert found[1] / found[0] == pytest.approx(1.0 / (1.0 - 0.2 * share), rel=2e-3)


@pytest.mark.parametrize('softness', [0.0, 0.5], ids=['hard', 'soft'])
def test_a_play_that_has_settled_is_not_in_the_linear_model(softness):
    """The nudged command is one on which the plate has settled: no move that a play takes up."""
    offset = {'pump_command_offset': {'offset': -0.2}}
    play = {'pump_hysteresis': {'width': 0.35, 'softness': softness, 'spread': 0.3}}
    free, held = (linearise(drive, operating_point(drive, 80 * RPM, 150.0)) for drive in (
        Drive(default_rig(), offset), Drive(default_rig(), {**offset, **play})))
    assert held.b[0, 0] == pytest.approx(free.b[0, 0], rel=1e-6)


def test_the_ringing_after_a_step_has_the_resonance_of_the_linear_model():
    drive = Drive(default_rig())
    point = operating_point(drive, 80 * RPM, 150.0)
    poles = np.linalg.eigvals(linearise(drive, point).a)
    pair = poles[np.argmax(poles.imag)]
    state = point.state.copy()
    state[1] += 0.5e5
    time = np.arange(0, 1.0, 1e-3)
    held = {'pump_command': np.full(len(time), point.pump_command),
            'pprv_command': np.full(len(time), point.pprv_command)}
    ring = drive.simulate(time, held, state)['pump_outlet_pressure'] - point.state[1]
    crossings = np.flatnonzero(np.diff(np.sign(ring)))[:9]
    at = time[crossings] - ring[crossings] * 1e-3 / (ring[crossings + 1] - ring[crossings])
    assert math.pi / np.mean(np.diff(at)) == pytest.approx(pair.imag, rel=0.01)


@pytest.fixture(scope='module')
def record():
    """Return a fine record with steps of command and load, the relief valve open for a while."""
    time = np.arange(0, 6.0, 2.5e-4)
    drive = Drive(default_rig())
    point = operating_point(drive, 60 * RPM, 100.0)
    pump = np.select([time < 1, time < 3, time < 5], [point.pump_command, 6.0, 5.0], 6.5)
    pprv = np.select([time < 2, time < 4, time < 5.5], [point.pprv_command, 3.9, 2.8], 9.5)
    out = drive.simulate(time, {'pump_command': pump, 'pprv_command': pprv}, point.state.copy())
    assert out['pump_outlet_pressure'].min() > 5e5
    assert out['relief_flow'].max() > 1e-4
    return time, out


def cumulated(time, values):
    """Return the running integral by the trapezoid rule."""
    return np.concatenate([[0.0], np.cumsum(np.diff(time) * (values[1:] + values[:-1]) / 2)])


def test_oil_volume_is_conserved(record):
    time, out = record
    r = Reference()
    net = cumulated(time, out['pump_flow'] - out['relief_flow'] - out['motor_inlet_flow'])
    pressure = out['pump_outlet_pressure']
    stored = r.volume / r.bulk * (pressure - pressure[0])
    assert np.max(np.abs(net - stored)) < 1e-3 * np.ptp(stored)


def test_energy_is_conserved(record):
    time, out = record
    r = Reference()
    p, w = out['pump_outlet_pressure'], out['motor_speed']
    given = p * out['pump_flow']
    lost = (p * (out['relief_flow'] + out['case_drain_flow'])
            + (p * r.d_motor - out['motor_torque_hydraulic']) * w)
    assert np.all(lost > 0)
    load = out['load_torque'] * w
    stored = r.volume / r.bulk * p**2 / 2 + r.inertia * w**2 / 2
    missing = cumulated(time, given - lost - load) - (stored - stored[0])
    assert np.max(np.abs(missing)) < 1e-3 * cumulated(time, given)[-1]
    # The turn-over of stored energy is small beside what flows through: hold it, too.
    assert np.max(np.abs(missing)) < 1e-2 * np.ptp(stored)


@pytest.mark.parametrize('limits', [(), (1e12, 1e12)])     # as equations, and step by step
def test_a_lag_of_its_own_on_the_way_back_is_an_exponential_each_way(limits):
    time = np.cumsum(np.random.default_rng(3).uniform(0.001, 0.02, 2000))
    time -= time[0]
    back = time[1000]
    found = follow(time, np.where((time > 0) & (time < back), 1.0, 0.0), 0.4, *limits,
                   back_lag=1.5)
    top = -math.expm1(-(back - time[1]) / 0.4)
    assert found == pytest.approx(np.where(
        time < back, -np.expm1(-np.maximum(time - time[1], 0.0) / 0.4),
        top * np.exp(-np.maximum(time - back, 0.0) / 1.5)), abs=1e-12)


@pytest.mark.parametrize('row', [0.002, 0.02, 0.1])
@pytest.mark.parametrize('share', [0.005, 0.1, 0.3])
def test_a_lag_before_the_plates_own_is_the_sum_of_two_exponentials(row, share):
    """However far apart the rows of a log of a part are."""
    pump = default_rig().pump
    time = np.arange(0.0, 1.0, row)
    since = np.maximum(time - time[len(time) // 4], 0.0)
    found = PartModel(default_rig(), {}, {'pump.displacement_series_lag': 1.0 + share}).stroke(
        time, np.where(np.arange(len(time)) < len(time) // 4, 3.0, 6.0), {})
    before, after = pump.displacement(np.array([3.0, 6.0]))
    lags = np.array([1.0, share]) * pump.displacement_lag
    left = lags[:, None] * np.exp(-since / lags[:, None]) / (lags[0] - lags[1])
    assert found == pytest.approx(after - (after - before) * (left[0] - left[1]), rel=1e-9)
