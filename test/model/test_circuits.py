# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Circuits: closed forms, mirrored machines, another solver."""
import dataclasses
import math

from hst_drive.effects.formula import SPEED
from hst_drive.errors import InputError
from hst_drive.model.circuit_model import CircuitModel, part_model
from hst_drive.model.circuits import circuit_of
from hst_drive.model.circuits.closed import charged
from hst_drive.resources import share
from hst_drive.rig import load_rig, parse_rig
from hst_drive.rig.yaml_file import read_yaml
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

CLOSED = load_rig(share('config', 'rig', 'closed_rig.yaml'))
BAR, L_MIN, CC_REV = 1e5, 1.0 / 60e3, 1e-6 / (2.0 * math.pi)
VALVE = load_rig(share('config', 'rig', 'valve_rig.yaml'))
COMMAND = {'closed': 'pump_command', 'valve': 'valve_command'}


def moved(rig, command, torque, effects=None, seconds=6.0, compiled=None):
    """Return a run from rest with command (V) and opposing torque (N.m) held."""
    time = np.arange(0.0, seconds, 0.01)
    model = CircuitModel(rig, effects, compiled=compiled)
    return time, model.run(time, {COMMAND[rig.circuit]: np.full(len(time), command),
                                  'opposing_torque': np.full(len(time), torque)}, {})


@pytest.mark.parametrize('torque, as_limiter, way', [
    (3000.0, 0.0, -1), (3000.0, 1.0, -1), (-3000.0, 0.0, 1), (-3000.0, 1.0, -1)])
def test_a_plate_yields_as_its_pistons_press_or_as_a_power_limiter(torque, as_limiter, way):
    """A load that drives turns the pressure round: pistons then push the plate further out."""
    _, found = moved(CLOSED, 6.0, torque, {'swash_compliance': {
        'share_at_100_bar': 0.03, 'as_limiter': as_limiter}}, seconds=12.0)
    difference = found['line_a_pressure'][-1] - found['line_b_pressure'][-1]
    assert np.sign(difference) == np.sign(torque)
    assert found['pump_displacement'][-1] == pytest.approx(
        71 * CC_REV * (5.0 / 9.0 + way * 0.03 * abs(difference) / 1e7), rel=1e-4)


@pytest.mark.parametrize('torque', [3000.0, -3000.0])
@pytest.mark.parametrize('with_stroke', [0.0, 1.0])
def test_a_plate_that_yields_at_once_ends_where_a_slow_one_does(torque, with_stroke):
    """Settled, both lines, charge, speed and torque of the pump do not tell them apart."""
    ends = []
    for at_once in (0.0, 1.0):
        _, found = moved(CLOSED, 6.0, torque, {'swash_compliance': {
            'share_at_100_bar': 0.03, 'with_stroke': with_stroke, 'at_once': at_once}}, 12.0)
        ends.append({name: values[-1] for name, values in found.items()})
    slow, quick = ends
    for name in ('line_a_pressure', 'line_b_pressure', 'motor_speed', 'charge_pressure',
                 'pump_torque', 'motor_torque'):
        # Of its own stroke or of that which the command asks for: the square of a small share.
        assert quick[name] == pytest.approx(slow[name], rel=2e-3), name
    # What its control holds is not what yields.
    assert quick['pump_displacement'] == pytest.approx(71 * CC_REV * 5.0 / 9.0, rel=1e-6)


