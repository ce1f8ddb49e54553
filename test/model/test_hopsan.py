# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The closed circuit beside Hopsan, another simulator: steady states, steps of stroke and load."""
from pathlib import Path

from hst_drive.model.circuit_model import CircuitModel
from hst_drive.rig import load_rig
import numpy as np
import pytest

_HERE = Path(__file__).parent
_TABLE = np.genfromtxt(
    [line for line in (_HERE / 'hopsan_closed.csv').read_text().splitlines() if line[0] != '#'],
    delimiter=',', names=True, dtype=None, encoding='utf-8')
_SIGNALS = {'line_a_pressure': ('line_a_bar', 1e5), 'line_b_pressure': ('line_b_bar', 1e5),
            'charge_pressure': ('charge_bar', 1e5), 'motor_speed': ('speed_rad_s', 1.0)}
# Load before the step (N.m) and stroke after it (of the largest).
_STEPS = {'step_of_stroke': (3000.0, 0.8), 'step_of_load': (2000.0, 0.5),
          'step_to_braking': (-3000.0, -0.7)}


def run(model, time, stroke, load, state):
    """Return a run with stroke (of the largest) and load (N.m) held; ``state`` is its end."""
    return model.run(time, {'pump_command': np.full(len(time), 10.0 * stroke),
                            'motor_torque': np.full(len(time), load)}, {}, state)


@pytest.fixture(scope='module')
def model():
    """Return the machine that Hopsan had."""
    return CircuitModel(load_rig(_HERE / 'hopsan_rig.yaml'))


@pytest.mark.parametrize('case', [f'steady_{number}' for number in range(1, 9)])
def test_steady_states(model, case):
    """Driving and braking, both directions: each signal within half a percent."""
    row = _TABLE[_TABLE['case'] == case][0]
    found = run(model, np.arange(0.0, 10.0, 0.01), row['stroke'], row['load_N_m'],
                model.at_rest())
    for name, (column, unit) in _SIGNALS.items():
        assert found[name][-1] / unit == pytest.approx(row[column], rel=5e-3), name


@pytest.mark.parametrize('case', _STEPS)
def test_steps(model, case):
    """All the way within 1 % of each signal's range; the charge pressure tells steady rows."""
    rows = _TABLE[_TABLE['case'] == case]
    before, after = _STEPS[case]
    state = model.at_rest()
    run(model, np.arange(0.0, 10.0, 0.01), rows['stroke'][0], before, state)
    found = run(model, rows['time_s'], after, rows['load_N_m'][0], state)
    for name in ('line_a_pressure', 'line_b_pressure', 'motor_speed'):
        column, unit = _SIGNALS[name]
        far = np.max(np.abs(found[name] / unit - rows[column]))
        assert far < 0.01 * np.ptp(rows[column]), name
