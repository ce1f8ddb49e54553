# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What is done with one campaign, wherever it runs; its answer is a row, also if it fails."""
from __future__ import annotations

from dataclasses import replace
import math
from pathlib import Path
import time
from typing import Callable

from hst_drive.errors import InputError
from hst_drive.fleet.campaigns import Campaign

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
                  cpu_seconds=time.process_time() - used, diagnosis=_plain(found))


def _diagnosis(campaign: Campaign):
    from hst_drive.bag import load_channel_map, read_log
    from hst_drive.diagnose.decide import diagnose
    from hst_drive.measure.run import refuse_impossible
    from hst_drive.rig import default_rig, load_rig

    rig = load_rig(campaign.rig) if campaign.rig else default_rig()
    mapping = load_channel_map(campaign.channels) if campaign.channels else None
    runs = []
    for path in (*campaign.logs, *campaign.holdout):
        run = read_log(path, mapping)
        refuse_impossible(run)
        taken = any(run.name == other.name for other in runs)
        runs.append(replace(run, name=Path(path).name) if taken else run)
    if not campaign.logs:
        raise InputError(f'{campaign.name}: all its logs are held out; at least one must not have '
                         "'holdout' in its name")
    return diagnose(rig, runs[:len(campaign.logs)], runs[len(campaign.logs):])


def _plain(value: object) -> object:
    """Return a value as JSON knows it."""
    if isinstance(value, dict):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if hasattr(value, '_asdict'):
        return _plain(value._asdict())
    if hasattr(value, 'tolist'):
        return _plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value
