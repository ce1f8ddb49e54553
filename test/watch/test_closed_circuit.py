# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The watch on a closed circuit: figures by hand in all quadrants, sound units, what is named."""
from dataclasses import replace
import math

from bench.watch import CLOSED, reversing, watch_unit
from hst_drive.losses.efficiency import braking, Limits, performance, reason_not_valid
from hst_drive.measure.circuit_balances import watched
from hst_drive.model.circuit_model import CircuitModel
from hst_drive.resources import share
from hst_drive.rig import load_rig
from hst_drive.rig.fingerprint import Fingerprint
from hst_drive.watch.drive import Observer
import numpy as np
import pytest

RIG = load_rig(share('config', 'rig', 'closed_rig.yaml'))
# From the rig file, by hand.
SWEPT = 3.0 * 2 * 560e-6 / (2.0 * math.pi)      # m^3/rad at the measured shaft
LEAK = 2 * 0.008 / 6e4 / 1e5                    # m^3/(s.Pa) of both hydromotors
RATE = 100
NOISE = {'motor_speed': 0.03 * math.pi / 30.0, 'motor_torque': 10.0, 'line_a_pressure': 3e4,
         'line_b_pressure': 3e4, 'charge_pressure': 1e4}


def recorded(command, load, seed=0):
    """Return what sensors would tell of a drive at a command (V) and a load's torque (N.m)."""
    time = np.arange(len(command)) / RATE
    inputs = {'pump_command': command, 'motor_torque': load,
              'oil_temperature': np.full(len(time), RIG.characterised_at)}
    found = {**CircuitModel(RIG).run(time, inputs, {}), **inputs}
    random = np.random.default_rng(seed)
    return {name: found[name] + NOISE.get(name, 0.0) * random.standard_normal(len(time))
            for name in CLOSED}


def told(record, signals=CLOSED, rig=RIG):
    """Return what an observer makes of a record."""
    observer, figures, seen = Observer(rig, signals), [], []
    for row in range(len(record['motor_speed'])):
        stamp = round((1.0 + row / RATE) * 1e9)
        for name in set(signals) & record.keys():
            observer.put(name, stamp, float(record[name][row]))
        if observer.reached() is not None:
            found = observer.advance(observer.reached())
            figures += found.figures
            seen += found.watched
    return observer, figures, seen


def steady(command, load, seconds=8.0):
    """Return a record that has settled and the drive's steady state without noise."""
    rows = round((seconds + 12.0) * RATE)
    record = recorded(np.full(rows, command), np.full(rows, load))
    record = {name: values[-round(seconds * RATE):] for name, values in record.items()}
    return record, {name: float(np.mean(values)) for name, values in record.items()}


@pytest.mark.needs_numba
@pytest.mark.parametrize('command, load', [(6.0, 2500.0), (-4.0, -3000.0), (6.0, -2500.0),
                                           (-4.0, 3000.0)],
                         ids=['drives', 'drives back', 'brakes', 'brakes back'])
def test_efficiency_is_that_of_the_datasheet_in_all_quadrants(command, load):
    record, means = steady(command, load)
    speed = means['motor_speed']
    assert speed * command > 0.0
    # By hand: at the hydromotors' own shafts friction is 20 + 0.6 * speed each, and 4 % of the
    # torque; the gear takes 3 % of it, and leakage goes with the pressure of the line.
    difference = (means['line_a_pressure'] - means['line_b_pressure']) * np.sign(speed)
    assert (difference > 0.0) == (speed * load > 0.0)
    high = max(means['line_a_pressure'], means['line_b_pressure'])
    turned = SWEPT * abs(speed)
    _, figures, _ = told(record)
    figures = [entry for entry in figures if entry.measured is not None]
    assert len(figures) > 50
    found, model = (np.mean([getattr(entry, name)[:3] for entry in figures], axis=0)
                    for name in ('measured', 'model'))
    ideal, torque = SWEPT * difference, load * np.sign(speed)
    if difference > 0.0:
        volumetric, mechanical = turned / (turned + LEAK * high), torque / ideal
    else:
        volumetric, mechanical = (turned - LEAK * high) / turned, ideal / torque
    assert found == pytest.approx([volumetric, mechanical, volumetric * mechanical], abs=4e-3)
    assert model == pytest.approx(found, abs=4e-3) and np.all(found < 1.0)
    lost = figures[-1].measured
    assert lost.torque_loss > 0.0 and 0.0 < lost.slip < 0.1
    unsure = figures[-1].uncertainty
    assert abs(found[0] - volumetric) < unsure.volumetric < 0.02