@pytest.mark.parametrize('pump, motor', [(0.0, 0.0), (0.02, 0.03)], ids=['sheet', 'worn'])
def test_steady_state_of_a_closed_circuit_by_hand(pump, motor):
    """
    Speed, both pressures, charge pressure and torque follow from the sheet's numbers.

    What a worn machine leaks more (L/min per bar) leaves both lines, each at its pressure.
    """
    _, found = moved(CLOSED, 6.0, 4000.0, {
        name: {'conductance': more * L_MIN / BAR, 'exponent': 1.0}
        for name, more in (('pump_leakage', pump), ('motor_leakage', motor)) if more})
    last = {name: values[-1] for name, values in found.items()}
    swept = 2 * 3.0 * 560 * CC_REV
    # Gear, pressure share, Coulomb and viscous part of two motors turn torque into pressure.
    speed = last['motor_speed']
    friction = 6.0 * (20.0 + 0.6 * 3.0 * speed) * 0.97
    difference = (4000.0 + friction) / (swept * 0.96 * 0.97)
    assert last['line_a_pressure'] - last['line_b_pressure'] == pytest.approx(difference, rel=1e-4)
    delivered = 71 * CC_REV * 5.0 / 9.0 * 1800 * 2 * math.pi / 60
    high, low = last['line_a_pressure'] / BAR, last['line_b_pressure'] / BAR
    leaks = (0.012 + pump + 2 * 0.008 + motor) * L_MIN
    assert speed == pytest.approx((delivered - leaks * high) / swept, rel=1e-4)
    # What the low side lacks comes through the check valve, the rest goes over the relief.
    lacking = leaks * (high + low) + 8.0 * L_MIN * low / 24.0
    charge = 24.0 + 0.08 * (16 * CC_REV * 1800 * 2 * math.pi / 60 - lacking) / L_MIN
    assert last['charge_pressure'] / BAR == pytest.approx(charge, rel=1e-3)
    assert low == pytest.approx(charge - 0.05 * lacking / L_MIN, rel=1e-3)
    assert last['motor_torque'] == pytest.approx(4000.0, rel=1e-3)
    assert last['case_drain_flow'] / L_MIN == pytest.approx(
        (0.016 + motor) * (high + low), rel=1e-3)
    # Pump and charge pump sit on one shaft, and neither is without friction.
    ideal = CC_REV * BAR * (71 * 5.0 / 9.0 * (high - low) + 16 * charge)
    assert last['pump_torque'] == pytest.approx(ideal / 0.93, rel=1e-3)


@pytest.mark.parametrize('rig', [CLOSED, VALVE], ids=['closed', 'valve'])
def test_a_mirrored_command_mirrors_the_machine(rig):
    """Backwards is forwards with the lines exchanged."""
    _, forth = moved(rig, 5.0, 300.0, seconds=2.0)
    _, back = moved(rig, -5.0, 300.0, seconds=2.0)
    for name, other, sign in (('motor_speed', 'motor_speed', -1.0),
                              ('line_a_pressure', 'line_b_pressure', 1.0),
                              ('line_b_pressure', 'line_a_pressure', 1.0),
                              ('motor_torque', 'motor_torque', -1.0)):
        spread = np.abs(forth[name]).max()
        np.testing.assert_allclose(sign * back[other], forth[name], rtol=0.0, atol=1e-3 * spread)


def test_steady_state_of_a_valve_by_hand():
    """Q = Q_r * sqrt(dp/dp_r) at each edge; friction and leakage of the sheet."""
    _, found = moved(VALVE, 5.0, 300.0)
    gain, swept, leak = 60.0 * 4.6 / 9.6 / math.sqrt(35.0), 250 * CC_REV * BAR, 0.005

    def pressures(speed):
        """Return line A from the supply's edge, line B from the edge to the return, bar."""
        turned = speed * swept / BAR / L_MIN
        return (brentq(lambda a: gain * math.sqrt(210.0 - a) - turned - leak * a, 0.0, 210.0),
                brentq(lambda b: gain * math.sqrt(b) - turned + leak * b, 0.0, 210.0))

    def left(speed):
        a, b = pressures(speed)
        return 0.96 * (a - b) * swept - 10.0 - 0.4 * speed - 300.0

    speed = brentq(left, 0.0, gain * math.sqrt(100.0) * L_MIN * BAR / swept)
    assert found['motor_speed'][-1] == pytest.approx(speed, rel=1e-3)
    assert [found[f'line_{line}_pressure'][-1] / BAR for line in 'ab'] == pytest.approx(
        pressures(speed), rel=2e-3)


@pytest.mark.parametrize('effect, channel, sign', [
    ('motor_leakage', 'motor_speed', -1), ('cross_port_leakage', 'motor_speed', -1),
    ('charge_pressure_loss', 'line_b_pressure', -1), ('bearing_friction', 'line_a_pressure', 1),
    ('swash_compliance', 'motor_speed', -1), ('gearbox_loss', 'line_a_pressure', 1),
    ('cross_port_relief_cracking', 'motor_speed', -1)])
