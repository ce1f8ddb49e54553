# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the error sits: a made-up error comes back where it was put."""
from types import SimpleNamespace

from hst_drive.measure.run import Run
from hst_drive.report.fails import error_maps
import numpy as np


def made_up(wrong):
    """Return a log whose speed error is ``wrong(pressure in bar, speed in rpm)``, rpm."""
    random = np.random.default_rng(3)
    time = np.arange(60_000) * 0.01
    # Slow enough for the smoothing of 0.1 s to leave it.
    pressure = 50 + 45 * np.sin(time / 7)
    speed = 80 + 60 * np.sin(time / 11 + 1)
    run = Run('made up', time, {
        'pump_outlet_pressure': pressure * 1e5, 'motor_speed': speed * np.pi / 30,
        'pump_command': random.uniform(4, 6, len(time)),
        'oil_temperature': np.full(len(time), 323.15)})
    error = wrong(pressure, speed) * np.pi / 30
    return SimpleNamespace(run=run, measured=run.channels.get,
                           model={'motor_speed': run['motor_speed'] + error},
                           signals={'motor_speed': SimpleNamespace(floor=np.pi / 30)})


def test_an_error_at_high_pressure():
    log = made_up(lambda pressure, speed: np.where(pressure > 70, 6.0, 0.5))
    found = error_maps([log], ['motor_speed'])['motor_speed']
    grid = found['map']
    assert (grid['x'], grid['y']) == ('pump_outlet_pressure', 'motor_speed')
    edges, cells = grid['xEdges'], grid['cells']
    assert abs(edges[0] - 5) < 1 and abs(edges[-1] - 95) < 1
    for row in cells:
        for low, high, value in zip(edges, edges[1:], row):
            if value is not None and (high < 69 or low > 71):
                assert np.isclose(value, 6.0 if low > 71 else 0.5, rtol=1e-6)


def test_an_error_over_the_command_has_its_sign():
    log = made_up(lambda pressure, speed: 0.0 * pressure)
    command = log.run['pump_command']
    log.model['motor_speed'] = log.run['motor_speed'] - (command - 5.0) * np.pi / 30
    over = error_maps([log], ['motor_speed'])['motor_speed']['over']
    assert 'oil_temperature' not in over    # it did not vary
    strips = over['pump_command']
    assert np.allclose(strips['mean'], 5.0 - np.array(strips['x']), atol=0.02)


def test_without_pressure_there_is_no_map():
    log = made_up(lambda pressure, speed: pressure)
    del log.run.channels['pump_outlet_pressure']
    assert error_maps([log], ['motor_speed'])['motor_speed']['map'] is None
