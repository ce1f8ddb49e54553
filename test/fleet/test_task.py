# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""One campaign of a fleet: its logs are read as those of the command line."""
import shutil

from hst_drive.bag import write_csv
from hst_drive.fleet.campaigns import find_campaigns
from hst_drive.fleet.task import diagnose_campaign
from hst_drive.rig import default_rig
from hst_drive.workbench.sample import sample_logs
import pytest


def test_a_copy_counts_only_once(tmp_path, monkeypatch):
    """A log that judges its own copy would make every answer look good."""
    folder = tmp_path / 'rig_01' / '2026-03-14'
    folder.mkdir(parents=True)
    write_csv(folder / 'log.csv', sample_logs(default_rig())[0].between(0.0, 5.0))
    shutil.copy(folder / 'log.csv', folder / 'log_holdout.csv')
    campaign, = find_campaigns(tmp_path)
    monkeypatch.setattr('hst_drive.diagnose.decide.diagnose', pytest.fail)
    row = diagnose_campaign(campaign)
    assert row['status'] == 'failed' and 'the same recording' in row['reason']
