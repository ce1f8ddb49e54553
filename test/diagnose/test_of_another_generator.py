# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Effects as the author of another simulator wrote them (bench/frozen): other forms and rigs."""
from bench.frozen.make import make
from hst_drive.bag import read_log
from hst_drive.diagnose.decide import diagnose
from hst_drive.rig import default_rig, load_rig
import pytest


@pytest.mark.needs_numba
@pytest.mark.parametrize('index, name', [
    (40, 'motor_orifice_leakage'), (35, 'suction_starvation'), (56, 'accumulator')])
def test_it_is_named(tmp_path, index, name):
    truth = make(5000, index, tmp_path, 'single')
    assert truth['effects'] == [name]
    rig = tmp_path / 'rig.yaml'
    *logs, held_out = (read_log(tmp_path / f'{log}.csv') for log in (
        'drilling', 'open_loop', 'speed_sweep', 'drilling_holdout'))
    found = diagnose(load_rig(rig) if rig.exists() else default_rig(), logs, [held_out])
    assert found.verdict in ('missing_effect', 'ambiguous')
    entry, = found.effects
    assert name in (entry.id, *entry.indistinguishable_from)
