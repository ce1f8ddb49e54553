# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What is done with one campaign, wherever it runs; its answer is a row, also if it fails."""
from __future__ import annotations

import time
from typing import Callable

from hst_drive.errors import InputError
from hst_drive.fleet.campaigns import Campaign
from hst_drive.report.plain import plain

SCHEMA = 'hst_drive/fleet_row/1'


def row_of(campaign: Campaign, **rest: object) -> dict:
    """Return a row: what is known of a campaign, and how it ended."""
    return {'schema': SCHEMA, 'campaign': campaign.name, 'machine': campaign.machine,
            'date': campaign.date or None, 'logs': list(campaign.logs),
            'holdout': list(campaign.holdout), 'rig': campaign.rig or None, **rest}


def failed(campaign: Campaign, reason: str) -> dict:
    """Return the row of a campaign without an answer."""
    return row_of(campaign, status='failed', reason=' '.join(reason.split()), diagnosis=None)


def diagnose_campaign(campaign: Campaign, describe: Callable[[object], dict]) -> dict:
    """
    Read a campaign's logs, diagnose, and return the row.

    Parameters
    ----------
    campaign : Campaign
        Its files are read by whoever runs this: on a cluster all need the same folders.
    describe : callable
        ``Diagnosis`` to a mapping of schema hst_drive/diagnosis/1.

    """
    began, used = time.monotonic(), time.process_time()
    try:
        found = describe(_diagnosis(campaign))
    except InputError as problem:
        return failed(campaign, str(problem))
    except Exception as problem:    # one campaign must not end all others
        return failed(campaign, f'{type(problem).__name__}: {problem} (not your input)')
    return row_of(campaign, status='done', reason=None, seconds=time.monotonic() - began,
                  cpu_seconds=time.process_time() - used, diagnosis=plain(found))


def _diagnosis(campaign: Campaign):
    from hst_drive.bag.campaign import read_logs
    from hst_drive.diagnose.decide import diagnose
    from hst_drive.rig import default_rig, load_rig

    rig = load_rig(campaign.rig) if campaign.rig else default_rig()
    if not campaign.logs:
        raise InputError(f'{campaign.name}: all its logs are held out; at least one must not have '
                         "'holdout' in its name")
    runs = read_logs((*campaign.logs, *campaign.holdout), campaign.channels or None)
    return diagnose(rig, runs[:len(campaign.logs)], runs[len(campaign.logs):])
