# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Streams of samples and figures of merit against closed forms and the drive that made them."""
import math

from hst_drive.losses.efficiency import Limits
from hst_drive.measure.circuit_balances import watched
from hst_drive.model.part import PartModel
from hst_drive.rig import default_rig
from hst_drive.watch.characteristic import Characteristic
from hst_drive.watch.drive import Observer, Settings
from hst_drive.watch.figures import (
    Accuracy, bell, FLOW, judged, measured, moment_of, PRESSURE, SIGNALS, SPEED, TORQUE,
    uncertainty)
from hst_drive.watch.stream import Stream, Window
import numpy as np
import pytest

BILLION = 10**9
RIG = default_rig()
MODEL, BALANCES = PartModel(RIG), judged(watched(SIGNALS, RIG), RIG.circuit)
DISPLACEMENT = 195e-6 / (2 * np.pi)
ALL = (*SIGNALS, 'pump_command', 'pprv_command', 'oil_temperature')
STEADY = {SPEED: 10.0, TORQUE: 200.0, PRESSURE: 75e5, FLOW: 20e-3 / 60, 'pump_command': 5.7,
          'pprv_command': 2.5, 'oil_temperature': 323.15}


def moment(window):
    """Return the motor in the middle of half a second."""
    return moment_of(window, 245_000_000, MODEL, BALANCES, 0.04)


def feed(observer, seconds, first=1.0, leave_out=(), signals=None):
    """Feed steady signals at 100 Hz; return what was told."""
    figures, watched = [], []
    for step in range(round(seconds * 100)):
        stamp = round((first + step / 100) * BILLION)
        for name, value in {**STEADY, **(signals or {})}.items():
            if name not in leave_out:
                observer.put(name, stamp, value)
        if observer.reached() is not None:
            found = observer.advance(observer.reached())
            figures += found.figures
            watched += found.watched
    return figures, watched


def test_late_repeated_and_useless_samples_do_not_count():
    stream = Stream(('motor_speed',), 2.0, 0.5)
    assert stream.put('motor_speed', BILLION, 1.0)
    assert not stream.put('motor_speed', BILLION, 2.0)
    assert not stream.put('motor_speed', BILLION - 1, 2.0)
    assert not stream.put('motor_speed', 2 * BILLION, math.nan)
    assert not stream.put('motor_speed', 2 * BILLION, math.inf)
    assert stream.newest('motor_speed') == BILLION and stream.restarts == 0


def test_time_that_jumps_back_is_a_new_start():
    stream = Stream(('motor_speed', TORQUE), 2.0, 0.5)
    for second in range(5, 9):
        stream.put('motor_speed', second * BILLION, 1.0)
    assert stream.put('motor_speed', BILLION, 3.0)
    assert stream.restarts == 1 and stream.newest(TORQUE) is None
    assert stream.newest('motor_speed') == BILLION


