# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Readings that come some milliseconds late, each by its own amplifier and bus."""
from dataclasses import replace
from test.measure.test_circuit import campaign
from test.truth import make_campaign

from bench.campaigns import as_runs
from hst_drive.diagnose.decide import diagnose
import numpy as np
import pytest

pytestmark = pytest.mark.needs_numba
FILTER = 0.006      # s, of every amplifier
DELAYS = {'pump_outlet_pressure': 0.008, 'motor_inlet_flow': 0.002, 'motor_speed': 0.004,
          'load_torque': 0.001}
OF_LINES = {'line_a_pressure': 0.008, 'line_b_pressure': 0.008, 'charge_pressure': 0.005,
            'motor_speed': 0.003}


@pytest.mark.parametrize('hidden', [None, 'line_loss'])
def test_a_drive_whose_readings_are_late_lacks_nothing_else(hidden):
    found = diagnose(*as_runs(make_campaign(
        29001, {hidden: 1.0} if hidden else {}, sensor_filter=FILTER, delay=DELAYS)))
    assert found.verdict == ('missing_effect' if hidden else 'none')
    assert [entry.id for entry in found.effects] == [hidden][:bool(hidden)]


@pytest.mark.slow
def test_a_closed_circuit_whose_readings_are_late_lacks_nothing(tmp_path):
    rig, logs, _ = campaign(tmp_path, '--circuit', 'closed', '--kind', 'none', '--seed', '29001')
    late = [replace(run, channels={**run.channels, **{
        name: np.interp(run.time - delay, run.time, run[name])
        for name, delay in OF_LINES.items()}}) for run in logs.values()]
    assert diagnose(rig, late).verdict == 'none'
