# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Campaigns of bench/unseen, another author's machines."""
from bench.unseen.campaign import find
from bench.unseen.make import write
from hst_drive.bag import read_log
from hst_drive.rig import load_rig


def unseen(seed, folder):
    """Return rig, logs and the held-out log of a campaign of bench/unseen."""
    write(find(seed), folder)
    logs = sorted(path for path in folder.glob('*.csv') if path.name != 'holdout.csv')
    return (load_rig(folder / 'rig.yaml'), [read_log(path) for path in logs],
            [read_log(folder / 'holdout.csv')])
