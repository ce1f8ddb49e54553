# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Logs of one campaign: which are files, and which are in memory."""
from hst_drive.bag.arrays import read_arrays
from hst_drive.bag.campaign import together
from hst_drive.report.provenance import provenance, TRAINING
from hst_drive.rig import load_rig
import numpy as np


def test_a_folder_that_has_the_name_of_a_log_in_memory_is_another_thing(tmp_path, monkeypatch):
    """A workspace of colcon has a folder 'log', and so are logs in memory called."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'log').mkdir()
    (tmp_path / 'log' / 'build.txt').write_text('of colcon')
    runs = [read_arrays({'time[s]': np.arange(50.0),
                         'motor_speed[rpm]': np.random.default_rng(seed).normal(size=50)})
            for seed in (1, 2)]
    assert [run.name for run in together(runs)] == ['log 1', 'log 2']
    source, = provenance(load_rig(), runs[:1], ['log'], [TRAINING], '').sources
    assert source.bytes == 2 * 50 * 8
