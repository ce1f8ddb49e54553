# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How models are judged block by block, on made-up blocks whose answer is known."""
from hst_drive.identify.judge import matters, taken
import numpy as np
import pytest


def test_what_is_taken_is_a_share_of_all_blocks_that_were_recorded():
    missing = np.full(3, np.nan)
    before = {'motor_speed': np.array([4.0, np.nan, 2.0]),
              'load_torque': np.array([0.2, 0.4, 0.0]), 'pump_speed': missing}
    after = {'motor_speed': np.array([1.0, np.nan, 2.0]),
             'load_torque': np.zeros(3), 'pump_speed': missing}
    # 6 squared floors before, 3 after; 0.2 is below the floor, of which it is a fifth.
    assert taken(before, after) == {'motor_speed': pytest.approx(0.5),
                                    'load_torque': pytest.approx(0.2)}


@pytest.mark.parametrize('share, worth', [(0.09, False), (0.11, True)])
def test_a_tenth_of_one_signals_squared_error_matters(share, worth):
    before = {'motor_speed': 2.0, 'load_torque': 1.0}
    after = {**before, 'motor_speed': 2.0 * (1.0 - share)**0.5}
    assert matters(before, after) is worth and not matters(before, before)
