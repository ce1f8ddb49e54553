# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the sensors of a simulated closed circuit read."""
from dataclasses import replace

from hst_drive.errors import InputError
from hst_drive.nodes.simulated import simulated
from hst_drive.resources import share
from hst_drive.rig import load_rig
import numpy as np
import pytest

RIG = load_rig(share('config', 'rig', 'closed_rig.yaml'))


def played(effects):
    """Return the quantities over a second in which the drive starts."""
    drive = simulated(RIG, effects)
    times = np.linspace(0.0, 1.0, 11)
    return drive.simulate(times, {
        'pump_command': np.full(11, 3.0), 'opposing_torque': np.full(11, 500.0),
        'oil_temperature': np.full(11, 323.15)}, drive.start(0.0, 0.0))


@pytest.mark.parametrize('effect, values, signal, read', [
    ('pressure_sensor_bias', {'bias': 4e5}, 'line_a_pressure', lambda true: true + 4e5),
    ('flow_sensor_scale', {'gain_error': 0.1}, 'motor_inlet_flow', lambda true: 1.1 * true),
    ('torque_sensor_scale', {'gain_error': 0.1, 'knee': 0.0}, 'motor_torque',
     lambda true: 1.1 * true)])
def test_a_sensor_that_is_off_reads_so_and_moves_nothing(effect, values, signal, read):
    true, off = played({}), played({effect: values})
    assert np.ptp(true[signal]) > 0.0
    for name, expected in true.items():
        assert off[name] == pytest.approx(read(expected) if name == signal else expected)


def test_what_cannot_be_played_is_refused():
    with pytest.raises(InputError, match="'speed_sensor_lag': cannot be played with 'circuit: cl"):
        simulated(RIG, {'speed_sensor_lag': {}})
    with pytest.raises(InputError, match="'prv_cracking': does not enter"):
        simulated(RIG, {'prv_cracking': {}})
    adopted = replace(RIG, effects={'speed_sensor_lag': {'time_constant': 0.2, 'series': 0.0}})
    with pytest.raises(InputError, match='cannot be played'):
        simulated(adopted, {})