def test_an_effect_of_the_catalogue_acts_in_a_closed_circuit(effect, channel, sign):
    """Each from its one file, in both directions alike."""
    for way in (1.0, -1.0):
        _, without = moved(CLOSED, way * 6.0, 9000.0)
        _, with_it = moved(CLOSED, way * 6.0, 9000.0, {effect: {}})
        name = channel.replace('_a_', '_x_').replace('_b_', '_a_').replace('_x_', '_b_') if (
            way < 0) else channel
        turn = way if name == 'motor_speed' else 1.0
        assert sign * turn * (with_it[name][-1] - without[name][-1]) > 0.0


@pytest.mark.parametrize('rig, name, drained', [
    (CLOSED, 'formula_motor_flow', True), (CLOSED, 'formula_pump_flow', False),
    (VALVE, 'formula_motor_flow', True)], ids=['closed', 'of its pump', 'valve'])
def test_a_formula_reads_the_speed_and_takes_oil_from_the_high_line_once(rig, name, drained):
    """What was not listed is no leak of both lines: -1 cm^3/s at twice its speed's unit."""
    told = {entry.name: np.zeros(2) for entry in circuit_of(rig).states}
    told |= {'motor_speed': np.full(2, 2 * SPEED), 'line_a_pressure': np.full(2, 100e5),
             'line_b_pressure': np.full(2, 50e5)}
    without, with_it = (CircuitModel(rig, effects).run(np.array([0.0, 0.01]), {}, told)
                        for effects in ({}, {name: {
                            'coefficient_1': -0.5e-6, 'speed_1': 1.0, 'coefficient_2': 0.0,
                            'coefficient_3': 0.0}}))
    moved_by = {key: with_it[key][0] - without[key][0] for key in with_it}
    displacement = circuit_of(rig).parameters(rig)['motor_displacement']
    assert moved_by['speed_by_a'] * displacement == pytest.approx(-1e-6, rel=1e-6)
    assert moved_by['speed_by_b'] == 0.0
    assert moved_by['case_drain_flow'] == pytest.approx(1e-6 * drained, rel=1e-6)


@pytest.mark.parametrize('rig', [CLOSED, VALVE], ids=['closed', 'valve'])
def test_pistons_give_their_share_of_the_torque_in_either_sense(rig):
    """The swing is part of displacement times pressure difference, driving and braking."""
    high, low = np.array([150e5, 20e5, 150e5]), np.array([20e5, 150e5, 20e5])
    told = {entry.name: np.zeros(3) for entry in circuit_of(rig).states} | {
        'line_a_pressure': high, 'line_b_pressure': low, 'motor_speed': np.array([9.0, 9.0, -9.0]),
        'motor_angle': np.array([0.1, 0.3, -0.7])}
    without, with_it = (CircuitModel(rig, effects).run(0.01 * np.arange(3), {}, told)
                        for effects in ({}, {'piston_ripple': {'cosine': 0.03}}))
    displacement = circuit_of(rig).parameters(rig)['motor_displacement']
    np.testing.assert_allclose(
        with_it['motor_torque'] - without['motor_torque'], 0.03 * displacement * (high - low)
        * np.cos((rig.motor.pistons or 7) * told['motor_angle']), rtol=1e-6)


def test_a_valve_circuit_has_no_cross_port_relief():
    """Its rig file has none, so nothing of it can crack; oil may pass from line to line."""
    model = CircuitModel(VALVE)
    assert model.enters('cross_port_leakage')
    assert not model.enters('cross_port_relief_cracking')


def test_what_leaks_from_line_to_line_needs_no_charge():
    """The charge pump replaces what a hydromotor leaks, not what passes to the other line."""
    _, without = moved(CLOSED, 6.0, 9000.0)
    lost = {name: moved(CLOSED, 6.0, 9000.0, {name: {}})[1] for name in (
        'motor_leakage', 'cross_port_leakage')}
    charge = {name: without['charge_pressure'][-1] - found['charge_pressure'][-1]
              for name, found in lost.items()}
    assert charge['motor_leakage'] > 10 * abs(charge['cross_port_leakage'])


