# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Another day of a machine that is known well: by chance half of a log may look odd, not all."""
from test.truth import make_campaign

from bench.campaigns import run_of
from hst_drive.diagnose.decide import diagnose
from hst_drive.rig import parse_rig
import numpy as np
import pytest

pytestmark = pytest.mark.needs_numba
SHARE = 0.1     # of the make's tolerances, by which one machine differs from day to day


@pytest.mark.parametrize('roughness, celsius', [(1.5, 50.0), (0.5, 63.0)])
def test_what_half_of_the_rows_show_by_chance_is_no_alarm(roughness, celsius):
    """Rough rock is off in the held-out seconds alone; so is a pump near its dead band."""
    number = 112 if roughness > 1.0 else 111
    logs = ('drilling', 'speed_sweep')
    made = make_campaign(
        932_000 + number, {'leakage_temperature': {'size': 1.0, 'form': 'walther'}},
        unit_seed=910_022, duration=30.0, logs=logs, roughness=roughness, keep_exact=False,
        temperature={log: (celsius - 1.0, celsius + 1.0) for log in logs})
    tolerances = made.sheet['tolerances_1_sigma_relative']
    sheet = {**made.sheet, 'calibration': made.truth['scatter'], 'commissioned': {
        'sigma_relative': {key: SHARE * value for key, value in tolerances.items()},
        'correlation': np.eye(len(tolerances)).tolist(), 'day_to_day_share_of_tolerance': SHARE,
        'conditions': {'oil_temperature_degC': [49.0, 51.0]}}}
    found = diagnose(parse_rig(sheet, 'unit'), [run_of(*log) for log in made.logs.items()])
    assert found.verdict == 'none'
