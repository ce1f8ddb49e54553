# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Healthy foreign machines that are stopped twice while they are recorded are healthy."""
from test.truth import make_campaign, profiles

from bench.campaigns import run_of
from hst_drive.diagnose.decide import diagnose
from hst_drive.rig import parse_rig
import numpy as np
import pytest

SECONDS, STOPS = 30, ((9.0, 12.0), (20.0, 24.0))


def stopped(seed, log):
    """Return what the machine is told: as ever, but nothing is asked for in between."""
    told = profiles.commands(log, 1000 * SECONDS, np.random.default_rng([seed, 5]), False)
    for begin, end in STOPS:
        for name in ('setpoint', 'manual'):
            told[name][int(1000 * begin):int(1000 * end)] = 0.0
    return told


@pytest.mark.parametrize('unit, logs', [
    (120, ('drilling', 'open_loop')),   # was line_inertance: the oil that is let go
    (122, ('open_loop',))])             # was unknown: the rock's roughness while nothing turned
def test_a_drive_that_is_stopped_is_healthy(unit, logs):
    seed = 910_060 + 1000 * unit
    made = make_campaign(
        seed, {'leakage_temperature': {'size': 1.0, 'form': 'walther'}}, duration=float(SECONDS),
        rate_hz=100.0, logs=logs, keep_exact=False, unit_seed=910_000 + unit, roughness=0.5,
        temperature='steady', command={log: stopped(seed, log) for log in logs})
    found = diagnose(parse_rig(made.sheet, 'rig'),
                     [run_of(name, columns) for name, columns in made.logs.items()])
    assert found.verdict == 'none'