def test_what_the_pump_does_not_move_is_not_lost():
    """Oil that it compresses or that does not fill it stays in the low line; a leak does not."""
    _, without = moved(CLOSED, 8.0, 9000.0)
    lost = {name: moved(CLOSED, 8.0, 9000.0, {name: {}})[1] for name in (
        'pump_leakage', 'compressibility_flow', 'suction_starvation')}
    slower = {name: without['motor_speed'][-1] - found['motor_speed'][-1]
              for name, found in lost.items()}
    charge = {name: without['charge_pressure'][-1] - found['charge_pressure'][-1]
              for name, found in lost.items()}
    assert min(slower.values()) > 0.0
    for name in ('compressibility_flow', 'suction_starvation'):
        assert abs(charge[name] / slower[name]) < 0.1 * charge['pump_leakage'] / slower[
            'pump_leakage']


@pytest.mark.parametrize('where, soft', [(0.0, (True, True)), (1.0, (True, False)),
                                         (-1.0, (False, True))])
def test_an_accumulator_stands_on_one_line_or_on_both(where, soft):
    """Its line alone takes oil, whichever carries the pressure."""
    told = {'pump_displacement': np.full(2, 1e-6), 'line_a_pressure': np.full(2, 100e5),
            'line_b_pressure': np.full(2, 100e5), 'motor_speed': np.zeros(2),
            'motor_angle': np.zeros(2)}
    stiff, found = (CircuitModel(CLOSED, effects).run(np.array([0.0, 0.01]), {}, told)
                    for effects in ({}, {'accumulator': {'gas_volume': 1e-4, 'where': where}}))
    for name, is_soft in zip(('a_storage', 'b_storage'), soft):
        assert (abs(found[name][0]) > 1.05 * abs(stiff[name][0])) == is_soft


def test_a_prime_mover_gives_way_as_slowly_as_its_inertia_lets_it():
    """Behind a step of pressure its speed falls exponentially; a pump that brakes speeds it up."""
    time = np.arange(0.0, 1.0, 0.01)
    nominal, stroke = 1800 * math.pi / 30, 0.5 * 71 * CC_REV
    for way in (1.0, -1.0):
        high = np.where(time < 0.2, 20e5, 220e5)
        told = {'pump_displacement': np.full(100, way * stroke), 'line_a_pressure': high,
                'line_b_pressure': np.full(100, 20e5), 'motor_speed': np.zeros(100),
                'motor_angle': np.zeros(100)}
        found = CircuitModel(CLOSED, {'pump_speed_droop': {
            'droop': 0.1, 'time_constant': 0.15}}).run(time, {}, told)['pump_speed']
        slip = 0.1 * 0.5 * 200e5 / CLOSED.cross_port_relief.set_pressure
        after = np.maximum(time - 0.195, 0.0)       # the record rises on a straight line
        np.testing.assert_allclose(found / nominal - 1.0, -way * slip * (
            1.0 - np.exp(-after / 0.15)), atol=2e-3 * slip)
        measured = CircuitModel(CLOSED, {'pump_speed_droop': {}}).run(
            time, {}, {**told, 'pump_speed': np.full(100, 180.0)})
        assert measured['pump_torque'][-1] == pytest.approx(
            measured['pump_power'][-1] / 180.0)


