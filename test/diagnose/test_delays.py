# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Readings that come some milliseconds late, each by its own amplifier and bus."""
from test.truth import make_campaign
from test.truth.closed.make import make_campaign as make_closed, write_campaign

from bench.campaigns import as_runs
from hst_drive.bag import read_log
from hst_drive.diagnose.adopt import adopt
from hst_drive.diagnose.commission import commission
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.result import as_json
from hst_drive.identify.calibrate import calibrated
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.model import Model
from hst_drive.identify.part import campaign_of
from hst_drive.measure.run import Run
from hst_drive.rig import load_rig, parse_rig
from hst_drive.rig.yaml_file import read_yaml
import numpy as np
import pytest
from scipy.signal import lfilter

pytestmark = pytest.mark.needs_numba
FILTER = 0.006      # s, of every amplifier but that of the speed
DELAYS = {'pump_outlet_pressure': 0.008, 'motor_inlet_flow': 0.002, 'motor_speed': 0.004,
          'load_torque': 0.001}
OF_LINES = {'line_a_pressure': 0.002, 'line_b_pressure': 0.002, 'motor_torque': 0.016,
            'motor_speed': 0.012}


def told(found):
    """Return by how much more than the flow each sensor reads late, s."""
    late = {entry.channel: entry.value for entry in found.delays}
    # What all have in common may be the actuator's.
    return {name: value - late['motor_inlet_flow'] for name, value in late.items()}


def test_what_takes_the_delays_up_is_named_alone():
    found = diagnose(*as_runs(make_campaign(
        29001, {'line_loss': 1.0}, sensor_filter=FILTER, delay=DELAYS)))
    assert found.verdict == 'missing_effect'
    assert [entry.id for entry in found.effects] == ['line_loss']


@pytest.mark.parametrize('hidden', [None, 'motor_leakage'])
def test_a_drive_whose_readings_are_late_lacks_nothing_else(hidden):
    made = make_campaign(29001, {hidden: 1.0} if hidden else {}, sensor_filter=FILTER,
                         delay=DELAYS)
    rig, runs, held = as_runs(made)
    found = diagnose(rig, runs, held)
    assert found.verdict == ('missing_effect' if hidden else 'none')
    assert [entry.id for entry in found.effects] == [hidden][:bool(hidden)]
    assert told(found)['pump_outlet_pressure'] == pytest.approx(0.006, abs=0.002)

    # Adopted, the rig explains the logs as it stands.
    adopted = parse_rig(adopt(made.sheet, as_json(found), 'd.json', 'rig.yaml',
                              calibration=not hidden))
    assert adopted.delays.keys() == DELAYS.keys()
    campaign = Campaign(adopted, runs, held)
    left = campaign.ratios(campaign.errors(Model()), True)
    assert left['pump_outlet_pressure'] < 1.2


@pytest.mark.parametrize('delay, std, left', [(0.008, 0.005, 1.1), (0.03, 0.02, 1.8)])
def test_a_shaft_whose_torque_reads_late_has_its_inertia(delay, std, left):
    """Two filters in a row of half the delay each, over what turns 20 kg.m^2; 1 N.m of noise."""
    time, fine = np.arange(0.0, 60.0, 0.01), np.arange(0.0, 60.0, 0.001)
    waves = [(6.0, 2.5, 0.0), (3.0, 6.9, 1.0), (1.0, 18.8, 0.0)]   # rad/s, rad/s, rad
    torque = sum(20.0 * size * rate * np.cos(rate * fine + phase) for size, rate, phase in waves)
    share = 1.0 / (1.0 + 500.0 * delay)     # its mean delay is that of half, in steps of 1 ms
    for _ in range(2):
        torque = lfilter([share], [1.0, share - 1.0], torque)
    random = np.random.default_rng(0)
    run = Run('a', time, {
        'motor_speed': 20.0 + 0.005 * random.standard_normal(len(time)) + sum(
            size * np.sin(rate * time + phase) for size, rate, phase in waves),
        'motor_torque': torque[::10] + random.standard_normal(len(time))}, 'a.csv')
    campaign = campaign_of(parse_rig({
        'name': 'axis', 'motor': {'inertia_total_kg_m2': 20.0},
        'tolerances_1_sigma_relative': {'motor.inertia': 0.05},
        'sensors': {'motor_torque': {'delay_std_s': std}, 'motor_speed': {'delay_std_s': 0.0}},
    }), [run])
    found = calibrated(campaign)
    assert found.model.delays['motor_torque.delay'] == pytest.approx(delay, rel=0.03)
    assert found.model.factors['motor.inertia'] == pytest.approx(0.0, abs=0.004)
    assert campaign.ratios(found.errors, None)['motor_torque'] < left


@pytest.mark.slow
def test_a_machine_whose_readings_are_late_is_commissioned_with_them():
    """Without them it has another stiffness of the oil and lag of the PPRV, which hides air."""
    made = make_campaign(29001, {}, sensor_filter=FILTER, delay=DELAYS)
    unit = commission(made.sheet, 'rig.yaml', as_runs(made)[1][:1]).rig
    late = {name: sensor['delay_s'] for name, sensor in unit['sensors'].items()
            if 'delay_s' in sensor}
    assert late['pump_outlet_pressure'] - late['motor_inlet_flow'] == pytest.approx(
        0.006, abs=0.002)
    for hidden in ([], ['entrained_air']):
        another_day = make_campaign(29006, dict.fromkeys(hidden, 0.5), unit_seed=29001,
                                    sensor_filter=FILTER, delay=DELAYS)
        found = diagnose(parse_rig(unit), as_runs(another_day)[1])
        assert [entry.id for entry in found.effects] == hidden and not found.unknown


@pytest.mark.slow
def test_a_closed_circuit_whose_readings_are_late_lacks_nothing(tmp_path):
    folder = write_campaign(make_closed('closed', 29003, delay=OF_LINES), tmp_path)
    logs = [read_log(file) for file in sorted(folder.glob('*.csv'))]
    found = diagnose(load_rig(folder / 'rig.yaml'), logs)
    assert found.verdict == 'none'
    late = {entry.channel: entry.value for entry in found.delays}
    assert late['motor_torque'] - late['line_a_pressure'] == pytest.approx(0.014, abs=0.004)
    assert late['line_b_pressure'] == pytest.approx(late['line_a_pressure'], abs=0.002)


@pytest.mark.slow
def test_a_speed_that_reads_late_since_commissioning_is_told(tmp_path):
    """It passed for four other sensors that read early."""
    def logs(place, **delay):
        folder = write_campaign(make_closed('closed', 29003, {}, delay=delay), tmp_path / place)
        return read_yaml(folder / 'rig.yaml'), [
            read_log(file) for file in sorted(folder.glob('*.csv'))]

    make, healthy = logs('healthy')
    unit = parse_rig(commission(make, 'rig.yaml', healthy[:2]).rig, 'unit.yaml')
    assert diagnose(unit, healthy[2:]).verdict == 'none'
    lag, = diagnose(unit, logs('late', motor_speed=0.02)[1][2:]).effects
    assert lag.id == 'speed_sensor_lag'
    assert lag.parameters['time_constant'].value == pytest.approx(0.02, abs=0.004)