def test_a_motor_that_brakes_has_the_ratios_of_a_pump():
    drives, brakes = performance(1e7, 1.1e-3, 10.0, 900.0, 1e-4), braking(
        -1e7, 0.9e-3, 10.0, -1100.0, 1e-4)
    assert drives.volumetric == pytest.approx(1.0 / 1.1) and drives.torque_loss == 100.0
    assert brakes.volumetric == pytest.approx(0.9) and brakes.torque_loss == 100.0
    # Hydraulic power over shaft power.
    assert brakes.overall == pytest.approx(1e7 * 0.9e-3 / (1100.0 * 10.0))
    assert 'does not drive' in reason_not_valid(-1e7, 1e-3, 10.0, 5.0, Limits())
    assert 'below' in reason_not_valid(-1e5, 1e-3, 10.0, -5.0, Limits())


@pytest.mark.needs_numba
def test_no_figure_without_power():
    """Lines that are alike, and a drive that stands: told, not made up."""
    rows = 10 * RATE
    _, figures, seen = told(recorded(np.full(rows, 5.0), np.zeros(rows)))
    assert all(entry.measured is None for entry in figures[30:])
    assert 'line' in figures[-1].reason or 'pressure' in figures[-1].reason
    _, figures, seen = told(recorded(np.zeros(rows), np.zeros(rows)))
    assert all(entry.measured is None for entry in figures)
    assert {entry.reason for entry in seen} == {'standstill'}


@pytest.mark.needs_numba
@pytest.mark.parametrize('seed', [1, 2])
def test_units_within_tolerance_turn_both_ways_without_alarm(seed):
    """``python -m bench.watch --rig`` does this for hours."""
    blocks, alarms = watch_unit(RIG, seed, 6.0)
    assert blocks > 300 and alarms == []


@pytest.mark.needs_numba
@pytest.mark.parametrize('effect, size, balance', [
    ('motor_leakage', {'conductance': 1e-11}, 'pump_flow'),
    ('bearing_friction', {'coulomb': 250.0}, 'motor_torque'),
    ('charge_pressure_loss', {}, 'charge_pressure')])
def test_what_comes_is_alarmed_and_named(effect, size, balance):
    _, alarms = watch_unit(RIG, 21, 3.0, {effect: size}, begin=1.6)
    assert alarms and balance in alarms[0] and effect in alarms[0]
    block = int(alarms[0].partition('block ')[2].partition(':')[0])
    assert 75 < block < 110         # seconds in which a line is under pressure


@pytest.mark.needs_numba
def test_a_constant_torque_is_named_once_the_drive_has_turned_both_ways():
    pieces = list(reversing(RIG, 21, 2.0, {'constant_torque': {'torque': 200.0}}, begin=1.0))
    *_, seen = told({name: np.concatenate([piece[name] for piece in pieces]) for name in CLOSED})
    named = [[entry.effect for entry in each.verdict.effects] for each in seen
             if each.verdict and each.verdict.failing]
    assert 'constant_torque' not in named[0] and named[-1][0] == 'constant_torque'


@pytest.mark.needs_numba
def test_with_a_machines_own_file_a_leak_that_the_make_swallows_is_told():
    own = replace(RIG, fingerprint=Fingerprint({
        name: 0.12 * sigma for name, sigma in RIG.tolerances.items()}))
    worn = {'motor_leakage': {'conductance': 2e-12}}
    assert watch_unit(own, 41, 2.0)[1] == []
    assert watch_unit(own, 41, 2.0, worn, judged=RIG)[1] == []
    alarms = watch_unit(own, 41, 2.0, worn)[1]
    assert alarms and all('motor_leakage' in alarm for alarm in alarms)


@pytest.mark.needs_numba
def test_without_a_torque_sensor_the_flows_are_watched():
    """What never comes closes no balance; the others go on."""
    record, _ = steady(6.0, 2500.0, 12.0)
    del record['motor_torque']
    observer, figures, seen = told(record)
    assert 'motor_torque' not in observer.balances.closed
    verdicts = [entry.verdict for entry in seen if entry.verdict]
    assert len(verdicts) > 5
    assert 'pump_flow' in {name for entry in verdicts for name in entry.innovations}
    assert figures[-1].reason == 'no hydromotor shaft torque'


def test_the_watch_has_the_balances_of_the_circuit():
    closed = watched((*CLOSED, 'pump_displacement', 'motor_inlet_flow', 'case_drain_flow'), RIG)
    assert {entry.name for entry in closed.values()} == {
        entry.name for entry in CircuitModel(RIG).circuit.balances
        if entry.signal not in ('pump_torque', 'pump_power')}