def closed_rates(at, state, aim, load):
    """Return the rates of the shipped rig, its charge line by bisection."""
    stroke, line_a, line_b, speed = state
    made, swept = 16 * CC_REV * 60 * math.pi, 2 * 3.0 * 560 * CC_REV
    check, spring, dry = 0.05 * BAR / L_MIN, 1.3e9 / 0.0025, 6.0 * 20.0 * 0.97
    fed = brentq(lambda charge: made - max(charge - 24 * BAR, 0.0) / (0.08 * BAR / L_MIN)
                 - (max(charge - line_a, 0.0) + max(charge - line_b, 0.0)) / check,
                 -2 * BAR, 500 * BAR, xtol=1e-3)
    relieved = max(abs(line_a - line_b) - 350 * BAR, 0.0) / (0.4 * BAR / L_MIN)
    flushed = 8 * L_MIN * max(min(line_a, line_b), 0.0) / (24 * BAR)
    rates = []
    for line, other, moves in ((line_a, line_b, 1.0), (line_b, line_a, -1.0)):
        high = line > other or line == other and moves > 0.0
        rate = spring * (moves * (stroke * 60 * math.pi - swept * speed)
                         + max(fed - line, 0.0) / check - 0.028 * L_MIN / BAR * max(line, 0.0)
                         - (relieved if high else flushed - relieved))
        rates.append(max(rate, 0.0) if line <= -0.9 * BAR else rate)
    ideal = swept * (line_a - line_b)
    lost = (1.0 - 0.96 * 0.97) * abs(ideal) + dry + 18.0 * 0.6 * 0.97 * abs(speed)
    # Friction changes its sign within a hundredth of the full speed.
    turns = math.tanh(speed / (0.01 * 71 * 60 * math.pi / (2 * 3.0 * 560)))
    return [(aim - stroke) / 0.12, *rates, (ideal - lost * turns - load) / 60.0]


@pytest.mark.parametrize('row', [0.001, 0.002, 0.01])
@pytest.mark.parametrize('load, far, empties, relieves', [
    (4000.0, 2e-4, False, False), (-9000.0, 5e-4, True, False), (-25000.0, 2e-4, True, False),
    (14000.0, 5e-4, True, True)], ids=['drives', 'brakes', 'is pulled', 'is pulled back'])
def test_a_step_of_a_closed_circuit_agrees_with_radau(load, far, empties, relieves, row):
    """Equations written anew, by an implicit solver; error over the range of each state."""
    start = np.array([values[-1] for values in (moved(CLOSED, 4.0, 4000.0)[1][name] for name in (
        'pump_displacement', 'line_a_pressure', 'line_b_pressure', 'motor_speed',
        'motor_angle', 'pump_speed'))])
    time = np.arange(round(0.4 / row) + 1) * row
    want = solve_ivp(closed_rates, (0.0, time[-1]), start[:4], 'Radau', time,
                     args=(71 * CC_REV * 6.0 / 9.0, load), max_step=2e-4,
                     rtol=1e-7, atol=[1e-13, 1.0, 1.0, 1e-7])
    found = CircuitModel(CLOSED).run(time, {'pump_command': np.full(len(time), 7.0),
                                            'motor_torque': np.full(len(time), load)}, {}, start)
    lowest = min(found['line_a_pressure'].min(), found['line_b_pressure'].min())
    assert (lowest < -0.8 * BAR, found['line_a_pressure'].max() > 350 * BAR) == (
        empties, relieves)
    for name, true in zip(('pump_displacement', 'line_a_pressure', 'line_b_pressure',
                           'motor_speed'), want.y):
        assert np.max(np.abs(found[name] - true)) < far * np.ptp(true), name


@pytest.mark.parametrize('rig', [CLOSED, VALVE], ids=['closed', 'valve'])
def test_oil_in_either_line_stiffens_under_its_own_pressure(rig):
    """Its compressibility falls on a straight line, to 0.8 of the datasheet's at 200 bar."""
    still = {entry.name: np.zeros(3) for entry in CircuitModel(rig).circuit.states}
    still.update(line_a_pressure=np.full(3, 300 * BAR), line_b_pressure=np.full(3, 20 * BAR))
    model = CircuitModel(rig, {}, {'line.compressibility_under_pressure': 0.8})
    found = model.run(np.arange(3.0), {}, still)
    usual = rig.line.volume / (rig.line.bulk_modulus * rig.motor.displacement)
    for name, factor in (('a_storage', 0.7), ('b_storage', -0.98)):
        np.testing.assert_allclose(found[name], factor * usual)


