# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A log of a pump bench may begin with the plate anywhere in its play."""
from dataclasses import replace

from hst_drive.measure.part import PartReplay
from hst_drive.measure.run import Run
from hst_drive.model.part import PartModel
from hst_drive.rig import default_rig
import numpy as np
import pytest

PUMP = replace(default_rig(), motor=None, loading=None, line=None, relief_valve=None)
WIDTH, PRESSURE = 0.4, 80e5


def bench(offset, scale=1.0, flow_error=0.0):
    """Return a slow rise and fall of the command; the plate stands ``offset`` volts off it."""
    time = np.arange(0.0, 20.0, 0.01)
    command = 4.0 + np.interp(time, [0, 1, 8, 12, 20], [0, 0, 1.0, 1.0, -0.5])
    plate, behind = [], command[0] + offset
    for value in command:
        behind = min(max(behind, value - 0.5 * WIDTH), value + 0.5 * WIDTH)
        plate.append(behind)
    pump = PUMP.pump
    stroke = scale * pump.displacement(np.array(plate))
    flow = (stroke * pump.shaft_speed - pump.leakage(PRESSURE, command)) * (1.0 + flow_error)
    return Run('bench', time, {
        'pump_command': command, 'pump_speed': np.full(len(time), pump.shaft_speed),
        'pump_outlet_pressure': np.full(len(time), PRESSURE), 'motor_inlet_flow': flow}, 'b.csv')


@pytest.mark.parametrize('scale, flow_error', [(1.0, 0.0), (1.04, 0.0), (1.0, 0.03)])
@pytest.mark.parametrize('offset', [-0.2, -0.1, 0.0, 0.2])
def test_the_plate_rests_where_the_flow_says(offset, scale, flow_error):
    model = PartModel(PUMP, {
        'pump_hysteresis': {'width': WIDTH, 'softness': 0.0, 'spread': 0.0},
        'flow_sensor_scale': {'gain_error': flow_error}},
        {'pump.displacement_vs_command': scale})
    run = bench(offset, scale, flow_error)
    found = PartReplay(run, model).predict(model)['motor_inlet_flow']
    # What is left is the lag of the displacement in slow ramps.
    fastest = np.abs(np.gradient(run['motor_inlet_flow'], run.time)).max()
    late = fastest * PUMP.pump.displacement_lag
    assert np.abs(found - run['motor_inlet_flow']).max() < 1.5 * late
    assert late < 0.02 * np.ptp(run['motor_inlet_flow'])


@pytest.mark.parametrize('full', [0.0, 2.0])
@pytest.mark.parametrize('channel', ['pump_displacement', 'motor_inlet_flow'])
def test_a_plate_that_is_on_its_way_when_a_log_begins_goes_on_from_there(channel, full):
    """With a lag, or at its greatest speed on a straight line, to where the command wants it."""
    pump, start, lag = PUMP.pump, 0.3, PUMP.pump.displacement_lag
    time = np.arange(0.0, 10.0, 0.01)
    command, target = np.full(len(time), 8.0), float(pump.displacement(8.0))
    plate = np.minimum(start * target + time * pump.max_displacement / full, target) if full else (
        target * (1.0 - (1.0 - start) * np.exp(-time / lag)))
    flow = plate * pump.shaft_speed - pump.leakage(PRESSURE, command)
    run = Run('bench', time, {
        'pump_command': command, 'pump_speed': np.full(len(time), pump.shaft_speed),
        'pump_outlet_pressure': np.full(len(time), PRESSURE), channel: {
            'pump_displacement': plate, 'motor_inlet_flow': flow}[channel]}, 'b.csv')
    model = PartModel(PUMP, {'pump_rate_limit': {'full_stroke_time': full, 'asymmetry': 0.0}})
    found = PartReplay(run, model).predict(model)[channel]
    # Near its target a plate with a limited speed slows down, with the displacement's lag.
    rises = plate < target - lag * pump.max_displacement / full if full else time < 10.0 * lag
    assert rises.sum() > 50
    assert found[rises] == pytest.approx(run[channel][rises], rel=0.01)
