# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Each effect in the drive, against closed forms and against the sensors' noise."""
import math

from hst_drive.effects import catalogue
from hst_drive.effects.entrained_air import compliance
from hst_drive.effects.oil import GRADES, viscosity
from hst_drive.model import Drive
from hst_drive.model.compose import kernel
from hst_drive.model.part import PartModel
from hst_drive.model.steady import operating_point
from hst_drive.resources import share
from hst_drive.rig import default_rig
from hst_drive.rig.yaml_file import read_yaml
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import CubicSpline

RIG = default_rig()
THINNER = viscosity(343.15, 'ISO VG 46') / viscosity(323.15, 'ISO VG 46')
RPM = math.pi / 30.0
READINGS = ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque')
COMMANDS = {'pump_command': 5.5, 'pprv_command': 4.0}


def hydromotor_torque(pressure, speed):
    """Return what the tables give: measured without a pressure at the outlet."""
    return pressure * RIG.motor.displacement * RIG.motor.mechanical_efficiency(pressure, speed)


def at(effects, *, pressure=90e5, speed=10.0, command=5.5, temperature=None):
    """Return the readings in one state, settled on its commands."""
    drive = Drive(RIG, effects)
    state = drive.initial_state(pump_command=command, pprv_command=4.0, pressure=pressure,
                                speed=speed)
    return drive.outputs(state, pump_command=command, pprv_command=4.0,
                         oil_temperature=temperature)


def differ(effects, name, **state):
    """Return how far effects move a reading in one state."""
    return at(effects, **state)[name] - at({}, **state)[name]


def excited(n=600):
    """Return time and inputs that exercise the whole drive in 12 s."""
    time = 0.02 * np.arange(n)
    return time, {
        'pump_command': 4.5 + 2.5 * np.sin(0.9 * time) + 1.2 * np.sign(np.sin(2.3 * time)),
        'pprv_command': 3.5 + 2.0 * np.sign(np.sin(1.3 * time)),
        'oil_temperature': 323.15 + 15.0 * np.sin(0.3 * time)}


def test_what_a_hydromotor_takes_along_is_not_drained():
    """Oil that it compresses leaves by its outlet: the meter reads it, the case drain does not."""
    taken = {'compressibility_flow': {'volume_ratio': 2.0, 'in_motor': 1.0}}
    assert differ(taken, 'motor_inlet_flow') == pytest.approx(
        2.0 * RIG.motor.displacement * 10.0 * 90e5 / RIG.line.bulk_modulus, rel=1e-6)
    assert differ(taken, 'case_drain_flow') == 0.0
    # Beside a leak, which both read.
    more, leak = ({'motor_leakage': {'conductance': 1e-12, 'exponent': 1.0}, **entry}
                  for entry in (taken, {}))
    known = {'pressure': np.array([90e5]), 'motor_speed': np.array([10.0])}
    drains = [model.case_drain(model.complete(known)) for model in (
        PartModel(RIG, entry) for entry in ({}, leak, more))]
    assert drains[2] == drains[1] > drains[0]


# Not those of other circuits, nor what is felt at the pump's shaft alone.
@pytest.mark.parametrize('name', sorted(kernel(False).usable & set(catalogue())))
def test_typical_size_shows(name):
    """At its typical size an effect moves a reading by more than the noise of its sensor."""
    time, inputs = excited()
    with_it, without = (Drive(RIG, effects).simulate(time, inputs)
                        for effects in ({name: {}}, {}))
    moved = {channel: np.sqrt(np.mean((with_it[channel] - without[channel])**2))
             / RIG.sensors[channel].noise_std for channel in READINGS}
    assert max(moved.values()) > 3.0, moved
    shown = [moved[channel] for channel in catalogue()[name].shows_in if channel in moved]
    assert max(shown) > 3.0, (moved, 'not in the channels that the effect names')


@pytest.mark.parametrize('name', sorted(set(catalogue()) - {'shaft_compliance'}))
def test_switched_on_at_neutral_changes_nothing(name):
    """An effect that is on at its neutral parameters leaves the baseline to the last digit."""
    time, inputs = excited(100)
    off = catalogue()[name].neutral
    with_it, without = (Drive(RIG, effects).simulate(time, inputs)
                        for effects in ({name: off}, {}))
    for channel in READINGS:
        np.testing.assert_array_equal(with_it[channel], without[channel])


