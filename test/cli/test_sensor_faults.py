# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the verbs say of recordings that a sensor has spoilt."""
from pathlib import Path
import subprocess
import sys

from hst_drive.bag import read_log, write_csv
import numpy as np
import pytest

TREE = Path(__file__).resolve().parents[2]
CASES = TREE.parent / 'shared' / 'cases'
pytestmark = pytest.mark.skipif(not CASES.is_dir(), reason='no recordings beside the project')


def verb(*arguments):
    """Run a verb; return exit code, output and errors."""
    done = subprocess.run([sys.executable, '-m', 'hst_drive', *map(str, arguments)], cwd=TREE,
                          text=True, capture_output=True, check=False)
    return done.returncode, done.stdout, done.stderr


def spoilt(folder, change):
    """Write a recording after a change to its channels."""
    run = read_log(CASES / 'no_effect' / 'drilling.csv')
    change(run.channels)
    write_csv(folder / 'log.csv', run)
    return folder / 'log.csv'


def spikes(channels):
    channels['motor_speed'][500:5800:350] += 8.0


def freeze(channels):
    channels['pump_outlet_pressure'][2000:2500] = channels['pump_outlet_pressure'][2000]


def no_torque(channels):
    channels['load_torque'][2000:2500] = np.nan


@pytest.mark.parametrize('change, told', (
    (spikes, 'log: motor_speed: 16 of 6000 samples are spikes'),
    (freeze, 'log: pump_outlet_pressure: stands still to the last digit from 20 to 24.99 s'),
    (no_torque, 'log: load_torque: 500 of 6000 samples missing')))
def test_compare_judges_the_drive_and_not_the_sensor(tmp_path, change, told):
    code, out, err = verb('compare', spoilt(tmp_path, change))
    assert code == 0 and told in err
    assert 'explains the measurements down to the noise' in out


def test_a_wrong_unit_is_told_by_both_verbs(tmp_path):
    def rad_s_as_rpm(channels):
        channels['motor_speed'] *= np.pi / 30

    log = spoilt(tmp_path, rad_s_as_rpm)
    code, _, err = verb('compare', log)
    assert code == 0 and 'say (rad/s as rpm?); mend the unit' in err
    code, out, err = verb('diagnose', log)
    assert code == 2 and out == '' and len(err.strip().splitlines()) == 1
    assert 'log.csv: motor_speed reads 0.103 times what pump_command' in err