def test_equal_lines_exchange_no_oil_and_pass_the_play():
    """What passes from line to line goes with their difference; play is passed about none."""
    still = {name: np.full(3, value) for name, value in (
        ('pump_displacement', 0.0), ('line_a_pressure', 24 * BAR), ('line_b_pressure', 24 * BAR),
        ('motor_speed', 0.0), ('motor_angle', 0.0))}
    time = np.arange(3.0)
    found = {name: CircuitModel(CLOSED, effects).run(time, {}, still) for name, effects in (
        ('none', {}), ('cross', {'cross_port_leakage': {}}), ('play', {'gear_backlash': {}}))}
    np.testing.assert_allclose(found['cross']['speed_by_a'], found['none']['speed_by_a'])
    angle, band = 0.02, 20.0
    swept, storage = 2 * 3 * 560 * CC_REV, 0.0025 / 1.3e9
    assert found['play']['a_storage'][0] * swept == pytest.approx(
        storage + swept**2 * angle / (2 * band), rel=1e-3)


@pytest.mark.parametrize('line_a, line_b', [(0, 0), (5, 5), (20, 20), (0, 200), (30, 200)])
def test_the_charge_pump_gives_no_more_than_it_has(line_a, line_b):
    """Check valves and relief share its flow; none of it comes from the relief."""
    flow, check, override, relief = 28.8 * L_MIN, 0.05e5 / L_MIN, 0.08e5 / L_MIN, 24 * BAR
    charge = charged(line_a * BAR, line_b * BAR, flow, relief, 1.0 / override, 1.0 / check)
    through = sum(max(charge - line * BAR, 0.0) / check for line in (line_a, line_b))
    assert through + max(charge - relief, 0.0) / override == pytest.approx(flow)


@pytest.mark.parametrize('section, key, words', [
    ('pump', 'displacement_vs_command', "key 'pump.displacement_vs_command' is missing"),
    ('line', 'volume_m3', "key 'line.volume_m3' is missing; 'circuit: closed' needs it"),
    ('motor', 'inertia_total_kg_m2', "key 'motor.inertia_total_kg_m2' is missing")])
def test_numbers_that_the_equations_need_are_asked_for(section, key, words):
    """A part may leave them out, a circuit may not."""
    content = read_yaml(share('config', 'rig', 'closed_rig.yaml'))
    content[section] = {name: value for name, value in content[section].items() if name != key}
    with pytest.raises(InputError, match=words):
        CircuitModel(parse_rig(content), compiled=False)


def test_a_stiffer_machine_than_can_be_integrated_is_told():
    """A line of some drops with a hard check valve."""
    content = read_yaml(share('config', 'rig', 'closed_rig.yaml'))
    content['line'] = {**content['line'], 'volume_m3': 1e-5}
    with pytest.raises(InputError, match='would need integration steps of'):
        CircuitModel(parse_rig(content), compiled=False)


def test_sections_of_another_circuit_are_told():
    """They would be ignored without a word."""
    content = read_yaml(share('config', 'rig', 'closed_rig.yaml'))
    with pytest.raises(InputError, match="'supply' belongs to 'circuit: valve'"):
        parse_rig({**content, 'supply': {'pressure_bar': 200}})
    with pytest.raises(InputError, match='knows the open circuit only'):
        CLOSED.require('relief_valve', purpose='export')


def test_unknown_circuits_and_missing_sections_are_told():
    """One line each."""
    content = read_yaml(share('config', 'rig', 'closed_rig.yaml'))
    with pytest.raises(InputError, match="unknown circuit 'clsed'; did you mean 'closed'"):
        circuit_of(parse_rig({**content, 'circuit': 'clsed'}))
    without = {key: value for key, value in content.items() if key != 'charge'}
    with pytest.raises(InputError, match="section 'charge' is missing; 'circuit: closed' needs"):
        part_model(parse_rig(without))
    with pytest.raises(InputError, match='delivers both ways'):
        parse_rig({key: value for key, value in content.items() if key != 'circuit'})


def test_motors_on_a_gear_are_one_at_the_measured_shaft():
    """Two motors of half the size behind a gear of 3: the sheet's numbers, thrice as slow."""
    one = dataclasses.replace(CLOSED.motor)
    assert one.displacement == pytest.approx(2 * 3 * 560 * CC_REV)
    assert one.leakage(100 * BAR, 1.0) == pytest.approx(2 * 0.8 * L_MIN, rel=1e-3)
    assert one.torque_loss == pytest.approx((6 * 20 * 0.97, 18 * 0.6 * 0.97, 1 - 0.96 * 0.97))
