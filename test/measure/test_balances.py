# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which balances a log closes."""
from hst_drive.diagnose.decide import diagnose
from hst_drive.errors import InputError
from hst_drive.measure.balances import closed
from hst_drive.measure.run import Run
from hst_drive.rig import default_rig
import numpy as np
import pytest


def log(seconds, *channels):
    """Return a log at rest in its operating point, with a little noise."""
    values = {'pump_outlet_pressure': 60e5, 'motor_inlet_flow': 3.3e-4, 'motor_speed': 10.0,
              'load_torque': 150.0, 'pump_command': 5.6, 'pprv_command': 2.5}
    time = np.arange(0.0, seconds, 0.01)
    random = np.random.default_rng(0)
    return Run('log', time, {name: values[name] * (1 + 1e-3 * random.standard_normal(len(time)))
                             for name in channels}, 'log.csv')


def test_a_pump_that_can_be_set_is_not_taken_for_one_at_full_stroke():
    """Without command and stroke the flow is the hydromotor's alone to predict."""
    measured = ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque')
    found = closed(log(10.0, *measured), default_rig())
    assert 'pump flow' not in found.values()
    assert found['motor_inlet_flow'] == 'hydromotor flow'
    assert closed(log(10.0, *measured, 'pump_command'), default_rig())[
        'motor_inlet_flow'] == 'pump flow'


def test_a_log_with_nothing_to_judge_on_is_refused():
    short = log(0.25, 'pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'pump_command',
                'pprv_command')
    with pytest.raises(InputError, match='log.csv: .*too short'):
        diagnose(default_rig(), [short])
