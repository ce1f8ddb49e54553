# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What is worth a name, on made-up noise ratios whose answer is known."""
from hst_drive.identify.judge import matters
import pytest


@pytest.mark.parametrize('share, worth', [(0.09, False), (0.11, True)])
def test_a_tenth_of_one_signals_squared_error_matters(share, worth):
    before = {'motor_speed': 2.0, 'load_torque': 1.0}
    after = {**before, 'motor_speed': 2.0 * (1.0 - share)**0.5}
    assert matters(before, after, {}) is worth and not matters(before, before, {})


@pytest.mark.parametrize('done, left, worth', [
    (20.0, 1.0, False), (8.0, 1.0, True), (20.0, 0.4, True)])
def test_what_another_formula_of_what_is_there_may_do_does_not_matter(done, left, worth):
    """Formulas may be off by two floors, or by 0.8, of which the squared error falls by one."""
    before, after = {'motor_torque': (1.0 + left)**0.5}, {'motor_torque': left**0.5}
    assert matters(before, after, {'motor_torque': done}) is worth
