# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A gauge in the return line tells what a pressure at the inlet alone cannot."""
from test.truth import make_campaign, write_campaign
from test.truth.sensors import STANDARD

from hst_drive.bag import read_log
from hst_drive.diagnose.decide import diagnose
from hst_drive.measure.part import PartReplay
from hst_drive.measure.replay import Replay
from hst_drive.measure.run import Run
from hst_drive.model import Drive, SensorBank
from hst_drive.model.part import PartModel
from hst_drive.rig import default_rig
import numpy as np
import pytest

GAUGE = 'motor_outlet_pressure'
RETURN = 4e5    # Pa, of the truth


def found(folder, effects, channels):
    """Diagnose two logs of the truth generator."""
    write_campaign(make_campaign(4002, effects, duration=30.0, channels=channels,
                                 logs=('drilling', 'speed_sweep'), keep_exact=False), folder)
    return diagnose(default_rig(), [read_log(str(path)) for path in sorted(folder.glob('*.csv'))])


@pytest.mark.parametrize('form', ['constant', 'flow_dependent'])
def test_back_pressure_is_named_alone(tmp_path, form):
    result = found(tmp_path, {'back_pressure': {'size': 1.0, 'form': form}}, (*STANDARD, GAUGE))
    assert result.verdict == 'missing_effect'
    named = result.effects[0]
    assert [entry.id for entry in result.effects] == ['back_pressure']
    assert named.parameters['outlet_pressure'].value == pytest.approx(RETURN, rel=0.03)
    # The truth's hydromotor loses as much as without a return pressure.
    assert named.parameters['loss_share'].value == pytest.approx(1.0, abs=0.1)
    assert max(result.ladder[-1].holdout.values()) < 1.15


def test_friction_is_told_from_back_pressure(tmp_path):
    effects = {'bearing_friction': {'size': 1.0, 'form': 'tanh'}}
    for channels, alike in (((*STANDARD, GAUGE), False), (STANDARD, True)):
        named = found(tmp_path, effects, channels).effects[0]
        assert ('back_pressure' in (named.id, *named.indistinguishable_from)) == alike
        assert named.id == 'bearing_friction'      # and no constant torque: it turns one way


def test_a_bench_of_the_hydromotor_alone_closes_the_return_line():
    time = np.arange(500) / 100
    speed = 8.0 + np.sin(time)
    run = Run('bench', time, {'motor_inlet_pressure': 80e5 + 10e5 * np.cos(2 * time),
                              'motor_speed': speed, GAUGE: np.full(500, RETURN),
                              'motor_torque': np.full(500, 200.0)})
    rig = default_rig()
    replay = PartReplay(run, PartModel(rig))
    assert replay.balances[GAUGE].name == 'return line'
    without, outlet, lossy = (
        replay.predict(PartModel(rig, {'back_pressure': {
            'outlet_pressure': size, 'flow_share': 0.25, 'loss_share': loss}}))
        for size, loss in ((0.0, 0.0), (RETURN, 0.0), (RETURN, 1.0)))
    np.testing.assert_allclose(outlet[GAUGE], RETURN * (1 + 0.25 * (speed / 10 - 1)))
    # What was read acts on the torque, whatever is predicted of the return line.
    np.testing.assert_array_equal(without['motor_torque'], outlet['motor_torque'])
    open_end = PartReplay(Run('bench', time, {
        **run.channels, GAUGE: np.zeros(500)}), PartModel(rig)).predict(PartModel(rig))
    # All of it acts on the displacement where the losses stay what they were. (The replay smooths
    # the torque, which shows at the ends.)
    taken = open_end['motor_torque'] - lossy['motor_torque']
    np.testing.assert_allclose(taken[20:-20], RETURN * rig.motor.displacement, rtol=0.03)