def test_commands_hold_and_readings_move_on_a_line():
    stream = Stream(('motor_speed', PRESSURE, 'pump_command'), 2.0, 0.5)
    for step in range(11):
        stream.put('motor_speed', step * BILLION // 10, 0.0)
    for step, value in ((0, 0.0), (5, 5.0), (10, 10.0)):
        stream.put(PRESSURE, step * BILLION // 10, value)
        stream.put('pump_command', step * BILLION // 10, value)
    window = stream.window((PRESSURE, 'pump_command'), 0, BILLION)
    assert window.values[PRESSURE] == pytest.approx(np.arange(10.0))
    assert window.values['pump_command'].tolist() == [0.0] * 5 + [5.0] * 5
    assert stream.missing((PRESSURE,), 0, BILLION) == []
    assert stream.missing((PRESSURE,), 0, 2 * BILLION) == [PRESSURE]


def test_a_window_is_thinned_by_means():
    window = Window(0, np.arange(301) / 100, {SPEED: np.arange(301.0)})
    assert window.thinned(100.0) is window
    thin = window.thinned(20.0)
    assert (len(thin.time), thin.samples) == (60, 5)
    assert thin.values[SPEED] == pytest.approx(100.0 * thin.time)
    assert thin.values[SPEED][-1] == 298.0


def test_a_gap_is_found():
    stream = Stream((PRESSURE,), 4.0, 0.3)
    for step in (*range(100), *range(140, 200)):
        stream.put(PRESSURE, step * BILLION // 100, 1.0)
    assert stream.missing((PRESSURE,), 0, BILLION) == []
    assert stream.missing((PRESSURE,), BILLION, 2 * BILLION) == [PRESSURE]


def test_level_and_rate_of_a_line_are_exact():
    time = np.arange(50) / 100
    level, rate = bell(time, 0.245)
    line = 3.0 + 7.0 * time
    assert level @ line == pytest.approx(3.0 + 7.0 * 0.245)
    assert rate @ line == pytest.approx(7.0)
    assert bell(time[:3], 0.0) is None and bell(time, 0.49) is None
    late, _ = bell(time, 0.345, 0.2)
    assert not late[:20].any() and late @ line == pytest.approx(3.0 + 7.0 * 0.345)


def test_the_rate_is_the_derivative_of_the_level():
    """What makes balances hold across jumps: the smoothed rate is the rate of the smoothed."""
    time = np.arange(60) / 1000
    step = np.where(time < 0.0222, 0.0, 1.0)
    _, rate = bell(time, 0.03)
    place = (0.0222 - 0.03) / 0.0305
    # Derivative of the weight's running integral at the jump: the weight there.
    assert rate @ step == pytest.approx(15 / 16 * (1 - place**2)**2 / 0.0305, rel=0.03)


def test_torque_that_the_inertia_takes_is_not_lost():
    """A motor without losses that speeds up: 100 % at every moment."""
    time = np.arange(50) / 100
    speed = 8.0 + 12.0 * time
    pressure = np.full(50, 60e5)
    values = {SPEED: speed, PRESSURE: pressure, FLOW: DISPLACEMENT * speed,
              TORQUE: pressure * DISPLACEMENT - MODEL.inertia * 12.0}
    figures, reason = measured(moment(Window(0, time, values)), DISPLACEMENT)
    assert not reason
    assert figures.volumetric == pytest.approx(1.0, abs=1e-9)
    assert figures.hydromechanical == pytest.approx(1.0, abs=1e-9)


def test_uncertainty_is_that_of_draws():
    """Against Monte Carlo over the sensors' offsets."""
    random = np.random.default_rng(1)
    accuracy = Accuracy(pressure=4e4, flow=0.004, torque=1.5)
    window = Window(0, np.arange(50) / 100, {
        name: np.full(50, STEADY[name]) for name in SIGNALS})

    def at(window):
        return measured(moment(window), DISPLACEMENT)[0]

    draws = []
    for _ in range(400):
        off = random.standard_normal(3)
        moved = {SPEED: window.values[SPEED], PRESSURE: window.values[PRESSURE] + 4e4 * off[0],
                 FLOW: window.values[FLOW] * (1 + 0.004 * off[1]),
                 TORQUE: window.values[TORQUE] + 1.5 * off[2]}
        found = at(Window(0, window.time, moved))
        draws.append((found.volumetric, found.hydromechanical, found.overall, found.torque_loss))
    stated = uncertainty(moment(window)._replace(noise=(0.0,) * 4), at(window), DISPLACEMENT,
                         accuracy)
    assert np.std(draws, axis=0) == pytest.approx(
        [stated.volumetric, stated.hydromechanical, stated.overall, stated.torque_loss], rel=0.12)


@pytest.mark.parametrize('signals, word', [
    ({SPEED: 0.0}, 'standstill'), ({SPEED: -10.0}, 'does not drive'),
    ({PRESSURE: 1e5}, 'pressure'), ({FLOW: -1e-4}, 'flow'), ({TORQUE: -50.0}, 'load torque'),
    ({FLOW: math.nan}, 'no flow'), ({TORQUE: math.inf, PRESSURE: math.nan}, 'no pressure')])
def test_no_figure_where_the_signals_say_nothing(signals, word):
    figures, watched = feed(Observer(RIG, ALL), 3.0, signals=signals)
    assert figures and all(entry.measured is None for entry in figures)
    assert word in figures[-1].reason
    assert all(entry.verdict is None or not entry.verdict.failing for entry in watched)


def test_a_sensor_that_falls_silent_is_named_and_comes_back():
    observer = Observer(RIG, ALL)
    figures, _ = feed(observer, 2.0)
    assert figures[-1].measured is not None
    figures, watched = feed(observer, 3.0, 3.0, leave_out=(TORQUE,))
    assert figures[-1].reason == 'no load torque'
    assert watched[-1].reason == 'no load_torque'
    figures, _ = feed(observer, 2.0, 6.0)
    assert figures[-1].measured is not None


def test_a_bag_that_is_played_again_starts_anew():
    observer = Observer(RIG, ALL)
    feed(observer, 4.0, 100.0)
    assert observer.watch.blocks > 0
    figures, _ = feed(observer, 2.0, 1.0)
    assert observer.origin == pytest.approx(BILLION, abs=BILLION)
    assert figures[0].measured is None and figures[-1].measured is not None
    assert figures[-1].stamp < 4 * BILLION


def test_signals_that_contradict_each_other_give_no_figure():
    figures, _ = feed(Observer(RIG, ALL, Settings(limits=Limits())), 2.0, signals={FLOW: 5e-5})
    assert figures[-1].measured is None and 'contradict' in figures[-1].reason


def test_resistances_are_those_of_the_equations():
    """A motor made of R_el, R_1 and R_2 (Eqs. 1 to 4 of the motor-loss paper)."""
    external, port, internal = 8e11, 2.5e9, 1.1e12
    model, learnt = PartModel(RIG), Characteristic(PartModel(RIG), Accuracy(flow=0.02))
    speed, torque = 10.0, 180.0
    through = DISPLACEMENT * speed + torque / DISPLACEMENT / internal
    pressure = torque / DISPLACEMENT + port * through
    drain = pressure / external
    flow = through + drain
    leak = float(RIG.motor.leakage(pressure, speed))
    made = float(RIG.motor.mechanical_efficiency(pressure, speed)) * pressure * DISPLACEMENT
    reason = learnt.resistances(pressure, speed)[1]
    assert 'not valid yet' in reason and 'rpm' in reason
    for _ in range(5):
        learnt.add(pressure, speed, flow - DISPLACEMENT * speed - leak, made - torque, drain)
    found, reason = learnt.resistances(pressure, speed)
    assert not reason
    assert found.external.value == pytest.approx(external)
    assert found.port.value == pytest.approx(port)
    assert found.leakage.value == pytest.approx(pressure / (flow - DISPLACEMENT * speed))
    assert found.leakage.model == pytest.approx(pressure / leak)
    # The internal leakage is smaller than what the flow meter may be off.
    assert found.internal is None
    sure = Characteristic(model, Accuracy(flow=1e-5))
    for _ in range(5):
        sure.add(pressure, speed, flow - DISPLACEMENT * speed - leak, made - torque, drain)
    assert sure.resistances(pressure, speed)[0].internal.value == pytest.approx(internal)


def test_without_the_case_drain_there_is_no_split():
    learnt = Characteristic(PartModel(RIG))
    for _ in range(5):
        learnt.add(50e5, 10.0, 0.0, 0.0)
    found, _ = learnt.resistances(50e5, 10.0)
    assert found.external is None and found.internal is None
    assert found.port.uncertainty > 0.0


def test_a_range_is_valid_once_visited_and_forgets_only_where_it_is_visited():
    learnt = Characteristic(PartModel(RIG), memory=10.0)
    for _ in range(2):
        learnt.add(32e5, 10.0, 1e-6, 1.0)
    assert learnt.at(32e5, 10.0) is None
    for _ in range(20):
        learnt.add(32e5, 10.0, 1e-6, 1.0)
        learnt.add(72e5, 10.0, 3e-6, 2.0)
    assert learnt.at(52e5, 10.0)[0] == pytest.approx(2e-6)
    assert learnt.at(95e5, 10.0) is None and learnt.at(52e5, 14.0) is None
    for _ in range(200):
        learnt.add(72e5, 10.0, 5e-6, 2.0)
    assert learnt.at(32e5, 10.0)[0] == pytest.approx(1e-6)
    assert learnt.at(72e5, 10.0)[0] == pytest.approx(5e-6, rel=1e-3)