def test_rigid_shaft_is_the_baseline():
    """A stiff shaft moves the drive as none; the torque sensor feels the inertia behind it."""
    time, inputs = excited(300)
    with_it, without = (Drive(RIG, effects).simulate(time, inputs)
                        for effects in ({'shaft_compliance': {'compliance': 0.0}}, {}))
    assert np.abs(with_it['motor_speed'] - without['motor_speed']).max() < 0.15
    steady = Drive(RIG, {'shaft_compliance': {}})
    point = operating_point(Drive(RIG), 10.0, 150.0)
    constant = {'pump_command': np.full(400, point.pump_command),
                'pprv_command': np.full(400, point.pprv_command)}
    end = steady.simulate(0.02 * np.arange(400), constant)
    assert end['load_torque'][-1] == pytest.approx(point.readings['load_torque'], rel=1e-3)


@pytest.mark.needs_numba
@pytest.mark.parametrize('name', catalogue())
def test_compiled_is_plain(name):
    """The compiled code and plain Python give the same motion."""
    time, inputs = excited(15)
    fast, plain = (Drive(RIG, {name: {}}, compiled=compiled).simulate(time, inputs)
                   for compiled in (True, False))
    for channel in (*READINGS, 'case_drain_flow'):
        np.testing.assert_allclose(fast[channel], plain[channel], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize('grade, at_0', [('ISO VG 32', 338.0), ('ISO VG 46', 580.0),
                                         ('ISO VG 68', 1040.0)])
def test_viscosity_at_the_freezing_point(grade, at_0):
    """From 40 and 100 degC to what makers of mineral hydraulic oils state for 0 degC."""
    assert viscosity(273.15, grade) * 1e6 == pytest.approx(at_0, rel=0.03)


def test_grades_are_those_of_the_file():
    """The verb losses reads them from a file that users may copy, rig files name them."""
    assert read_yaml(share('config', 'oil_grades.yaml')) == {
        name: list(pair) for name, pair in GRADES.items()}


def test_warm_oil_leaks_more():
    """Laminar leakage goes with the inverse of viscosity, of pump and hydromotor alike."""
    ratio = viscosity(323.15, 'ISO VG 46') / viscosity(343.15, 'ISO VG 46')
    warm = at({'leakage_temperature': {'exponent': 1.0}}, temperature=343.15)
    cold = at({}, temperature=343.15)
    assert ratio == pytest.approx(2.02, abs=0.15)      # 30 mm^2/s over 15 mm^2/s
    assert warm['case_drain_flow'] == pytest.approx(ratio * cold['case_drain_flow'])
    pump_loss = RIG.pump.leakage(90e5, 5.5)
    assert cold['pump_flow'] - warm['pump_flow'] == pytest.approx((ratio - 1.0) * pump_loss)


def test_leakage_takes_speed():
    """A leak of G*P behind the meter takes G*P/Dm of speed at a given pressure."""
    conductance = 2e-12
    worn = Drive(RIG, {'motor_leakage': {'conductance': conductance}})
    point = operating_point(Drive(RIG), 10.0, 200.0)
    n = 1500
    end = worn.simulate(0.01 * np.arange(n), {
        'pump_command': np.full(n, point.pump_command),
        'pprv_command': np.full(n, point.pprv_command)}, point.state.copy())
    lost = 10.0 - end['motor_speed'][-1]
    expected = conductance * end['pump_outlet_pressure'][-1] / RIG.motor.displacement
    assert lost == pytest.approx(expected, rel=0.05)   # the tables' leakage eases a little, too


@pytest.mark.parametrize('effects, channel, state, expected', [
    ({'motor_leakage': {'conductance': 1e-12}}, 'case_drain_flow', {}, 90e5 * 1e-12),
    ({'pump_leakage': {'conductance': 1e-12}}, 'pump_flow', {}, -90e5 * 1e-12),
    ({'motor_orifice_leakage': {'flow_at_100_bar': 1e-5}}, 'case_drain_flow',
     {'pressure': 25e5}, 0.5e-5),
    ({'suction_starvation': {'share_at_full': 0.1, 'begins_at': 0.5}}, 'pump_flow',
     {'command': 10.0}, -0.1 * RIG.pump.max_displacement * RIG.pump.shaft_speed),
    ({'suction_starvation': {'share_at_full': 0.1, 'begins_at': 0.9}}, 'pump_flow', {}, 0.0),
    ({'swash_compliance': {'share_at_100_bar': 0.05}}, 'pump_displacement', {},
     -0.9 * 0.05 * RIG.pump.max_displacement),
    ({'swash_compliance': {'share_at_100_bar': 0.05, 'begins_at': 60e5}}, 'pump_displacement',
     {}, -0.3 * 0.05 * RIG.pump.max_displacement),
    ({'elastic_leakage': {'stretch': 1 / 90e5}}, 'case_drain_flow', {},
     7.0 * RIG.motor.leakage(90e5, 10.0)),             # twice the gap: eight times the flow
    ({'compressibility_flow': {'volume_ratio': 1.0, 'dead_share': 0.0}}, 'pump_flow', {},
     -RIG.pump.displacement(5.5) * RIG.pump.shaft_speed * 90e5 / RIG.line.bulk_modulus),
    ({'compressibility_flow': {'volume_ratio': 2.0, 'in_motor': 1.0}}, 'motor_inlet_flow', {},
     2.0 * RIG.motor.displacement * 10.0 * 90e5 / RIG.line.bulk_modulus),
    ({'compressibility_flow': {'volume_ratio': 2.0, 'in_motor': 1.0}}, 'pump_flow', {}, 0.0),
    ({'prv_cracking': {'gradient': 1e-11, 'cracking_ratio': 0.5}}, 'pump_flow', {}, 0.0),
    ({'prv_cracking': {'gradient': 1e-11, 'cracking_ratio': 0.5, 'rounding': 0.01}}, 'pump_flow',
     {'pressure': 180e5}, -1e-11 * 80e5 * (80 / 82) * 1.01),
    ({'pump_speed_droop': {'droop': 0.1}}, 'pump_speed', {'pressure': 200e5, 'command': 10.0},
     -0.1 * RIG.pump.shaft_speed),
    ({'bearing_friction': {'coulomb': 9.0, 'load_share': 0.0}}, 'motor_torque_hydraulic', {},
     -9.0),
    ({'bearing_friction': {'coulomb': 0.0, 'load_share': 0.1}}, 'motor_torque_hydraulic', {},
     -0.1 * 90e5 * RIG.motor.displacement),
    ({'stribeck_friction': {'torque': 20.0, 'speed': 10.0}}, 'motor_torque_hydraulic', {},
     -20.0 / math.e),
    ({'viscous_drag': {'coefficient': 1.5}}, 'motor_torque_hydraulic', {}, -15.0),
    ({'viscous_drag': {'coefficient': 1.5, 'viscosity_share': 1.0}}, 'motor_torque_hydraulic',
     {'temperature': 343.15}, -15.0 * THINNER),
    ({'hydrodynamic_drag': {'coefficient': 0.2}}, 'motor_torque_hydraulic', {}, -20.0),
    # Only the difference of the port pressures counts.
    ({'back_pressure': {'outlet_pressure': 5e5}}, 'motor_torque_hydraulic', {},
     hydromotor_torque(85e5, 10.0) - hydromotor_torque(90e5, 10.0)),
    ({'back_pressure': {'outlet_pressure': 5e5, 'flow_share': 0.4}}, 'motor_torque_hydraulic',
     {'speed': 5.0}, hydromotor_torque(86e5, 5.0) - hydromotor_torque(90e5, 5.0)),
    # All of it acts on the displacement where the losses stay what they were.
    ({'back_pressure': {'outlet_pressure': 5e5, 'loss_share': 1.0}}, 'motor_torque_hydraulic', {},
     -5e5 * RIG.motor.displacement),
    ({'piston_ripple': {'cosine': 0.03, 'sine': 0.5}}, 'motor_torque_hydraulic', {},
     0.03 * 90e5 * RIG.motor.displacement),
    ({'piston_ripple': {'cosine': 0.0, 'cosine_2': 0.02, 'sine_2': 0.5}},
     'motor_torque_hydraulic', {}, 0.02 * 90e5 * RIG.motor.displacement),
    ({'gearbox_loss': {'fraction': 0.1, 'no_load': 0.0}}, 'load_torque', {},
     0.1 * at({})['load_torque']),
    ({'pressure_sensor_bias': {'bias': -2e5}}, 'pump_outlet_pressure', {}, -2e5),
    ({'torque_sensor_scale': {'gain_error': 0.1, 'knee': 0.0}}, 'load_torque', {},
     0.1 * at({})['load_torque']),
    ({'flow_sensor_scale': {'gain_error': -0.1}}, 'motor_inlet_flow', {},
     -0.1 * at({})['motor_inlet_flow']),
])
def test_closed_form(effects, channel, state, expected):
    """What an effect adds to its balance in one state."""
    assert differ(effects, channel, **state) == pytest.approx(expected, rel=2e-3, abs=1e-12)


def test_the_swash_plate_yields_at_an_operating_point():
    """Held at speed and load the command makes up for what pressure takes."""
    stiff, soft = (operating_point(Drive(RIG, effects), 10.0, 200.0) for effects in (
        {}, {'swash_compliance': {'share_at_100_bar': 0.05}}))
    pressure = soft.readings['pump_outlet_pressure']
    assert soft.readings['pump_displacement'] == pytest.approx(
        stiff.readings['pump_displacement'], rel=2e-3)
    assert RIG.pump.displacement(soft.pump_command) - RIG.pump.displacement(
        stiff.pump_command) == pytest.approx(
            0.05 * RIG.pump.max_displacement * pressure / 1e7, rel=0.03)


def test_an_accumulator_takes_what_its_gas_gives_up():
    """From its precharge on, as a polytropic gas; nothing below."""
    volume, precharge, exponent = 3e-4, 40e5, 1.3
    added = catalogue()['accumulator'].function
    taken, _ = quad(lambda pressure: 2e-3 * added(pressure, 2e-3, volume, precharge, exponent),
                    50e5, 120e5)
    gas = [volume * ((precharge + 101325.0) / (pressure + 101325.0))**(1.0 / exponent)
           for pressure in (50e5, 120e5)]
    assert taken == pytest.approx(gas[0] - gas[1], rel=1e-6)
    assert added(39e5, 2e-3, volume, precharge, exponent) == 0.0


def test_a_line_with_mass_rings_between_its_two_volumes():
    """Two springs of oil with a mass between them and the load's behind: the faster mode."""
    inertance, share, turn = 4e8, 0.4, RIG.motor.displacement
    near, far = ((1.0 - share) * RIG.line.volume / RIG.line.bulk_modulus,
                 share * RIG.line.volume / RIG.line.bulk_modulus)
    modes = np.linalg.eigvals([[0, -1 / near, 0, 0], [1 / inertance, 0, -1 / inertance, 0],
                               [0, 1 / far, 0, -turn / far], [0, 0, turn / RIG.motor.inertia, 0]])
    drive = Drive(RIG, {'line_inertance': {
        'inertance': inertance, 'far_share': share, 'damping': 0.0}})
    point = operating_point(drive, 10.0, 200.0)
    time = 5e-4 * np.arange(4096)
    pprv = np.where(time > 0.01, point.pprv_command + 1.0, point.pprv_command)
    found = drive.simulate(time, {'pump_command': np.full(4096, point.pump_command),
                                  'pprv_command': pprv}, point.state.copy())
    drop = found['pump_outlet_pressure'] - found['motor_inlet_pressure']
    assert abs(drop[10]) < 1e3      # nothing moves before the step
    spectrum = np.abs(np.fft.rfft((drop - drop.mean()) * np.hanning(4096)))
    ringing = 2 * math.pi * np.fft.rfftfreq(4096, 5e-4)[20 + np.argmax(spectrum[20:])]
    assert ringing == pytest.approx(modes.imag.max(), rel=0.03)


@pytest.mark.parametrize('laminar, turbulent', [(1e9, 0.0), (0.0, 1e12), (1e9, 1e12)])
def test_line_loss_lies_between_the_sensors(laminar, turbulent):
    """The pressures before and behind the hose differ by the loss, either way of the flow."""
    for speed in (10.0, -10.0):
        found = at({'line_loss': {'laminar': laminar, 'turbulent': turbulent,
                                  'upstream_share': 1.0}}, speed=speed)
        flow = found['motor_inlet_flow']
        assert flow * speed > 0.0
        assert found['pump_outlet_pressure'] - found['motor_inlet_pressure'] == pytest.approx(
            laminar * flow + turbulent * flow * abs(flow))


def test_drag_brakes_both_ways():
    """A torque loss opposes the rotation whichever way the hydromotor turns."""
    for name in ('bearing_friction', 'viscous_drag', 'hydrodynamic_drag', 'stribeck_friction'):
        moved = [differ({name: {}}, 'motor_torque_hydraulic', speed=speed)
                 for speed in (6.0, -6.0, 0.0)]
        assert moved[0] < 0.0 and moved[1] == pytest.approx(-moved[0]) and moved[2] == 0.0


def test_friction_raises_pressure():
    """Held at speed and load, the pressure rises by T/(eta*Dm)."""
    torque = 12.0
    clean, dry = (operating_point(Drive(RIG, effects), 10.0, 200.0) for effects in
                  ({}, {'bearing_friction': {'coulomb': torque, 'load_share': 0.0}}))
    eta, displacement = RIG.motor.mechanical_efficiency, RIG.motor.displacement
    low, high = (point.readings['pump_outlet_pressure'] for point in (clean, dry))
    assert displacement * (eta(high, 10.0) * high - eta(low, 10.0) * low) == pytest.approx(torque)
    # Less by what the efficiency gains with pressure.
    assert 0.9 < (high - low) * eta(low, 10.0) * displacement / torque < 1.0


@pytest.mark.parametrize('exponent', [1.0, 1.4])
def test_air_is_a_polytropic_spring(exponent):
    """The compressibility of oil plus bubbles, from the volume that they fill at a pressure."""
    oil, fraction, start = 1.2e9, 0.02, 101325.0

    def volume(absolute):
        return math.exp(-absolute / oil) + fraction * (start / absolute)**(1 / exponent)

    for gauge in (1e5, 5e5, 20e5, 100e5):
        p, h = gauge + start, 10.0
        exact = -(volume(p + h) - volume(p - h)) / (2 * h) / volume(p)
        found = 1 / oil + compliance(gauge, fraction, 0.0, exponent)
        assert found == pytest.approx(exact, rel=1.1 * fraction)
    # 1 % of air at 10 bar absolute: n*p/(share that is left), some 720 bar beside the oil's.
    assert 1 / compliance(10e5 - start, 0.01, 0.0, 1.4) == pytest.approx(7.2e8, rel=0.02)
    # In solution: half of it at half the pressure at which all is, none beyond.
    free, half, none = (compliance(gauge, 0.02, share, exponent) for gauge, share in (
        (10e5, 0.0), (10e5, 5e-7), (30e5, 5e-7)))
    assert (half, none) == (pytest.approx(0.5 * free), 0.0)


def displacement_after(effects, commands, rate=100.0):
    """Return the pump's displacement under given commands."""
    n = len(commands)
    return Drive(RIG, effects).simulate(np.arange(n) / rate, {
        'pump_command': commands, 'pprv_command': np.full(n, 3.0)})['pump_displacement']


def test_actuator_effects():
    """Shift, play, full stroke time and lag are what their parameters say."""
    table = RIG.pump.displacement
    held = np.full(300, 5.0)
    shifted = displacement_after({'pump_command_offset': {'offset': -0.4}}, held)
    assert shifted[-1] == pytest.approx(table(4.6))
    up_and_down = np.concatenate([np.linspace(3.0, 7.0, 400), np.full(100, 7.0),
                                  np.linspace(7.0, 5.0, 400), np.full(300, 5.0)])
    played = displacement_after({'pump_hysteresis': {'width': 0.6}}, up_and_down)
    assert played[499] == pytest.approx(table(6.7), rel=1e-4)
    assert played[-1] == pytest.approx(table(5.3), rel=1e-4)
    # Two plays, +-0.15 and +-0.45 V, stand at 6.85 and 6.55 V; back to 6.6 V moves the first.
    back = np.concatenate([np.linspace(3.0, 7.0, 400), np.linspace(7.0, 6.6, 100),
                           np.full(300, 6.6)])
    bundle = displacement_after({'pump_hysteresis': {
        'width': 0.6, 'softness': 0.0, 'spread': 0.5}}, back)
    assert bundle[-1] == pytest.approx(table(0.5 * (6.75 + 6.55)), rel=1e-4)
    step = np.concatenate([np.full(10, 2.0), np.full(600, 10.0)])
    limited = displacement_after({'pump_rate_limit': {'full_stroke_time': 4.0}}, step)
    assert np.diff(limited).max() * 100 == pytest.approx(RIG.pump.max_displacement / 4.0)
    there_and_back = np.concatenate([step, np.full(600, 2.0)])
    limited = displacement_after({'pump_rate_limit': {
        'full_stroke_time': 4.0, 'asymmetry': -0.25}}, there_and_back)
    assert np.diff(limited).max() * 100 == pytest.approx(0.75 * RIG.pump.max_displacement / 4.0)
    assert np.diff(limited).min() * 100 == pytest.approx(-1.25 * RIG.pump.max_displacement / 4.0)
    slow = displacement_after({'pump_lag': {'time_constant': 0.14}}, step)
    share = (slow - slow[9]) / (table(10.0) - slow[9])
    assert share[10 + 20] == pytest.approx(1 - math.exp(-0.2 / 0.2), rel=1e-3)   # after 0.06+0.14
    after = np.arange(40) * 0.01
    # The last is much shorter than a step.
    for part, rest, before in ((1.0, 0.06, 0.14), (0.5, 0.13, 0.07), (0.003, 0.19958, 0.00042)):
        slow = displacement_after({'pump_lag': {'time_constant': 0.14, 'series': part}}, step)
        share = (slow - slow[9]) / (table(10.0) - slow[9])
        assert share[10:50] == pytest.approx(1 - (
            rest * np.exp(-after / rest) - before * np.exp(-after / before)) / (rest - before),
            abs=1e-3)


@pytest.mark.parametrize('series', [0.0, 0.3, 0.5])
def test_filtered_speed(series):
    """The reading obeys the lags, integrated exactly between samples."""
    time, inputs = excited(300)
    lag = 0.2
    found = Drive(RIG, {'speed_sensor_lag': {'time_constant': lag, 'series': series}}
                  ).simulate(time, inputs)
    speed = Drive(RIG).simulate(time, inputs)['motor_speed']
    fine = np.arange(0.0, time[-1], 1e-3)
    filtered, value, behind = [], speed[0], speed[0]
    for true in np.interp(fine, time, speed):
        value += (true - value) * (1 - math.exp(-1e-3 / ((1 - series) * lag)))
        behind += (value - behind) * (1 - math.exp(-1e-3 / (series * lag)) if series else 1.0)
        filtered.append(behind)
    error = np.interp(time[50:-1], fine, filtered) - found['motor_speed'][50:-1]
    assert np.abs(error).max() < 0.01 * np.ptp(speed)


@pytest.mark.parametrize('lag', [2e-4, 2e-3])
@pytest.mark.parametrize('series', [0.0, 0.5])
def test_a_filter_quicker_than_a_step_reads_as_late_as_it_is(lag, series):
    """Of a speed that rises evenly it shows what was there a lag before."""
    time, inputs = excited(300)
    late, speed = (Drive(RIG, effects, max_step=0.01).simulate(time, inputs)['motor_speed']
                   for effects in (
                       {'speed_sensor_lag': {'time_constant': lag, 'series': series}}, {}))
    rise = CubicSpline(time, speed)(time[50:-1], 1)
    assert (speed - late)[50:-1] @ rise / (rise @ rise) == pytest.approx(lag, rel=0.15)


def test_ripple_has_the_piston_frequency():
    """At 8 rad/s the tone in the pressure lies at pistons*w/2pi."""
    point = operating_point(Drive(RIG), 8.0, 150.0)
    n = 4000
    end = Drive(RIG, {'piston_ripple': {}}).simulate(0.005 * np.arange(n), {
        'pump_command': np.full(n, point.pump_command),
        'pprv_command': np.full(n, point.pprv_command)}, point.state.copy())
    pressure = end['pump_outlet_pressure'][1000:]
    spectrum = np.abs(np.fft.rfft((pressure - pressure.mean()) * np.hanning(len(pressure))))
    peak = np.fft.rfftfreq(len(pressure), 0.005)[np.argmax(spectrum)]
    expected = RIG.motor.pistons * end['motor_speed'][1000:].mean() / (2 * math.pi)
    assert peak == pytest.approx(expected, abs=0.1)