def test_a_bench_with_a_gauge_names_back_pressure_alone():
    """All its parameters are fitted where the gauge shows them."""
    rig, random, time = default_rig(), np.random.default_rng(1), np.arange(6000) / 100
    speed = 8 + 4 * np.sin(0.23 * time)
    pressure = (80 + 40 * np.sin(0.4 * time) + 15 * np.sign(np.sin(1.3 * time))) * 1e5
    model = PartModel(rig, {'back_pressure': {
        'outlet_pressure': RETURN, 'flow_share': 0.25, 'loss_share': 1.0}})
    torque = model.motor_torque(model.complete({'motor_speed': speed, 'pressure': pressure,
                                                'pump_pressure': pressure}))
    outlet = RETURN * (1 + 0.25 * (speed / 10 - 1))
    channels = {'motor_inlet_pressure': (pressure, 1e4), 'motor_speed': (speed, 1e-3),
                'motor_torque': (torque, 0.4), GAUGE: (outlet, 1e4)}
    result = diagnose(rig, [Run('bench', time, {
        name: values + noise * random.standard_normal(len(time))
        for name, (values, noise) in channels.items()})])
    assert [entry.id for entry in result.effects] == ['back_pressure']
    found = result.effects[0].parameters
    assert found['outlet_pressure'].value == pytest.approx(RETURN, rel=0.03)
    assert found['flow_share'].value == pytest.approx(0.25, abs=0.05)
    assert found['loss_share'].value == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize('reading, floor', [
    (np.zeros(3000), 0.12e5),                                   # dead, or no return pressure
    (np.round(np.linspace(0, 3.9, 3000)) * 2e5, 2e5 / 12**0.5),     # steps of 2 bar
])
def test_a_gauge_that_shows_no_noise_is_not_taken_for_perfect(reading, floor):
    time = np.arange(3000) / 100
    drive = Drive(default_rig())
    inputs = {'pump_command': np.full(3000, 5.6), 'pprv_command': np.full(3000, 3.0)}
    run = Run('log', time, {**inputs, 'motor_speed': drive.simulate(time, inputs)['motor_speed'],
                            GAUGE: reading})
    assert Replay(run, drive).noise[GAUGE] == pytest.approx(floor, rel=0.05)


@pytest.mark.parametrize('pressure', [0.0, RETURN])
def test_the_plant_reads_it_with_a_usual_gauge(pressure):
    truth = {GAUGE: np.full(4000, pressure), 'motor_speed': np.full(4000, 10.0)}
    assert GAUGE not in SensorBank(default_rig()).read(truth)
    noisy = SensorBank(default_rig(), 1, (GAUGE,)).read(truth)
    assert np.std(noisy[GAUGE]) == pytest.approx(0.12e5, rel=0.1)
    assert np.mean(noisy[GAUGE]) == pytest.approx(pressure, abs=0.01e5)
    assert set(noisy) == {GAUGE, 'motor_speed'}


def test_what_a_cavitating_inlet_does_decides_nothing():
    """Between a return pressure and a wrong zero of the gauge at the inlet, by 1000 nats."""
    rig, random, time = default_rig(), np.random.default_rng(2), np.arange(6000) / 100
    speed = 8 + 4 * np.sin(0.23 * time)
    pressure = (80 + 40 * np.sin(0.4 * time) + 15 * np.sign(np.sin(1.3 * time))) * 1e5
    cut = time % 20.0 < 0.4
    pressure[cut] = -0.9e5
    model = PartModel(rig, {'back_pressure': {
        'outlet_pressure': RETURN, 'flow_share': 0.0, 'loss_share': 0.0}})
    torque = model.motor_torque(model.complete({'motor_speed': speed, 'pressure': pressure,
                                                'oil_temperature': np.full(6000, 323.15)}))
    torque[cut] = (pressure[cut] - RETURN) * rig.motor.displacement
    noise = random.standard_normal((3, 6000))
    run = Run('bench', time, {
        'motor_inlet_pressure': pressure + 0.5e5 * noise[0],
        'motor_speed': speed + 0.02 * noise[1], 'motor_torque': torque + 2.0 * noise[2]})
    result = diagnose(rig, [run])
    effect, = result.effects
    assert {'back_pressure', 'pressure_sensor_bias'} <= {effect.id, *effect.indistinguishable_from}
