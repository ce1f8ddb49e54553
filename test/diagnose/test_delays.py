# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Readings that come some milliseconds late, each by its own amplifier and bus."""
from test.truth import make_campaign
from test.truth.closed.make import make_campaign as make_closed, write_campaign

from bench.campaigns import as_runs
from hst_drive.bag import read_log
from hst_drive.diagnose.decide import diagnose
from hst_drive.rig import load_rig
import pytest

pytestmark = pytest.mark.needs_numba
FILTER = 0.006      # s, of every amplifier
DELAYS = {'pump_outlet_pressure': 0.008, 'motor_inlet_flow': 0.002, 'motor_speed': 0.004,
          'load_torque': 0.001}
OF_LINES = {'line_a_pressure': 0.002, 'line_b_pressure': 0.002, 'motor_torque': 0.016,
            'motor_speed': 0.012}


@pytest.mark.parametrize('hidden', [None, 'line_loss'])
def test_a_drive_whose_readings_are_late_lacks_nothing_else(hidden):
    found = diagnose(*as_runs(make_campaign(
        29001, {hidden: 1.0} if hidden else {}, sensor_filter=FILTER, delay=DELAYS)))
    assert found.verdict == ('missing_effect' if hidden else 'none')
    assert [entry.id for entry in found.effects] == [hidden][:bool(hidden)]


@pytest.mark.slow
def test_a_closed_circuit_whose_readings_are_late_lacks_nothing(tmp_path):
    folder = write_campaign(make_closed('closed', 29003, delay=OF_LINES), tmp_path)
    logs = [read_log(file) for file in sorted(folder.glob('*.csv'))]
    found = diagnose(load_rig(folder / 'rig.yaml'), logs)
    assert found.verdict == 'none'
    told = {entry.channel: entry.value for entry in found.delays}
    # What all have in common may be the actuator's.
    assert told['motor_torque'] - told['line_a_pressure'] == pytest.approx(0.014, abs=0.004)
    assert told['line_b_pressure'] == pytest.approx(told['line_a_pressure'], abs=0.002)
